# shellcheck shell=bash
# SPDX-License-Identifier: Apache-2.0
# Sourced by the tests of packages: a Debian that boots in a container in the current folder, and how tests report.
# Exits with code 77 where that is not possible.

cannot() { printf 'package test: %s\n' "$*" >&2; exit 77; }
((EUID == 0)) || cannot "needs root"
. "${BASH_SOURCE[0]%/*}/../bare.sh"
for tool in systemd-nspawn nsenter curl jq; do
  command -v "$tool" >/dev/null || cannot "there is no $tool"
done

# ---- reporting

begun=$EPOCHREALTIME
seconds_since() { awk -v from="$1" -v to="$EPOCHREALTIME" 'BEGIN {printf "%.1f", to - from}'; }
passed() {
  printf 'ok    %5s s  %s\n' "$(seconds_since "$begun")" "$*"
  begun=$EPOCHREALTIME
}
failed() {
  printf 'FAIL  %5s s  %s\n' "$(seconds_since "$begun")" "$*"
  if [[ -n ${leader:-} ]]; then
    inside systemctl --no-pager -n 0 status ssl-visiond || true
    inside journalctl --no-pager -n 40 -u ssl-visiond | cut -c 1-300 || true
  fi
  exit 1
}
# check WHAT COMMAND...
check() { if "${@:2}" >last.log 2>&1; then passed "$1"; else tail -n 20 last.log; failed "$1"; fi; }
# eventually SECONDS COMMAND...
eventually() {
  local until=$((SECONDS + $1))
  until "${@:2}"; do
    ((SECONDS < until)) || return 1
    sleep 0.02
  done
}
is() { [[ $1 == "$2" ]] || { printf 'expected "%s", found "%s"\n' "$2" "$1"; return 1; }; }

# ---- the container

in_folder() { chroot "$1" env DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8 "${@:2}"; }

find_leader() {
  local status
  for status in /proc/[0-9]*/status; do
    # The container's first process: a child of nspawn, pid 1 inside, and already systemd.
    if awk -v parent="$nspawn" '/^Name:/ {name = $2} /^PPid:/ {mine = $2 == parent} /^NSpid:/ {one = NF == 3 && $3 == 1}
        END {exit !(mine && one && name == "systemd")}' "$status" 2>/dev/null; then
      leader=${status#/proc/} leader=${leader%/status}
      return 0
    fi
  done
  kill -0 "$nspawn" 2>/dev/null || { tail -n 5 boot.log; cannot "systemd-nspawn does not boot here"; }
  return 1
}
inside() {
  nsenter --target "$leader" --mount --uts --ipc --net --pid --root --wd \
    env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"
}
# Runs programs of this machine in the container's network.
beside() { nsenter --target "$leader" --net "$@"; }
has_booted() { [[ $(inside systemctl is-system-running 2>/dev/null) =~ ^(running|degraded)$ ]]; }
# start [OPTION...]: boots ./machine, with these options of systemd-nspawn.
start() {
  # Containers are otherwise not allowed to query the clock.
  local options=(--system-call-filter="adjtimex clock_adjtime" "$@")
  # A host without systemd has no registry of machines.
  [[ -d /run/systemd/system ]] || options+=(--register=no --keep-unit)
  systemd-nspawn --quiet --directory machine --machine "ssl-visiond-test-$$" --private-network --boot "${options[@]}" \
    </dev/null >boot.log 2>&1 &
  nspawn=$!
  trap end EXIT
  eventually 30 find_leader || cannot "systemd-nspawn does not boot here"
  eventually 60 has_booted || { tail -n 5 boot.log; cannot "systemd does not come up in the container"; }
  passed "it has booted: systemd $(inside systemctl --version | awk 'NR == 1 {print $2}')"
}
# boot FOLDER [OPTION...]: boots a copy of this Debian.
boot() {
  umount machine/* 2>/dev/null || true
  rm -rf machine
  cp -a "$1" machine
  start "${@:2}"
}
end() {
  [[ -z ${camera:-} ]] || kill "$camera" 2>/dev/null || true
  # SIGTERM: asks the container to power off.
  kill "$nspawn" 2>/dev/null || true
  wait "$nspawn" 2>/dev/null || true
}

# ---- the service, seen from outside

unit=ssl-visiond.service
property() { inside systemctl show --value -p "$1" "$unit"; }
pid() { property MainPID; }
state() { property ActiveState; }
get() { beside curl -sS --fail --max-time 5 "http://127.0.0.1:8090$1"; }
answers() { get /api/status >/dev/null 2>&1; }
is_active() { is "$(state)" active && is "$(property SubState)" running && answers; }
