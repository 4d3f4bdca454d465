#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# installed_programs.sh FOLDER PACKAGE...: fills FOLDER with links to all programs of a bare Debian with these packages
# and their dependencies installed. With FOLDER as PATH, a test fails if it needs a program that no package provides.
set -euo pipefail
folder=$1
rm -rf "$folder"
mkdir -p "$folder"

mapfile -t required < <(dpkg-query -W -f '${Priority} ${Package}\n' | awk '$1 == "required" {print $2}')
# The packages that apt would install on an empty computer.
mapfile -t packages < <(apt-get install --simulate --no-install-recommends -o Dir::State::status=/dev/null \
  apt "${required[@]}" "${@:2}" | awk '$1 == "Inst" {print $2}')
((${#packages[@]})) || { echo "installed_programs.sh: apt knows no packages: apt-get update" >&2; exit 1; }

# Packages that are not installed have no files. Links in /etc/alternatives belong to the owner of their target.
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

# A Node from another source is accepted, as in ./run.
for program in node npm npx; do
  [[ -e $folder/$program ]] || ln -s "$(command -v "$program")" "$folder/"
done
