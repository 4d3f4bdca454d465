#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# installed_programs.sh FOLDER PACKAGE...: makes FOLDER with a link to each program that a bare Debian has once these
# packages are installed: its own, theirs and those of all that they depend on. As PATH it shows which programs a test
# needs that nobody installs.
set -euo pipefail
folder=$1
rm -rf "$folder"
mkdir -p "$folder"

mapfile -t required < <(dpkg-query -W -f '${Priority} ${Package}\n' | awk '$1 == "required" {print $2}')
# What apt would install on a computer that has nothing.
mapfile -t packages < <(apt-get install --simulate --no-install-recommends -o Dir::State::status=/dev/null \
  apt "${required[@]}" "${@:2}" | awk '$1 == "Inst" {print $2}')
((${#packages[@]})) || { echo "installed_programs.sh: apt knows no packages: apt-get update" >&2; exit 1; }

# Packages that are not here have no files. Links of /etc/alternatives have no owner but what they lead to.
declare -A owned
add() {
  local to
  to=$(readlink -f "$1") && [[ -x $to ]] && ln -sf "$1" "$folder/" && owned[$to]=1
}
while read -r program; do add "$program" || true; done < <(dpkg-query -L "${packages[@]}" 2>/dev/null |
  grep -xE '(/usr)?/s?bin/[^/]+')
while read -r program; do
  [[ -z ${owned[$(readlink -f "$program" || echo missing)]:-} ]] || add "$program"
done < <(find /usr/bin /usr/sbin -lname '/etc/alternatives/*')

# One that came from elsewhere will do, as in ./run.
for program in node npm npx; do
  [[ -e $folder/$program ]] || ln -s "$(command -v "$program")" "$folder/"
done
