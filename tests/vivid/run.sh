#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# run.sh PROGRAM FOLDER: runs the test PROGRAM in an emulated machine with Debian's kernel and its vivid driver. The
# kernel is downloaded into FOLDER and kept there. Exit code 77: not possible here.
set -euo pipefail
program=$(realpath "$1")
mkdir -p "$2" && cd "$2"

cannot() { printf 'vivid: %s\n' "$*" >&2; exit 77; }

# ---- the kernel

package=$(apt-cache depends linux-image-amd64 | sed -n 's/^ *Depends: \(linux-image-[0-9].*\)/\1/p')
[[ -n $package ]] || cannot "apt knows no kernel package"
version=${package#linux-image-}
if [[ ! -e $version/boot/vmlinuz-$version ]]; then
  apt-get download -q "$package" || cannot "$package cannot be downloaded"
  dpkg -x "$package"_*.deb "$version.part"
  busybox depmod -b "$version.part" "$version"
  mv "$version.part" "$version"
  rm "$package"_*.deb
fi

# ---- the machine's files: busybox, vivid with its dependencies, the program with its libraries

rm -rf machine
mkdir -p machine/{bin,dev,proc,sys,tmp}
cp "$(command -v busybox)" machine/bin/busybox
cp "$program" machine/vivid_test
ldd "$program" | grep -o '/[^ ]*' | while read -r library; do
  mkdir -p "machine$(dirname "$library")"
  cp -L "$library" "machine$library"
done
modules=lib/modules/$version
sed -n 's|^\(.*/vivid\.ko\):|\1|p' "$version/$modules/modules.dep" | tr ' ' '\n' | while read -r module; do
  install -D "$version/$modules/$module" "machine/$modules/$module"
done
busybox depmod -b machine "$version"
cat >machine/init <<'INIT'
#!/bin/busybox sh
/bin/busybox --install -s /bin
export PATH=/bin
mount -t proc proc /proc
mount -t sysfs sysfs /sys
mount -t devtmpfs devtmpfs /dev
# Two cameras with one webcam input each, and only capture devices.
modprobe vivid n_devs=2 node_types=0x1,0x1 num_inputs=1,1 input_types=0x0,0x0 multiplanar=1,1
/vivid_test --gtest_color=no
echo "exit code $?"
poweroff -f
INIT
chmod +x machine/init
(cd machine && find . | cpio -o -H newc --quiet | gzip -1) >machine.cpio.gz

# ---- run: always emulated, so that it works everywhere in the same way

timeout 600 qemu-system-x86_64 -accel tcg -cpu max -smp 2 -m 1024 -nodefaults -display none -serial stdio -no-reboot \
  -kernel "$version/boot/vmlinuz-$version" -initrd machine.cpio.gz -append "console=ttyS0 quiet panic=-1" \
  </dev/null | tr -d '\r' | tee machine.log
grep -qx 'exit code 0' machine.log && grep -q '\[  PASSED  \]' machine.log
