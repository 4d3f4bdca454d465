#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# man_page.sh PROGRAM PAGE.in VERSION SECTION: a manual page on standard output, made by help2man of what PROGRAM --help
# says, of what it says of each of its commands, and of PAGE.in.
set -eu
page=$(realpath "$2") version=$3 section=$4

# A program beside its sources names their folders in its help.
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cp "$1" "$folder"
name=$(basename "$1")
cd "$folder"

# Two blanks between name and help also where a long name leaves but one; ranges without the type a second time.
entries() {
  sed -E -e '/^  -h,--help /d' -e 's/^(  .{26}[^ ]) ([^ ])/\1  \2/' -e 's/:[A-Z]+ in / in /; s/:FILE / /'
}
# commands PATH...: the names of those below.
commands() { "./$name" "$@" --help | awk '/^[A-Z].*:$/ {inside = /^Subcommands:/} inside && /^  [a-z]/ {print $1}'; }
# section PATH...: of one command, a heading and what there is to it.
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
# Without the date: the same sources make the same page.
title=$(echo "$name" | tr '[:lower:]' '[:upper:]')
LC_ALL=C.UTF-8 help2man --no-info --section "$section" --manual ssl-visiond --source "ssl-visiond $version" \
  --include "$page" ./page | sed -E -e "s/^\.TH [^ ]+ (\"[0-9]\") \"[^\"]*\"/.TH $title \1 \"\"/" -e 's/^\.SS "(.*):"$/.SS "\1"/'
