#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# check_unit.sh FOLDER PROGRAM: checks FOLDER's units, with PROGRAM in place of the installed one.
set -euo pipefail
folder=$1 program=$(realpath "$2")
most_exposed=20 # tenths

if ! command -v systemd-analyze >/dev/null; then
  echo "skipped: there is no systemd-analyze" >&2
  exit 77
fi

copy=$(mktemp -d)
trap 'rm -rf "$copy"' EXIT
cp "$folder"/*.service "$folder"/*.slice "$copy"
ln -s "$program" "$copy/program"  # its path may have spaces
ln -s "$(realpath "$folder/raise_limits.sh")" "$copy/raise-limits"
sed -i "s|^ExecStart=/usr/bin/ssl-visiond |ExecStart=$copy/program |
  s|/usr/lib/ssl-visiond/raise-limits|$copy/raise-limits|" "$copy"/*.service
mkdir "$copy/ssl-visiond.service.d"

# check WHAT
check() {
  local said
  said=$(SYSTEMD_UNIT_PATH=$copy: systemd-analyze verify --man=no "$copy/ssl-visiond.service" 2>&1) || true
  # Ignores messages about other units on this computer.
  said=$(grep -E "ssl-visiond|sslvision|$copy" <<<"$said") || true
  if [[ -n $said ]]; then
    printf '%s: systemd-analyze verify says:\n%s\n' "$1" "$said" >&2
    exit 1
  fi
}

check "the unit"
cp "$folder"/{clock,realtime}.conf "$copy/ssl-visiond.service.d/"
check "the unit with clock.conf and realtime.conf"
rm -r "$copy/ssl-visiond.service.d"

systemd-analyze security --offline=true --no-pager --threshold="$most_exposed" "$copy/ssl-visiond.service" |
  grep -v '✓'
