#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# shellcheck disable=SC1091,SC2034,SC2154  # machine.sh
# run.sh PACKAGES PROGRAMS FOLDER: installs the packages in the folder PACKAGES on a Debian like this one that boots
# in a container, and tests everything that admins and faults may do to it. PROGRAMS: folder with sample_client and
# fake_gige_camera. The system is kept in FOLDER for the next run. Needs root. Exit code 77: not possible here.
# TRIES: how often the service is killed (default: 5); it is made to hang half as often.
set -euo pipefail
packages=$(realpath "$1") programs=$(realpath "$2") here=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
mkdir -p "$3" && cd "$3"
tries=${TRIES:-5}
export CMAKE_GENERATOR=Ninja  # no make is needed here
. "$here/machine.sh"

service=$(echo "$packages"/ssl-visiond_*.deb) dev=$(echo "$packages"/ssl-visiond-dev_*.deb)
stages=$(echo "$packages"/ssl-visiond-stages-dev_*.deb)
[[ -e $service && -e $dev && -e $stages ]] || { echo "package test: no packages in $packages" >&2; exit 64; }

# ---- a bare Debian, and what apt needs to install the package without a network

# The packages fit the Debian that built them.
# shellcheck disable=SC1091
debian=debian-$(. /etc/os-release && echo "$VERSION_ID") codename=$(. /etc/os-release && echo "$VERSION_CODENAME")
make_debian "$codename" "$debian" systemd-sysv,dbus,udev
use_network "$debian"
cp "$service" "$dev" "$debian/root/"
fetch() {
  in_folder "$debian" apt-get -q -y --download-only install "/root/${service##*/}" &&
    in_folder "$debian" apt-get -q -y --download-only --no-install-recommends install "/root/${dev##*/}"
}
if ! fetch >fetch.log 2>&1; then
  in_folder "$debian" apt-get -q update >fetch.log 2>&1 && fetch >>fetch.log 2>&1 ||
    { tail -n 5 fetch.log; cannot "apt cannot fetch what the package needs"; }
fi
passed "what it needs is fetched: $(find "$debian/var/cache/apt/archives" -name '*.deb' | wc -l) packages"

boot "$debian"

# ---- the service, seen from outside

apt() { inside apt-get -q -y "$@"; }
ctl() { inside ssl-visionctl "$@"; }

# Older kernels show this limit only outside the container, where it is the machine's own.
limit() { inside cat /proc/sys/net/core/rmem_max 2>/dev/null || cat /proc/sys/net/core/rmem_max; }
limit_before=$(limit) || failed "the system's limit of receive buffers cannot be read"
check "apt-get install ./${service##*/}" apt install "/root/${service##*/}"
check "it is active and answers" eventually 5 is_active
check "the system's limit of receive buffers is no lower than it was" test "$(limit)" -ge "$limit_before"
check "ssl-visionlab has a page and completion" inside test -e /usr/share/man/man1/ssl-visionlab.1.gz -a \
  -e /usr/share/bash-completion/completions/ssl-visionlab
check "ssl-visionctl passes laboratory commands on" eval 'ctl bench --help | grep "ssl-visionlab bench"'
check "it is enabled" inside systemctl --quiet is-enabled "$unit"
has_user() {
  is "$(inside ps -o user= -p "$(pid)" 2>/dev/null || inside stat -c %U "/proc/$(pid)")" ssl-visiond &&
    inside id -nG ssl-visiond | grep -w video &&
    is "$(inside stat -c '%U %a' /var/lib/ssl-visiond)" "ssl-visiond 750"
}
check "it runs as ssl-visiond, of group video, with its own state folder" has_user
has_rights() { # CAP_NET_RAW is bit 13
  is "$(inside sed -n 's/^CapEff:\s*0*//p' "/proc/$(pid)/status")" 2000 &&
    is "$(inside sed -n 's/^CapBnd:\s*0*//p' "/proc/$(pid)/status")" 2000 &&
    is "$(inside sed -n 's/^NoNewPrivs:\s*//p' "/proc/$(pid)/status")" 1 &&
    is "$(inside sed -n 's/^Seccomp:\s*//p' "/proc/$(pid)/status")" 2
}
check "it has CAP_NET_RAW and no other right, and a system call filter" has_rights
check "the panel" eval 'get / | grep -q "<title>" && get /theme.js >/dev/null'
knows_its_computer() {
  get /api/diagnostics | jq -e '.system | .memory.total_bytes > 0 and .memory.available_bytes > 0 and .uptime_s > 0 and
    (.cpu_percent | length) > 0 and .disk.total_bytes > 0 and .process.rss_bytes > 0 and .process.descriptors > 0'
}
check "it sees memory, processors, disk and itself" eventually 5 knows_its_computer

knows_clock() { get /api/diagnostics | jq -e ".clock $1 null"; }
check "the clock is out of its reach" knows_clock ==
use() { # DROP-IN: as described in its first lines
  local folder=/etc/systemd/system/ssl-visiond.service.d
  inside mkdir -p "$folder" && inside cp "/usr/share/doc/ssl-visiond/examples/$1" "$folder" &&
    inside systemctl daemon-reload && inside systemctl restart "$unit"
}
check "clock.conf is put into force" use clock.conf
check "it knows about the clock" eventually 5 knows_clock !=
check "realtime.conf is put into force" use realtime.conf
may_be_realtime() { is "$(inside awk '/^Max realtime priority/ {print $4}' "/proc/$(pid)/limits")" 50; }
# CAP_SYS_RESOURCE is bit 24: without it even the container's systemd cannot raise a limit.
if inside awk '/^CapBnd:/ {exit !(substr($2, 10, 1) ~ /[13579bdf]/)}' /proc/1/status; then
  check "it may ask for priorities up to 50" may_be_realtime
else
  printf 'skip           %s\n' "its highest priority: this machine lets no container raise limits"
fi
inside rm -r /etc/systemd/system/ssl-visiond.service.d
inside systemctl daemon-reload
inside systemctl restart "$unit"

# ---- cameras and packets

settings=machine/etc/ssl-visiond/settings.json
before=$(pid)
cat machine/usr/share/doc/ssl-visiond/examples/demo.json >"$settings"
check "the admin writes two simulated cameras into the file: systemctl reload" inside systemctl reload "$unit"
has_reloaded() { is "$(get /api/status | jq '[.cameras[] | select(.state == "running")] | length')" 2 && is "$(pid)" "$before"; }
check "both run, in the same process" eventually 5 has_reloaded
listen() { beside timeout 20 "$programs/sample_client" --interface 127.0.0.1 --count "$1"; }
sends_robots() { listen 200 | grep -E -c '^  (yellow|blue) [0-9]+  x' | awk '{exit !($1 > 100)}'; }
check "teams receive robots by multicast" sends_robots

# ---- a user's stage, under the unit's limits

rm -rf kit hello && dpkg-deb -x "$stages" kit
check "find_package(SslVisiondStages) builds a library of stages" "$here/../kit/build_hello.sh" kit/usr hello
install -D -t machine/usr/local/lib/ssl-visiond/stages hello/build/hello.so
install -D -m 644 /dev/null machine/usr/local/lib/ssl-visiond/stages/broken.so
check "it is given to the service" inside systemctl restart "$unit"
has_hello() { get /api/schema | jq -e '.properties.cameras.items.properties.stack.items.enum | index("hello")'; }
check "its stage can be chosen" eventually 5 has_hello
use_hello() { ctl settings set /cameras/0/stack '["segment", "detect_robots", "detect_balls", "hello", "publish"]'; }
check "it is put into a stack" use_hello
hello_runs() { get /api/status | jq -e '.cameras[0].stages[] | select(.name == "hello") | .p50_us > 0'; }
check "it runs" eventually 5 hello_runs
names_broken() { get /api/status | jq -e '.alerts[] | select(.id == "stage_library") | .title | test("broken.so is left out")'; }
check "a broken library is named" eventually 5 names_broken
rm -r machine/usr/local/lib/ssl-visiond
install -D -t machine/usr/local/lib/ssl-visiond/stages-apart hello/build/hello.so
check "it is given to the service for a process of its own" inside systemctl restart "$unit"
stage_processes() { inside sh -c "grep -la -e '[-]-stage-process' /proc/[0-9]*/cmdline" | cut -d/ -f3; }
in_process() { [[ -n $(stage_processes) ]] && hello_runs; }
check "it runs there" eventually 5 in_process
# A bare Debian has kill only as a shell builtin.
kill_stage() { inside sh -c "kill -KILL $(stage_processes | tr '\n' ' ')"; }
check "the process is killed" kill_stage
check "another one runs" eventually 5 in_process
check "the service has gone on" hello_runs
rm -r machine/usr/local/lib/ssl-visiond kit hello
inside systemctl restart "$unit"
misses_hello() { get /api/status | jq -e '.alerts[] | select(.id == "stage_missing")'; }
check "without it the camera says what it misses" eventually 5 misses_hello
check "and runs with the rest of its stack" eventually 5 sends_robots
check "its stack is put back" ctl settings set /cameras/0/stack '["segment", "detect_robots", "detect_balls", "publish"]'
before=$(pid)

# A GigE camera: UDP broadcasts, its control channel, and images through a packet socket.
jq '.cameras[0] | {source: (.source + {pixel_format: "bayer_rg8", frame_rate_hz: 30}), calibration}' \
  machine/usr/share/doc/ssl-visiond/examples/demo.json >gige.json
beside "$programs/fake_gige_camera" 127.0.0.1 package-test gige.json >camera.log 2>&1 &
camera=$!
eventually 10 grep -q ready camera.log || failed "the fake GigE camera does not start: $(cat camera.log)"
add_gige() {
  ctl settings set /cameras/- '{"id": 7, "name": "GigE", "source": {"backend": "aravis", "camera": "127.0.0.1",
    "pixel_format": "bayer_rg8", "frame_rate_hz": 30}}'
}
check "a GigE camera is added" add_gige
gige_runs() { get /api/cameras | jq -e 'map(select(.id == 7)) | .[0] | .state == "running" and .frames > 30' >/dev/null; }
check "it delivers pictures" eventually 20 gige_runs
check "no packet socket was refused" eval '! inside journalctl -u ssl-visiond | grep -i -E "rmem_max|CAP_NET_RAW"'
kill "$camera" && wait "$camera" 2>/dev/null || true
camera=
check "the GigE camera is taken out of the settings" ctl settings remove /cameras/2
check "changed settings are saved: the field's name" ctl settings set /site "Field of the test"

set_password() { echo 'correct horse battery staple' | inside ssl-visionctl passwd; }
check "root sets the panel's password" set_password
needs_password() {
  is "$(beside curl -s -o last.json -w '%{http_code}' -X PATCH -H 'Content-Type: application/json-patch+json' -d '[]' \
    http://127.0.0.1:8090/api/settings)" 401 &&
    is "$(inside stat -c %U /var/lib/ssl-visiond/passwords.json)" ssl-visiond
}
check "from now on it is asked for, and its file is the service's own" eventually 5 needs_password
check "the password is removed" inside ssl-visionctl passwd --remove

# ---- faults of the service

# recovers SIGNAL: sends it to the process, and appends the time until a new process answers to `took`.
took=()
is_new() { local now; now=$(pid) && [[ $now != 0 && $now != "$before" ]] && answers; }
recovers() {
  local from=$EPOCHREALTIME
  before=$(pid)
  inside systemctl kill --kill-whom=main --signal="$1" "$unit"
  eventually 60 is_new || return 1
  took+=("$(seconds_since "$from")")
}
report() { # WHAT: prints median and maximum of `took`
  passed "$1, $(printf '%s\n' "${took[@]}" | sort -n |
    awk '{t[NR] = $1} END {printf "%d times: p50 %.1f s, max %.1f s", NR, t[int((NR + 1) / 2)], t[NR]}')"
  took=()
}
remembers() { get /api/recordings/clips | jq -e '.last_seconds.cameras | length == 2 and all(.seconds > 1)' >/dev/null; }
check "the cameras' last seconds are in memory" eventually 20 remembers
check "a crash: it answers again" recovers SEGV
took=()
has_crash_clip() {
  get /api/recordings/clips | jq -e '.clips | map(select(.name | endswith("_crash.clip"))) | length == 1 and
    (.[0].cameras | length == 2 and all(.frames > 20))' >/dev/null
}
check "a clip shows what the cameras saw before it" eventually 20 has_crash_clip
for ((i = 0; i < tries; i++)); do recovers KILL || failed "killed, it does not come back"; done
report "kill -9: it answers again"
for ((i = 0; i < (tries + 1) / 2; i++)); do recovers STOP || failed "hanging, it is not started anew"; done
report "a hang (SIGSTOP): the watchdog ends it, it answers again"
check "robots are sent again" sends_robots

# ---- upgrade

# The same package with a higher version.
rm -rf higher && dpkg-deb -R "$service" higher
sed -i 's/^Version: .*/Version: 99.0-1/' higher/DEBIAN/control
dpkg-deb --root-owner-group -b higher machine/root/higher.deb >/dev/null
jq '.ball_models = null' "$settings" >edited.json
cat edited.json >"$settings"
before=$(pid)
check "an upgrade" apt install /root/higher.deb
is_upgraded() {
  is "$(inside dpkg-query -W -f '${Version}' ssl-visiond)" 99.0-1 && is_new &&
    cmp "$settings" edited.json &&
    is "$(get /api/settings | jq -r '.settings.site')" "Field of the test" &&
    is "$(get /api/settings | jq -c '.settings.ball_models')" null &&
    is "$(get /api/cameras | jq length)" 2
}
check "it keeps what the panel changed and what the admin edited" eventually 10 is_upgraded

inside systemctl --quiet disable --now "$unit"
check "what is disabled is installed again" apt --reinstall install /root/higher.deb
stays_disabled() { is "$(inside systemctl is-enabled "$unit")" disabled && is "$(state)" inactive; }
check "it stays disabled" stays_disabled
inside systemctl --quiet enable --now "$unit"
check "enabled, it is back" eventually 5 is_active

# ---- bad settings

echo '{"cameras": 3}' >"$settings"
inside systemctl restart "$unit" 2>/dev/null || true
gave_up() { is "$(state)" failed && is "$(property ExecMainStatus)" 78 && is "$(property NRestarts)" 0; }
check "bad settings: exit code 78, and not tried again" eventually 5 gave_up
cat edited.json >"$settings"
inside systemctl restart "$unit"
check "mended settings: it is back" eventually 5 is_active

# ---- remove, purge

check "apt-get remove" apt remove ssl-visiond
is_removed() {
  ! answers && [[ ! -e machine/usr/bin/ssl-visiond && ! -e machine/usr/share/ssl-visiond ]] &&
    [[ -e machine/etc/ssl-visiond/settings.json && -e machine/var/lib/ssl-visiond/settings.json ]] &&
    [[ $(inside systemctl list-units --no-legend 'ssl-visiond*') != *running* ]]
}
check "it is gone, its settings are not" is_removed
check "installed again" apt install /root/higher.deb
has_settings() { is_active && is "$(get /api/settings | jq -r '.settings.site')" "Field of the test"; }
check "it has its settings again" eventually 5 has_settings
check "apt-get purge" apt purge ssl-visiond
leftovers() {
  find machine -xdev \( -path machine/root -o -path machine/proc -o -path machine/sys -o -path machine/var/log \
    -o -path machine/var/cache/apt \) -prune -o -name '*ssl*vision*' -print
}
is_purged() {
  is "$(leftovers)" "" && ! answers && inside getent passwd ssl-visiond &&
    is "$(inside dpkg-query -W -f '${db:Status-Status}' ssl-visiond 2>/dev/null || true)" ""
}
check "nothing is left of it but its user" is_purged

# ---- installation where services must not be started

printf '#!/bin/sh\nexit 101\n' >machine/usr/sbin/policy-rc.d
chmod +x machine/usr/sbin/policy-rc.d
check "installed where policy-rc.d forbids to start services" apt install "/root/${service##*/}"
check "it is not started" is "$(state)" inactive
rm machine/usr/sbin/policy-rc.d
inside systemctl start "$unit"
check "by hand it is" eventually 5 is_active
check "the teams' package is installed beside it" apt --no-install-recommends install "/root/${dev##*/}"

begun=$EPOCHREALTIME
end
trap - EXIT
leader=
check "purged in a folder without an init" in_folder machine apt-get -q -y purge ssl-visiond
check "installed in a folder without an init" \
  in_folder machine apt-get -q -y install "/root/${service##*/}"
check "it will start with the system" test -L machine/etc/systemd/system/multi-user.target.wants/ssl-visiond.service

# ---- the teams' package, used with CMake and pkg-config

rm -rf client && dpkg-deb -x "$dev" client
build_client() {
  cmake -S client/usr/share/doc/ssl-visiond-dev/examples -B client/build -DCMAKE_PREFIX_PATH="$PWD/client/usr" &&
    cmake --build client/build && { client/build/sample_client --help 2>&1 || true; } | grep -- --interface
}
check "find_package(SslVision) builds the sample client" build_client
by_pkg_config() {
  local folder
  folder=$(PKG_CONFIG_PATH=client/usr/share/pkgconfig pkg-config --define-variable=prefix=client/usr \
    --variable=protodir ssl-vision) &&
    protoc --cpp_out=client -I "$folder" ssl_vision_wrapper.proto
}
check "pkg-config says where the messages are" by_pkg_config
rm -rf machine higher client
printf 'all passed\n'
