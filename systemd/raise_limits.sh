#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# raise_limits.sh [ROOT]: run by the unit as root before the service. Raises two kernel limits for cameras. It never
# lowers a value, whether an admin set it in a file, on the kernel's command line or by hand, and does not touch a
# limit that a file or the command line sets.
set -u
root=${1:-}

# is_said PATTERN PLACE...: true if one of the files has a line with it outside a comment.
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

# GigE cameras: as much as socket_buffer_bytes requests. The service itself receives through a packet socket, which
# needs none of it; this is for programs started by hand, without CAP_NET_RAW.
is_said 'net[./]core[./]rmem_max' /etc/sysctl.conf /etc/sysctl.d /run/sysctl.d /usr/local/lib/sysctl.d \
  /usr/lib/sysctl.d /proc/cmdline || raise /proc/sys/net/core/rmem_max 4194304

# By default all USB cameras share 16 MB of pending transfers, which is one or two images of a USB3 Vision camera.
is_said 'usbfs_memory_mb' /etc/modprobe.d /run/modprobe.d /usr/lib/modprobe.d /etc/tmpfiles.d /run/tmpfiles.d \
  /usr/lib/tmpfiles.d /proc/cmdline || raise /sys/module/usbcore/parameters/usbfs_memory_mb 1000
