#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# arm64.sh FOLDER PACKAGES PACKAGE...: builds the packages for arm64 with Debian's cross compiler, in a Debian like this
# one, writes them to the folder PACKAGES and runs the unit tests with qemu-user. PACKAGE: Debian packages that the build
# needs. The system is kept in FOLDER for the next run. Needs root and a kernel that starts arm64 programs with qemu.
# Exit code 77: not possible here.
set -euo pipefail
cannot() { printf 'arm64: %s\n' "$*" >&2; exit 77; }
. "$(dirname "${BASH_SOURCE[0]}")/../bare.sh"
((EUID == 0)) || cannot "needs root"
# As installing qemu-user-static does where an init system runs; the setting is the kernel's and is lost at a restart.
update-binfmts --enable qemu-aarch64 2>/dev/null || true
grep -q '^enabled' /proc/sys/fs/binfmt_misc/qemu-aarch64 2>/dev/null ||
  cannot "the kernel cannot start arm64 programs: /proc/sys/fs/binfmt_misc/qemu-aarch64 is missing"

sources=$PWD packages=$2
# shellcheck disable=SC1091
release=$(. /etc/os-release && echo "$VERSION_CODENAME")
mkdir -p "$1" && cd "$1"
system=$release
make_debian "$release" "$system" git
use_network "$system"
enter() { enter_debian "$system" "$sources:/sources" env -C /sources HOME=/root DEBIAN_FRONTEND=noninteractive "$@"; }

# Libraries are installed for arm64, tools for this machine.
wanted=(crossbuild-essential-arm64)
for package in "${@:3}"; do
  case $package in
    g++ | libav*-dev | libsw*-dev) ;;       # the packages are built without FFmpeg
    pkg-config) wanted+=(pkgconf:arm64) ;;  # for this machine, with a link aarch64-linux-gnu-pkg-config
    *-dev) wanted+=("$package:arm64") ;;
    lib*) ;;                                # drivers
    *) wanted+=("$package") ;;
  esac
done
if [[ ! -e $system/.arm64 || $(<"$system/.arm64") != "${wanted[*]}" ]]; then
  printf 'installing a cross compiler and libraries for arm64\n'
  # shellcheck disable=SC2016  # expanded inside
  enter sh -euc 'dpkg --add-architecture arm64; apt-get -q update
    apt-get -q -y --no-install-recommends install "$@"' sh "${wanted[@]}" >install.log 2>&1 ||
    { tail -n 5 install.log >&2; cannot "apt could not install what the build needs"; }
  echo "${wanted[*]}" >"$system/.arm64"
fi

enter cmake --preset arm64
enter cmake --build --preset arm64
rm -rf "${sources:?}/$packages"
# shellcheck disable=SC2016  # expanded inside
enter env DEB_HOST_ARCH=arm64 SOURCE_DATE_EPOCH="$(git -C "$sources" log -1 --format=%ct 2>/dev/null || echo 0)" \
  cpack --config build/arm64/CPackConfig.cmake -B "/sources/$packages"
rm -r "$sources/$packages/_CPack_Packages"
enter ctest --test-dir build/arm64 --output-on-failure -j "$(nproc)" -R '^(unit.*|stages|sandbox.*|kit|dc1394)$'
