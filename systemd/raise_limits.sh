#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# raise_limits.sh [ROOT]: the unit runs it as root before the service. Raises two of the kernel's limits that cameras
# need more of. What an admin has set, to whatever, in a file, for the kernel's start or by hand, is never lowered, and
# what a file says is left to that file.
set -u
root=${1:-}

# is_said PATTERN PLACE...: a file there has a line with it that is no comment.
is_said() {
  said=$1
  shift
  for place; do
    if grep -rqsE "^[^#;]*$said" "$root$place"; then return 0; fi
  done
  return 1
}

# raise FILE WANTED: 0 there means that there is no limit.
raise() {
  now=$(cat "$root$1" 2>/dev/null) || return 0
  if [ "$now" -gt 0 ] 2>/dev/null && [ "$now" -lt "$2" ]; then
    # A container may not do it.
    echo "$2" 2>/dev/null >"$root$1" || true
  fi
}

# GigE cameras: as much as socket_buffer_bytes asks for. The service itself receives through a packet socket, which
# needs none of it; this is for whatever is started by hand, without CAP_NET_RAW.
is_said 'net[./]core[./]rmem_max' /etc/sysctl.conf /etc/sysctl.d /run/sysctl.d /usr/local/lib/sysctl.d \
  /usr/lib/sysctl.d /proc/cmdline || raise /proc/sys/net/core/rmem_max 4194304

# The kernel lets all USB cameras together have 16 MB under way, which is one or two images of a USB3 Vision camera.
is_said 'usbfs_memory_mb' /etc/modprobe.d /run/modprobe.d /usr/lib/modprobe.d /etc/tmpfiles.d /run/tmpfiles.d \
  /usr/lib/tmpfiles.d /proc/cmdline || raise /sys/module/usbcore/parameters/usbfs_memory_mb 1000
