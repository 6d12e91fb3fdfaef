#!/usr/bin/env bash
# set_up.sh BUILD_DIR: installs the packages of this folder's lock file to BUILD_DIR/node, where the workers find them.
# Needs node 18.3 or newer, npm and, when something is to be installed, the network; the workers need none.
set -euo pipefail

here=$(cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")" && pwd)
to=${1:?set_up.sh BUILD_DIR}/node

if cmp -s "$here/package-lock.json" "$to/installed-lock.json"; then exit 0; fi
rm -rf "$to"
mkdir -p "$to"
cp "$here/package.json" "$here/package-lock.json" "$to"
(cd "$to" && npm ci --ignore-scripts --no-audit --no-fund --loglevel=error)
cp "$here/package-lock.json" "$to/installed-lock.json"
