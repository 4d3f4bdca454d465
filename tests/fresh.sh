#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# fresh.sh RELEASE FOLDER: follows a new user on a bare Debian 12 or 13: clones HEAD, runs `./run demo` until the first
# image of each camera, then `./run test`. Prints a Markdown table: minutes, packages, failures. FOLDER keeps the bare
# system, its packages and the logs. Needs root and debootstrap, but no systemd.
# The clone has no history, its path has a space, its user has an empty home and no compiler cache.
# Exit code: the tests'; 64: wrong arguments; 77: a bare system cannot be made here.
set -euo pipefail

cannot() { printf 'fresh: %s\n' "$*" >&2; exit 77; }
# shellcheck source=tests/bare.sh
. "$(dirname "${BASH_SOURCE[0]}")/bare.sh"
case ${1:-} in
  12) suite=bookworm ;;
  13) suite=trixie ;;
  *) printf 'fresh: there is no Debian "%s" here: 12 or 13\n' "${1:-}" >&2; exit 64 ;;
esac
release=$1 sources=$(realpath "$(dirname "${BASH_SOURCE[0]}")/..")
mkdir -p "$2" && cd "$2"
((EUID == 0)) || cannot "needs root"

base=debian-$release system=system-$release logs=logs-$release
make_debian "$suite" "$base" git
rm -rf "$system" "$logs"
cp -a --reflink=auto "$base" "$system"
mkdir -p "$logs" "archives-$release"
logs=$(realpath "$logs")
use_network "$system"

home="/home/a stranger"
mkdir -p "$system$home"
git clone -q --depth 1 "file://$sources" "$system$home/ssl-visiond"
chroot "$system" dpkg-query -W -f '${Package}\n' | sort >"$logs/packages.before"

enter() {
  enter_debian "$system" "archives-$release:/var/cache/apt/archives" \
    env -C "$home/ssl-visiond" HOME="$home" "$@"
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
