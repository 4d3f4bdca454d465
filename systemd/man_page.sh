#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# man_page.sh PROGRAM PAGE.in VERSION SECTION: writes a manual page to standard output, made by help2man from PROGRAM
# --help, from the help of each of its commands, and from PAGE.in.
set -eu
page=$(realpath "$2") version=$3 section=$4

# Runs a copy: in its build folder, a program prints the source folders in its help.
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cp "$1" "$folder"
name=$(basename "$1")
cd "$folder"

# Two spaces between name and help, even after a long name that leaves only one; ranges without repeating the type.
entries() {
  sed -E -e '/^  -h,--help /d' -e 's/^(  .{26}[^ ]) ([^ ])/\1  \2/' -e 's/:[A-Z]+ in / in /; s/:FILE / /'
}
# commands PATH...: names of the subcommands.
commands() { "./$name" "$@" --help | awk '/^[A-Z].*:$/ {inside = /^Subcommands:/} inside && /^  [a-z]/ {print $1}'; }
# section PATH...: heading and contents for one command.
section() {
  printf '\n%s:\n  ' "$*"
  "./$name" "$@" --help | awk 'NR == 1 {print toupper(substr($0, 1, 1)) substr($0, 2) "."}
    /^[A-Z].*:$/ {inside = 1; print ""; next} inside' | entries
}
{
  "./$name" --help | sed -E -e "s|^Usage: .*/|Usage: |" -e '/^Subcommands:/,$d' | entries
  if [ -n "$(commands)" ]; then printf '\n*Commands*\n'; fi
  for command in $(commands); do
    section "$command"
    for below in $(commands "$command"); do section "$command" "$below"; done
  done
} >help

cat >"page" <<TXT
#!/bin/sh
if [ "\$1" = --help ]; then cat "$folder/help"; else echo "$name $version"; fi
TXT
chmod +x page
# Removes the date, so that the same sources give the same page.
title=$(echo "$name" | tr '[:lower:]' '[:upper:]')
LC_ALL=C.UTF-8 help2man --no-info --section "$section" --manual ssl-visiond --source "ssl-visiond $version" \
  --include "$page" ./page | sed -E -e "s/^\.TH [^ ]+ (\"[0-9]\") \"[^\"]*\"/.TH $title \1 \"\"/" -e 's/^\.SS "(.*):"$/.SS "\1"/'
