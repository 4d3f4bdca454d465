#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# busy.sh N COMMAND...: runs COMMAND while N processes compute. Each has its own session, so that the kernel gives it as
# much CPU time as a ctest entry (tests/entry.sh): together they get most of the machine.
set -u
busy=()
trap '((${#busy[@]} == 0)) || kill "${busy[@]}"' EXIT
for ((i = 0; i < $1; ++i)); do
  setsid sh -c 'while :; do :; done' &
  busy+=($!)
done
"${@:2}"
