#!/usr/bin/env bash
# bare_root.sh PACKAGES [ROOT]: installs the Debian packages of a folder on a bare Debian 12 (debootstrap, variant minbase) with
# apt, runs `atwood run`, builds the C++ worker against atwood-dev, removes all again. Needs root, debootstrap, the network.
# ROOT: a bare root that is there already; a fresh one is made, and removed at the end, without it. ATWOOD_BARE_RUN: options that
# narrow the default study, of which all is run without them.
set -euo pipefail
packages=$(readlink -f "${1:?bare_root.sh PACKAGES [ROOT]}")
root=${2:-}
if [ -z "$root" ]; then
  command -v debootstrap >/dev/null || { apt-get update -qq && apt-get install -y -qq --no-install-recommends debootstrap; }
  made=$(mktemp -d)
  root=$made/root
fi
mounted=
clean_up() {
  if [ -n "$mounted" ]; then umount "$root/proc"; fi
  if [ -n "${made:-}" ]; then rm -rf "$made"; fi
}
trap clean_up EXIT
if [ -n "${made:-}" ]; then debootstrap --variant=minbase bookworm "$root" >/dev/null; fi
inside() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root DEBIAN_FRONTEND=noninteractive "$@"; }

mkdir -p "$root/packages" "$root/proc"
cp "$packages"/*.deb "$root/packages"
cp /etc/resolv.conf "$root/etc/resolv.conf"
mount -t proc proc "$root/proc"
mounted=yes
inside apt-get update -qq
inside apt-get install -y -qq --no-install-recommends $(cd "$root" && ls ./packages/atwood_*.deb) >/dev/null
echo "installed: $(inside dpkg-query -W | wc -l) packages, $(inside atwood --version)"
for page in index.html reference/methods.html; do  # the manual as a site, the program's own pages in it
  [ "$(wc -c <"$root/usr/share/atwood/manual/$page")" -gt 5000 ] || { echo "the manual's $page is missing or a stub" >&2; exit 1; }
done
inside sh -c 'rm -rf /work && mkdir /work && cd /work && atwood doctor && atwood run --quiet --limit 300 '"${ATWOOD_BARE_RUN:-}"  # the machine may be busy
test -s "$root/work/atwood-out/report.html"

for optional in "$root"/packages/atwood-{dart,mujoco,simbody,node-engines}_*.deb; do
  [ -e "$optional" ] || continue
  package=${optional##*/}
  package=${package%%_*}
  engines=${package#atwood-}
  if [ "$package" = atwood-node-engines ]; then engines="rapier jolt mujoco3"; fi
  inside apt-get install -y -qq --no-install-recommends "./packages/${optional##*/}" >/dev/null
  for engine in $engines; do
    inside sh -c "cd /work && atwood run --quiet --no-timing --scenario ballistic --method '$engine/*' -o csv:$engine.csv"
    grep -q ",ok," "$root/work/$engine.csv"
  done
  echo "installed: $package, which runs $engines"
done

if ls "$root"/packages/atwood-dev_*.deb >/dev/null 2>&1; then
  inside apt-get install -y -qq --no-install-recommends "$(cd "$root" && ls ./packages/atwood-dev_*.deb)" cmake make g++ >/dev/null
  inside sh -c 'cmake -S /usr/share/atwood/reference/your_engine/cpp -B /work/cpp && cmake --build /work/cpp' >/dev/null
  inside sh -c 'cd /work && atwood run --quiet --no-timing --engine cpp/my-engine --scenario ballistic --method "cpp/*" -o csv:cpp.csv'
  grep -q ",ok," "$root/work/cpp.csv"
  echo "built: an engine against atwood-dev"
fi

inside apt-get purge -y -qq 'atwood*' >/dev/null
left=$(find "$root/usr" -path '*atwood*' | head)
[ -z "$left" ] || { echo "left behind: $left" >&2; exit 1; }
echo "removed: nothing is left"
