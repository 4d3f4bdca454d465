#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# entry.sh FILE COMMAND...: runs an entry of ctest and writes into FILE how long the processors worked for it (s).
# In a session of its own: the kernel then shares processors among entries, not among all their threads, and those of
# idle class that a test waits for have their part (sched_autogroup).
code=0
mkdir -p "${1%/*}"  # the command may write its results there, too
setsid --wait "${@:2}" || code=$?
times >"$1"  # not in a pipe, whose shells worked nothing
work=$(awk 'NR == 2 { for (i = 1; i <= 2; ++i) { split($i, t, /[ms]/); sum += 60 * t[1] + t[2] } print sum }' "$1")
echo "$work" >"$1"
exit "$code"
