# shellcheck shell=bash
# SPDX-License-Identifier: Apache-2.0
# Sourced by scripts that need a bare Debian in a folder. They define `cannot WHY`, which ends them.

# make_debian RELEASE FOLDER PACKAGES: a minimal Debian, or Ubuntu (jammy, noble), with PACKAGES (separated by commas);
# kept for the next run.
make_debian() {
  local mirror=${DEBIAN_MIRROR:-http://deb.debian.org/debian} options=() script=()
  [[ ! -e $2/.complete ]] || return 0
  command -v debootstrap >/dev/null || cannot "there is no debootstrap"
  case $1 in
    jammy | noble)
      # Debian has no package with Ubuntu's keys. These systems only run tests, in containers.
      mirror=${UBUNTU_MIRROR:-http://archive.ubuntu.com/ubuntu} options=("--components=main,universe" --no-check-gpg)
      script=(/usr/share/debootstrap/scripts/gutsy) ;;  # as for all since then; older debootstraps do not know noble
  esac
  printf 'making a bare system (%s)\n' "$1"
  rm -rf "$2"
  debootstrap --variant=minbase --include="ca-certificates,$3" "${options[@]}" "$1" "$2" "$mirror" \
    "${script[@]}" >debootstrap.log 2>&1 || { tail -n 3 debootstrap.log >&2; cannot "debootstrap could not make $1"; }
  touch "$2/.complete"
}

# use_network FOLDER: the Debian in FOLDER reaches mirrors with this machine's settings.
use_network() {
  cp -L /etc/resolv.conf /etc/hosts "$1/etc/"
  apt-config dump Acquire | grep -E '^Acquire::(http|https|ftp|Check|Max)[A-Za-z:-]* "..*";' >"$1/etc/apt/apt.conf.d/90host" || true
  find /usr/local/share/ca-certificates -name '*.crt' -exec cp -t "$1/usr/local/share/ca-certificates" {} + 2>/dev/null || true
  chroot "$1" update-ca-certificates >/dev/null 2>&1
}

# enter_debian FOLDER OUTSIDE:INSIDE COMMAND...: runs COMMAND in the Debian in FOLDER, where the folder OUTSIDE is mounted
# as INSIDE, with an environment of only PATH and LC_ALL. Leaves no mount and no process behind.
enter_debian() {
  # shellcheck disable=SC2016  # expanded by the inner shell
  unshare --mount --pid --fork --kill-child --propagation private bash -euc '
    outside=$(realpath "${2%:*}") inside=${2#*:}
    mount --rbind "$1" "$1" && cd "$1"
    mount -t proc proc proc && mount --rbind /dev dev && mount --rbind /sys sys && mount -t tmpfs tmpfs run
    mkdir -p ".$inside" && mount --bind "$outside" ".$inside"
    # Not chroot: processes in it cannot create namespaces, as browsers and tests do.
    mkdir old && pivot_root . old && umount -l old && rmdir old
    exec env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 "${@:3}"' bash "$@"
}
