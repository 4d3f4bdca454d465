#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# man_page.sh PROGRAM PAGE.in VERSION: a manual page in roff on standard output. PAGE.in is its text; a line @OPTIONS@
# stands for what PROGRAM --help says, a line @COMMANDS@ for the same of each of its commands.
set -eu
here=$(dirname "$(realpath "$0")")
page=$(realpath "$2") version=$3

# A program beside its sources names their folders in its help.
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cp "$1" "$folder"
name=$(basename "$1")
cd "$folder"

options() { "./$name" "$@" --help | awk -v title="$*" -f "$here/man_page.awk"; }
# commands PATH...: the names of those below.
commands() { "./$name" "$@" --help | awk '/^[A-Z].*:$/ {inside = /^Subcommands:/} inside && /^  [a-z]/ {print $1}'; }

while IFS= read -r line; do
  case $line in
    @OPTIONS@) options ;;
    @COMMANDS@)
      for command in $(commands); do
        options "$command"
        for below in $(commands "$command"); do options "$command" "$below"; done
      done
      ;;
    *) printf '%s\n' "$line" | sed "s/@VERSION@/$version/g" ;;
  esac
done <"$page"
