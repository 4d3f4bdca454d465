#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# busy.sh N COMMAND...: runs COMMAND beside N processes that compute until it ends. Each has a session of its own, so
# that the kernel gives it as much as an entry of ctest (tests/entry.sh): together they get most of the machine.
set -u
busy=()
trap '((${#busy[@]} == 0)) || kill "${busy[@]}"' EXIT
for ((i = 0; i < $1; ++i)); do
  setsid sh -c 'while :; do :; done' &
  busy+=($!)
done
"${@:2}"
