#!/usr/bin/env bash
# The steps of action.yml:
#
#   action.sh key      key=HASH of the sources, and baseline=HASH of what a baseline belongs to (ATWOOD_STUDY,
#                      ATWOOD_ARGUMENTS, ATWOOD_BASELINE), to GITHUB_OUTPUT
#   action.sh install  installs ATWOOD_PACKAGE, or builds Atwood from these sources
#   action.sh run      runs ATWOOD_STUDY and judges it by its gates and the baseline; blessed=true, to GITHUB_OUTPUT,
#                      where its rows became the baseline: there was none, or ATWOOD_BLESS gives a reason. With
#                      ATWOOD_MAY_BLESS=false no rows become one, and the baseline judges whatever ATWOOD_BLESS says
set -euo pipefail
root=$(cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/.." && pwd)
output=${GITHUB_OUTPUT:-/dev/stdout}

as_root() { if [ "$(id -u)" -eq 0 ]; then "$@"; else sudo "$@"; fi; }

key() {
  local sources baseline
  sources=$(cd "$root" && find CMakeLists.txt atwood benchmarks engine packaging reference reports validation -type f |
    LC_ALL=C sort | xargs -d '\n' sha256sum | sha256sum)
  baseline=$(printf '%s\0' "$ATWOOD_STUDY" "$ATWOOD_ARGUMENTS" "$ATWOOD_BASELINE" | sha256sum)
  echo "key=${sources%% *}" >>"$output"
  echo "baseline=${baseline%% *}" >>"$output"
}

install() {
  if [ -z "${ATWOOD_PACKAGE:-}" ]; then
    "$root/atwood" doctor
    return
  fi
  local packages=() package folder file
  folder=$(mktemp -d)
  as_root apt-get update -qq
  for package in $ATWOOD_PACKAGE; do
    case "$package" in
      https://*)
        as_root apt-get install -y -qq --no-install-recommends curl ca-certificates
        file=${package%%[?#]*}
        file=$folder/${file##*/}
        curl -fsSL --proto =https -o "$file" "$package"
        packages+=("$file")
        ;;
      *) packages+=("$(readlink -f "$package")") ;;
    esac
  done
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${packages[@]}"
}

run() {
  local atwood=${ATWOOD_PROGRAM:-} known=() arguments=() code=0 may_bless=${ATWOOD_MAY_BLESS:-true}
  if [ -z "$atwood" ]; then atwood=$(command -v atwood || echo "$root/atwood"); fi
  if [ -s "$ATWOOD_BASELINE" ] && { [ -z "$ATWOOD_BLESS" ] || [ "$may_bless" != true ]; }; then
    known=(--baseline "$ATWOOD_BASELINE")
  fi
  # xargs takes quotes and backslashes as a shell does, and expands nothing.
  mapfile -d '' -t arguments < <(xargs -r printf '%s\0' <<<"$ATWOOD_ARGUMENTS")
  wait $! || { echo "action.sh: the arguments have an unmatched quote: $ATWOOD_ARGUMENTS" >&2; exit 2; }
  mkdir -p "$ATWOOD_OUT"
  "$atwood" run "$ATWOOD_STUDY" "${arguments[@]}" --out "$ATWOOD_OUT" --junit "$ATWOOD_OUT/verdicts.xml" --github \
    "${known[@]}" || code=$?
  if [ "$code" -ne 0 ] || [ ${#known[@]} -gt 0 ]; then exit "$code"; fi
  if [ "$may_bless" != true ]; then
    echo "no baseline is kept yet: the first run outside a pull request makes it"
    exit 0
  fi
  local selection=() word take=
  # What narrows the study narrows its baseline: the options that `run` and `bless` share, but --out.
  for word in "${arguments[@]}"; do
    case "$word" in
      --scenario=* | --filter=* | --method=* | --steps=* | --hz=* | --engine=*) selection+=("$word"); take= ;;
      --spacing=* | --sound-speed=* | --max-cells=*) selection+=("$word"); take= ;;
      --scenario | --filter | --method | --steps | --hz | --engine) selection+=("$word"); take=yes ;;
      --spacing | --sound-speed | --max-cells) selection+=("$word"); take=yes ;;
      *) if [ -n "$take" ]; then selection+=("$word"); fi; take= ;;
    esac
  done
  "$atwood" bless "$ATWOOD_STUDY" "${selection[@]}" --out "$ATWOOD_OUT" --baseline "$ATWOOD_BASELINE" \
    --reason "${ATWOOD_BLESS:-the first run}"
  echo "blessed=true" >>"$output"
}

case "${1:-}" in
  key | install | run) "$1" ;;
  *) echo "action.sh: expected key, install or run" >&2; exit 2 ;;
esac
