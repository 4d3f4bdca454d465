#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# fresh.sh RELEASE FOLDER: follows a new user on a bare Debian 12 or 13: clones HEAD, runs `./run demo` until the first
# image of each camera, then `./run test`. Prints a Markdown table: minutes, packages, failures. FOLDER keeps the bare
# system, its packages and the logs. Needs root and debootstrap, but no systemd.
# The clone has no history, its path has a space, its user has an empty home and no compiler cache.
# Exit code: the tests'; 64: wrong arguments; 77: a bare system cannot be made here.
set -euo pipefail

# --inside SYSTEM ARCHIVES HOME COMMAND...: the part of `enter` that runs inside the new namespaces.
if [[ ${1:-} == --inside ]]; then
  mount --rbind "$2" "$2" && cd "$2"
  mount -t proc proc proc && mount --rbind /dev dev && mount --rbind /sys sys && mount -t tmpfs tmpfs run
  mount --bind "$3" var/cache/apt/archives
  # Not chroot: processes in it cannot create namespaces, as browsers and tests do.
  mkdir old && pivot_root . old && umount -l old && rmdir old
  cd "$4/ssl-visiond"
  exec env -i HOME="$4" PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 "${@:5}"
fi

cannot() { printf 'fresh: %s\n' "$*" >&2; exit 77; }
case ${1:-} in
  12) suite=bookworm ;;
  13) suite=trixie ;;
  *) printf 'fresh: there is no Debian "%s" here: 12 or 13\n' "${1:-}" >&2; exit 64 ;;
esac
release=$1 self=$(realpath "${BASH_SOURCE[0]}")
sources=$(dirname "$self")/..
mkdir -p "$2" && cd "$2"
mirror=${DEBIAN_MIRROR:-http://deb.debian.org/debian}
((EUID == 0)) || cannot "needs root"
for tool in debootstrap git unshare pivot_root; do
  command -v "$tool" >/dev/null || cannot "there is no $tool"
done

# ---- a bare system

base=debian-$release system=system-$release logs=logs-$release
if [[ ! -e $base/.complete ]]; then
  printf 'making a bare Debian %s\n' "$release"
  rm -rf "$base"
  debootstrap --variant=minbase --include=git,ca-certificates "$suite" "$base" "$mirror" >debootstrap.log 2>&1 ||
    { tail -n 3 debootstrap.log >&2; cannot "debootstrap could not make a Debian $release"; }
  touch "$base/.complete"
fi
rm -rf "$system" "$logs"
cp -a --reflink=auto "$base" "$system"
mkdir -p "$logs" "archives-$release"
logs=$(realpath "$logs")
# Uses this machine's network settings to reach the mirrors.
cp -L /etc/resolv.conf /etc/hosts "$system/etc/"
apt-config dump Acquire | grep -E '^Acquire::(http|https|Check)[A-Za-z:-]* "..*";' >"$system/etc/apt/apt.conf.d/90host" || true
find /usr/local/share/ca-certificates -name '*.crt' -exec cp -t "$system/usr/local/share/ca-certificates" {} + 2>/dev/null || true
chroot "$system" update-ca-certificates >/dev/null 2>&1

home="/home/a stranger"
mkdir -p "$system$home"
git clone -q --depth 1 "file://$sources" "$system$home/ssl-visiond"
chroot "$system" dpkg-query -W -f '${Package}\n' | sort >"$logs/packages.before"

# enter COMMAND...: runs COMMAND in the clone; leaves no mount and no process behind.
enter() {
  unshare --mount --pid --fork --kill-child --propagation private \
    "$self" --inside "$PWD/$system" "$PWD/archives-$release" "$home" "$@"
}
# Prefixes each line with Unix time in s.
with_times() { while IFS= read -r line; do printf '%s %s\n' "$EPOCHSECONDS" "$line"; done; }

# get PATH: succeeds if the demo's panel answers with 200.
get() {
  exec 3<>/dev/tcp/127.0.0.1/8090 || return
  printf 'GET %s HTTP/1.0\r\n\r\n' "$1" >&3
  head -n 1 <&3 | grep -q ' 200 '
} 2>/dev/null

! (get /api/status) || cannot "something answers on port 8090 already, where the demo's panel will be"
printf 'demo: see %s/demo.log\n' "$logs"
began=$EPOCHSECONDS
enter ./run demo > >(with_times >"$logs/demo.log") 2>&1 &
demo=$!
until (get /api/cameras/0/snapshot.jpg) && (get /api/cameras/1/snapshot.jpg); do
  kill -0 "$demo" 2>/dev/null || { tail -n 20 "$logs/demo.log" >&2; echo "fresh: the demo ended" >&2; exit 1; }
  sleep 1
done
first_image=$EPOCHSECONDS
# unshare does not forward signals, so this signals its child, which is the service: the demo's shell execs it.
kill "$(pgrep -P "$(pgrep -P "$demo" -x unshare)")"
wait "$demo" || true

printf 'test: see %s/test.log\n' "$logs"
code=0
test_began=$EPOCHSECONDS
enter ./run test > >(with_times >"$logs/test.log") 2>&1 </dev/null || code=$?
test_ended=$EPOCHSECONDS
chroot "$system" dpkg-query -W -f '${Package}\n' | sort >"$logs/packages.after"

# ---- the table

# phases LOG END: seconds of each part that `run` announces with "== ".
phases() {
  awk -v end="$2" '$2 == "==" { if (name) print $1 - from, name; from = $1; name = $3 " " $4 " " $5 } END { if (name) print end - from, name }' "$1"
}
minutes() { awk -v s="$1" 'BEGIN {printf "%.1f", s / 60}'; }
{
  printf '| Debian %s, %s processors, %s | minutes |\n|---|---|\n' "$release" "$(nproc)" "$(git -C "$sources" rev-parse --short HEAD)"
  printf '| `./run demo` to the first image of each camera | %s |\n' "$(minutes $((first_image - began)))"
  phases "$logs/demo.log" "$first_image" | while read -r s name; do printf '| - %s | %s |\n' "$name" "$(minutes "$s")"; done
  printf '| `./run test` after that | %s |\n' "$(minutes $((test_ended - test_began)))"
  phases "$logs/test.log" "$test_ended" | while read -r s name; do ((s < 3)) || printf '| - %s | %s |\n' "$name" "$(minutes "$s")"; done
  printf '\n%s packages more than before, of which `run` names: %s\n\n' \
    "$(comm -13 "$logs/packages.before" "$logs/packages.after" | wc -l)" \
    "$(cat "$logs/demo.log" "$logs/test.log" | sed -n 's/^[0-9]* == installing //p' | tr '\n' ' ')"
  sed -nE 's/^[0-9]+ (FAILED: .*|[0-9]+ passed, [0-9]+ failed.*)/\1/p' "$logs/test.log"
} | tee "$logs/table.md"
exit "$code"
