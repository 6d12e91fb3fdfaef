#!/usr/bin/env bash
# container.sh [PACKAGES]: builds packaging/Containerfile with buildah, its steps in a chroot, from a bare Debian 12 of debootstrap,
# so that neither a daemon nor a registry of images is needed; then runs the image's program. With PACKAGES, a folder of Debian
# packages that are built, the first stage takes those instead of compiling. Needs root, buildah, debootstrap, the network.
# ATWOOD_BARE_ROOT: a bare root that is there already; otherwise one is made.
set -euo pipefail
for tool in buildah debootstrap; do
  command -v "$tool" >/dev/null || { apt-get update -qq && apt-get install -y -qq --no-install-recommends "$tool"; }
done
packages=${1:+$(readlink -f "$1")}
source=$(cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../../.." && pwd)
work=$(mktemp -d)
trap 'buildah_ umount --all >/dev/null 2>&1 || true; rm -rf "$work"' EXIT
buildah_() { buildah --storage-driver vfs --root "$work/storage" --runroot "$work/run" "$@"; }

root=${ATWOOD_BARE_ROOT:-$work/root}
if [ ! -d "$root/usr" ]; then debootstrap --variant=minbase bookworm "$root" >/dev/null; fi
base=$(buildah_ from scratch)
tar -C "$root" --exclude='./var/cache/apt/archives/*.deb' --exclude=./proc --exclude=./packages --exclude=./work -cf "$work/root.tar" .
buildah_ add -q "$base" "$work/root.tar" / >/dev/null
rm "$work/root.tar"
buildah_ commit -q "$base" docker.io/library/debian:12 >/dev/null
buildah_ tag docker.io/library/debian:12 docker.io/library/debian:12-slim

context=$source
if [ -n "$packages" ]; then
  context=$work/context
  mkdir -p "$context/packages"
  cp "$packages"/*.deb "$context/packages"
  printf '#!/bin/sh\nset -e\n[ "$*" = package ]\nmkdir -p build/release\nmv packages build/release/packages\n' >"$context/atwood"
  chmod +x "$context/atwood"
fi
buildah_ bud --isolation chroot --pull-never -q --ignorefile "$source/packaging/Containerfile.dockerignore" \
  -f "$source/packaging/Containerfile" -t atwood "$context" >/dev/null
echo "built: $(buildah_ images --format '{{.Name}} {{.Size}}' atwood)"

made=$(buildah_ from --pull-never localhost/atwood)
said=$(buildah_ inspect --format '{{.OCIv1.Config.Entrypoint}} {{.OCIv1.Config.Cmd}} {{.OCIv1.Config.WorkingDir}}' "$made")
[ "$said" = "[atwood] [run] /work" ] || { echo "found entry point, command, folder: $said" >&2; exit 1; }
inside() { buildah_ run --isolation chroot "$made" -- "$@"; }
inside atwood run --quiet --no-timing --scenario ballistic --method atwood/rk4 --method bullet64/default
inside test -s atwood-out/report.html
left=$(inside sh -c 'ls -A /tmp /var/lib/apt/lists | grep -v ":$"; ls -d /src /usr/include/atwood /usr/bin/g++ 2>/dev/null; true' |
  tr -d '\n')
[ -z "$left" ] || { echo "left in the image: $left" >&2; exit 1; }
echo "ran: the image's program; neither sources, compilers nor lists of packages are in it"
