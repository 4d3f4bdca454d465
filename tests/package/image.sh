#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# shellcheck disable=SC1091,SC2034,SC2154  # machine.sh
# image.sh IMAGE PROGRAMS FOLDER RELEASE...: attaches the portable service IMAGE (its ssl-visionctl is beside it) on
# Debian RELEASEs (bullseye, trixie) that boot in a container: GO, restart, reboot, upgrade, detach. PROGRAMS: folder
# with sample_client. The systems are kept in FOLDER for the next run. Needs root and loop devices. Exit code 77: not
# possible here.
set -euo pipefail
image=$(realpath "$1") programs=$(realpath "$2") here=$(realpath "$(dirname "${BASH_SOURCE[0]}")") releases=("${@:4}")
mkdir -p "$3" && cd "$3"
. "$here/machine.sh"
[[ -e /dev/loop-control ]] || cannot "there are no loop devices"
command -v unsquashfs >/dev/null || cannot "there is no unsquashfs"
megabytes=$(du -m --apparent-size "$image" | cut -f 1)
check "the image is small, $megabytes MB" test "$megabytes" -le 120

options=(--bind=/dev/loop-control --property=DeviceAllow="block-loop rwm" --property=DeviceAllow="/dev/loop-control rwm")
# be_computer: adds to the container what only real computers have: loop devices that udev knows, and a /run/host that
# systemd can write to for the service.
be_computer() {
  inside sh -c 'umount --lazy /run/host; rm -f /run/host/os-release; mkdir -p /run/udev/data
    for i in 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15; do mknod "/dev/loop$i" b 7 "$i"; echo I:1 >"/run/udev/data/b7:$i"; done'
}

# The same image with a higher version.
rm -rf higher && unsquashfs -q -n -d higher "$image" >/dev/null
sed -i 's/^IMAGE_VERSION=.*/IMAGE_VERSION=99.0-1/' higher/usr/lib/os-release
sed -i 's/^Description=.*/& 99/' higher/usr/lib/systemd/system/ssl-visiond.service
mksquashfs higher higher.raw -noappend -quiet -no-progress -comp gzip >/dev/null && rm -rf higher

is_version() { get /api/status >/dev/null && is "$(property Description)" "Vision service for RoboCup Small Size League fields$1"; }
is_go() { get /api/status | jq -e .go; }
has_rights() { # CAP_NET_RAW is bit 13
  [[ $(inside stat -c %u "/proc/$(pid)") != 0 ]] && is "$(inside sed -n 's/^CapEff:\s*0*//p' "/proc/$(pid)/status")" 2000 &&
    is "$(inside sed -n 's/^Seccomp:\s*//p' "/proc/$(pid)/status")" 2
}
sends_robots() {
  beside timeout 20 "$programs/sample_client" --interface 127.0.0.1 --count 200 | grep -E -c '^  (yellow|blue) [0-9]+  x' |
    awk '{exit !($1 > 100)}'
}
patch() {
  beside curl -sS -o /dev/null -w '%{http_code}' -X PATCH -H 'Content-Type: application/json-patch+json' -d "$1" \
    http://127.0.0.1:8090/api/settings
}
set_site() { is "$(patch '[{"op": "replace", "path": "/site", "value": "Field of the test"}]')" 200; }
set_password() { echo 'correct horse battery staple' | inside /root/ssl-visionctl passwd; }
needs_password() { is "$(patch '[]')" 401; }
has_site() { is "$(get /api/settings | jq -r .settings.site)" "Field of the test"; }
# On a busy machine portablectl's default timeout of 25 s is too short. In systemd 247 only systemctl disables units.
portable() { inside env SYSTEMD_BUS_TIMEOUT=300s portablectl "$@"; }
detach() { inside systemctl disable --now "$unit" && portable detach ssl-visiond; }
is_new() { local now; now=$(pid) && [[ $now != 0 && $now != "$before" ]] && answers; }

for release in "${releases[@]}"; do
  make_debian "$release" "$release" systemd-sysv,systemd-container,dbus,udev
  boot "$release" "${options[@]}"
  be_computer
  inside mkdir -p /etc/ssl-visiond /var/lib/portables
  cp "$image" machine/var/lib/portables/ssl-visiond.raw
  cp "$(dirname "$image")/ssl-visionctl" machine/root
  cp "$here/../../config/demo.json" machine/etc/ssl-visiond/settings.json

  check "$release: portablectl attach" portable attach --profile=trusted ssl-visiond
  check "it is enabled and started" inside systemctl enable --now "$unit"
  check "it is active and answers" eventually 300 is_active
  check "it runs without root, with CAP_NET_RAW and no other right" has_rights
  check "the panel" eval 'get / | grep -q "<title>"'
  check "GO, with the settings of the host" eventually 300 is_go
  check "teams receive robots by multicast" sends_robots
  check "the field's name is changed" set_site

  check "ssl-visionctl of the image" eval 'inside /root/ssl-visionctl status | grep "Field of the test"'
  check "it sets a password" set_password
  check "which is asked for" eventually 300 needs_password
  check "and removes it" inside /root/ssl-visionctl passwd --remove

  before=$(pid)
  inside systemctl kill --kill-who=main --signal=KILL "$unit"
  check "killed, it is back" eventually 300 is_new

  end
  start "${options[@]}"
  be_computer
  check "after a restart of the computer it is back" eventually 300 is_active
  check "with its settings" has_site

  check "portablectl detach" detach
  cp higher.raw machine/var/lib/portables/ssl-visiond.raw
  check "a newer image is attached" portable attach --profile=trusted --enable --now ssl-visiond
  check "it runs" eventually 300 is_version " 99"
  check "with its settings" has_site

  check "detached" detach
  is_detached() { ! answers && ! inside systemctl cat "$unit" 2>/dev/null; }
  check "nothing of it runs" is_detached
  end
  trap - EXIT
  leader=
done
rm -rf machine higher.raw
printf 'all passed\n'
