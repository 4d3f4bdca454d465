#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# check_limits.sh FOLDER: installs FOLDER's package and starts its service on computers with various limits, each
# represented by a folder. The maintainer script is the real one; of systemd, only what the script uses is faked.
set -euo pipefail
folder=$(realpath "$1")
computer=$(mktemp -d)
trap 'rm -rf "$computer"' EXIT
rmem=$computer/proc/sys/net/core/rmem_max
usbfs=$computer/sys/module/usbcore/parameters/usbfs_memory_mb
failed=0

# Programs that the script calls. Those that change limits do so on the simulated computer.
programs=$computer/programs
mkdir "$programs"
for name in systemd-sysusers deb-systemd-helper deb-systemd-invoke systemctl udevadm; do
  printf '#!/bin/sh\nexit 0\n' >"$programs/$name"
done
cat >"$programs/systemd-sysctl" <<TXT
#!/bin/sh
for file; do
  sed -nE 's/^(net.core.rmem_max) *= *([0-9]+)/\2/p' "$computer\$file" >"$rmem.new"
  [ ! -s "$rmem.new" ] || cp "$rmem.new" "$rmem"
done
TXT
cat >"$programs/systemd-tmpfiles" <<TXT
#!/bin/sh
cat "$computer"/usr/lib/tmpfiles.d/*.conf | awk '\$1 == "w-" {print \$7}' >"$usbfs.new"
[ ! -s "$usbfs.new" ] || cp "$usbfs.new" "$usbfs"
TXT
chmod +x "$programs"/*

# installed RMEM USBFS [FILE LINE]: installs the package on a computer with these limits and a file of the admin's.
installed() {
  rm -rf "${computer:?}"/{proc,sys,etc,run,usr}
  mkdir -p "${rmem%/*}" "${usbfs%/*}" "$computer"/{etc/sysctl.d,etc/modprobe.d,run/systemd/system,usr/lib/sysctl.d,usr/lib/tmpfiles.d}
  echo "$1" >"$rmem"
  echo "$2" >"$usbfs"
  printf 'BOOT_IMAGE=/vmlinuz quiet\n' >"$computer/proc/cmdline"
  if [[ -n ${3:-} ]]; then printf '%s\n' "$4" >>"$computer/$3"; fi
  # The package's files.
  [[ ! -e $folder/sysctl.conf ]] || cp "$folder/sysctl.conf" "$computer/usr/lib/sysctl.d/30-ssl-visiond.conf"
  [[ ! -e $folder/tmpfiles.conf ]] || cp "$folder/tmpfiles.conf" "$computer/usr/lib/tmpfiles.d/ssl-visiond.conf"
  sed "s|/run/systemd/system|$computer&|; s|/lib/systemd/systemd-sysctl|systemd-sysctl|" "$folder/debian/postinst" >"$computer/postinst"
  PATH=$programs:$PATH sh "$computer/postinst" configure ""
  starts
}
# Starts the service with its unit's ExecStartPre.
starts() {
  local before
  before=$(sed -nE 's/^ExecStartPre=-?\+\/usr\/lib\/ssl-visiond\/raise-limits$/raise_limits.sh/p' "$folder/ssl-visiond.service")
  [[ -z $before ]] || sh "$folder/$before" "$computer"
}
# leaves RMEM USBFS WHAT
leaves() {
  local now
  now="$(cat "$rmem") $(cat "$usbfs")"
  if [[ $now == "$1 $2" ]]; then return; fi
  printf '%s: rmem_max and usbfs_memory_mb are %s; expected %s %s\n' "$3" "$now" "$1" "$2" >&2
  failed=1
}

installed 212992 16 && leaves 4194304 1000 "a Debian as it comes"
installed 33554432 2000 && leaves 33554432 2000 "more, set by hand"
installed 33554432 0 && leaves 33554432 0 "no limit for USB"
installed 33554432 16 etc/sysctl.d/10-cameras.conf 'net.core.rmem_max = 33554432' && leaves 33554432 1000 "more, in a file"
installed 1048576 16 etc/sysctl.d/90-small.conf 'net.core.rmem_max=1048576' && leaves 1048576 1000 "less, in a file"
installed 1048576 16 etc/sysctl.conf 'net/core/rmem_max=1048576' && leaves 1048576 1000 "less, in the old file"
installed 212992 16 etc/sysctl.conf '# net.core.rmem_max=1048576' && leaves 4194304 1000 "a comment"
installed 212992 256 proc/cmdline 'quiet usbcore.usbfs_memory_mb=256' && leaves 4194304 256 "less, for the kernel's start"
installed 212992 256 etc/modprobe.d/usb.conf 'options usbcore usbfs_memory_mb=256' && leaves 4194304 256 "less, for the module"
installed 212992 16 && echo 8388608 >"$rmem" && echo 3000 >"$usbfs" && starts && leaves 8388608 3000 "raised by hand since, and started again"
installed unreadable 16 && leaves unreadable 1000 "what is no number"
rm -r "$computer/proc/sys" "$computer/sys" && starts # a container has neither
exit "$failed"
