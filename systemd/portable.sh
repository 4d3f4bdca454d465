#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# portable.sh PACKAGE FOLDER: makes FOLDER/ssl-visiond.raw from the Debian package: a portable service, which any Linux
# with systemd 247 or newer can run without installing it (docs/operating.md), and files for its admin. Needs root,
# debootstrap and mksquashfs, and a mirror of Debian.
set -euo pipefail
package=$(realpath "$1") folder=$(realpath -m "$2") root=$(realpath -m "$2")/root
unit=$root/usr/lib/systemd/system/ssl-visiond.service
# shellcheck disable=SC1091
release=$(. /etc/os-release && echo "$VERSION_CODENAME")  # the package is built for this machine's Debian

rm -rf "$folder" && mkdir -p "$root"
debootstrap --variant=minbase --include=ca-certificates,systemd-standalone-sysusers "$release" "$root" \
  "${DEBIAN_MIRROR:-http://deb.debian.org/debian}" >"$folder/debootstrap.log" 2>&1 ||
  { tail -n 5 "$folder/debootstrap.log" >&2; exit 1; }
apt-config dump Acquire | grep -E '^Acquire::(http|https|ftp)[A-Za-z:-]* "..*";' >"$root/etc/apt/apt.conf.d/90host" || true
cp "$package" "$root/package.deb"
chroot "$root" env DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8 \
  apt-get -q -y --no-install-recommends install /package.deb >"$folder/install.log" 2>&1 ||
  { tail -n 5 "$folder/install.log" >&2; exit 1; }

# Its user exists only while it runs: the host has no package that could create one. Without the package, the host also
# lacks the slice and the script that raises limits as root, so the unit must not use them.
sed -i -e '/^# Runs as root, unlike the service/d; /^ExecStartPre=/d' \
  -e 's/^User=ssl-visiond$/DynamicUser=yes\nUser=ssl-visiond\nSupplementaryGroups=video/; /^Group=/d' \
  -e '/^# Its slice gets/d; s/^Slice=.*/CPUWeight=1000\nIOWeight=1000/' \
  -e 's!^\[Install\]!# The settings and stages of the host, if it has any.\nBindReadOnlyPaths=-/etc/ssl-visiond -/usr/local/lib/ssl-visiond\n\n&!' "$unit"
printf 'PORTABLE_PREFIXES=ssl-visiond\nIMAGE_ID=ssl-visiond\nIMAGE_VERSION=%s\n' \
  "$(dpkg-deb -f "$package" Version)" >>"$root/usr/lib/os-release"

# The image is read-only, so it must contain the mount points that systemd needs.
mkdir -p "$root"/{dev,proc,sys,run,tmp,var/tmp,var/lib/private,var/lib/ssl-visiond,usr/local/lib/ssl-visiond}
rm -f "$root"/etc/{machine-id,resolv.conf} && touch "$root"/etc/{machine-id,resolv.conf}

# Removes package management and texts other than licences.
(cd "$root" && rm -rf package.deb {boot,home,media,mnt,root,srv}/* var/{cache,log,lib/apt}/* etc/apt/* \
  usr/share/{doc-base,info,locale,man,lintian,bash-completion,zsh,fish})
find "$root/usr/share/doc" -type f ! -name copyright ! -path '*/doc/ssl-visiond/*' -delete
mksquashfs "$root" "$folder/ssl-visiond.raw" -noappend -quiet -no-progress -comp zstd -Xcompression-level 19 -b 1M
cp "$root/usr/lib/udev/rules.d/60-ssl-visiond.rules" "$folder"
printf 'net.core.rmem_max = 4194304\n' >"$folder/60-ssl-visiond.conf"
rm -rf "$root" "$folder"/*.log

cat >"$folder/ssl-visionctl" <<'SH'
#!/bin/sh
# Runs ssl-visionctl of the attached image. Needs root.
exec systemd-run --quiet --collect --wait --pipe --service-type=exec --working-directory=/ \
  --property=RootImage=/var/lib/portables/ssl-visiond.raw --property=MountAPIVFS=yes \
  --property=BindPaths=/var/lib/private/ssl-visiond:/var/lib/ssl-visiond /usr/bin/ssl-visionctl "$@"
SH
chmod +x "$folder/ssl-visionctl"

cat >"$folder/README" <<'TXT'
ssl-visiond as a portable service

  sudo cp ssl-visiond.raw /var/lib/portables/
  sudo portablectl attach --profile=trusted --enable --now ssl-visiond

The panel: http://127.0.0.1:8090. Other computers reach it once it has a password: sudo ./ssl-visionctl passwd

Detach       sudo systemctl disable --now ssl-visiond; sudo portablectl detach ssl-visiond
Upgrade      detach, then copy and attach the new image
Remove       detach; sudo rm -r /var/lib/private/ssl-visiond /var/lib/portables/ssl-visiond.raw
Settings     /etc/ssl-visiond/settings.json of this computer; without this file, those of the image and the panel
Stages       /usr/local/lib/ssl-visiond/stages and stages-apart of this computer

A package would also install:
USB3 Vision and IEEE 1394 cameras
             sudo cp 60-ssl-visiond.rules /etc/udev/rules.d/ && sudo udevadm control --reload && sudo udevadm trigger
GigE cameras with programs other than the service
             sudo cp 60-ssl-visiond.conf /etc/sysctl.d/ && sudo sysctl --system
Several USB3 Vision cameras
             usbcore.usbfs_memory_mb=1000 on the kernel's command line
TXT
