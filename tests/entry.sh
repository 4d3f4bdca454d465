#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# entry.sh FILE COMMAND...: runs a ctest entry and writes its CPU time in s to FILE. The entry runs in its own session:
# the kernel then shares processors among entries instead of threads (sched_autogroup), so that idle-class threads,
# for which some tests wait, also run.
code=0
mkdir -p "${1%/*}"  # the command may write its results there, too
setsid --wait "${@:2}" || code=$?
times >"$1"  # not in a pipe: its shells used no CPU time
work=$(awk 'NR == 2 { for (i = 1; i <= 2; ++i) { split($i, t, /[ms]/); sum += 60 * t[1] + t[2] } print sum }' "$1")
echo "$work" >"$1"
exit "$code"
