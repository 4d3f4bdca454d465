#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# raise_limits.sh [ROOT]: raises two kernel limits for cameras; the unit runs it as root before the service. It never
# lowers a limit, and does not change one that a file or the kernel's command line sets.
set -u
root=${1:-}

# is_said PATTERN PLACE...: true if PATTERN occurs outside a comment in one of these files.
is_said() {
  said=$1
  shift
  for place; do
    if grep -rqsE "^[^#;]*$said" "$root$place"; then return 0; fi
  done
  return 1
}

# raise FILE WANTED: a value of 0 means that there is no limit.
raise() {
  now=$(cat "$root$1" 2>/dev/null) || return 0
  if [ "$now" -gt 0 ] 2>/dev/null && [ "$now" -lt "$2" ]; then
    # May fail in a container.
    echo "$2" 2>/dev/null >"$root$1" || true
  fi
}

# GigE cameras: as much as socket_buffer_bytes requests. The service itself receives through a packet socket, to which
# this limit does not apply; programs that are started by hand, without CAP_NET_RAW, need it.
is_said 'net[./]core[./]rmem_max' /etc/sysctl.conf /etc/sysctl.d /run/sysctl.d /usr/local/lib/sysctl.d \
  /usr/lib/sysctl.d /proc/cmdline || raise /proc/sys/net/core/rmem_max 4194304

# By default all USB cameras share 16 MB of pending transfers, which is one or two images of a USB3 Vision camera.
is_said 'usbfs_memory_mb' /etc/modprobe.d /run/modprobe.d /usr/lib/modprobe.d /etc/tmpfiles.d /run/tmpfiles.d \
  /usr/lib/tmpfiles.d /proc/cmdline || raise /sys/module/usbcore/parameters/usbfs_memory_mb 1000
