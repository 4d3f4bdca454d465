#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# run.sh PREFIX FOLDER: builds the example stage libraries like an author, against the files installed under PREFIX, and
# runs them on simulated frames. All output goes to FOLDER. Exit code 77: not possible here.
# LAB: ssl-visionlab (PREFIX/bin/ssl-visionlab). EXAMPLES: their sources (docs/examples). DEMO: demo.json (config/demo.json).
set -euo pipefail
here=$(realpath "$(dirname "$0")")
prefix=$(realpath "$1")
mkdir -p "$2"
folder=$(realpath "$2")
lab=${LAB:-$prefix/bin/ssl-visionlab}
examples=${EXAMPLES:-$here/../../docs/examples}
demo=${DEMO:-$here/../../config/demo.json}
# Debian's Python, which python3-numpy is for.
python=${PYTHON:-/usr/bin/python3}

cannot() { printf 'examples: %s\n' "$*" >&2; exit 77; }
command -v cmake >/dev/null || cannot "there is no cmake"
"$python" -c 'import numpy' 2>/dev/null || cannot "there is no numpy (python3-numpy)"
[[ -e /usr/include/apriltag/apriltag.h ]] || cannot "there is no AprilTag (libapriltag-dev)"
[[ -e /usr/include/opencv4/opencv2/dnn.hpp ]] || cannot "there is no OpenCV (libopencv-dnn-dev)"

# build SOURCE TARGET: with the warnings that an author may have enabled.
build() {
  rm -rf "$2"
  cmake -S "$1" -B "$2" -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_CXX_FLAGS="-Wall -Wextra -Wshadow -Werror" &&
    cmake --build "$2"
}
build_all() {
  build "$examples" "$folder/all" && mkdir -p "$folder/stages" &&
    find "$folder/all" -name '*.so' -exec cp -t "$folder/stages" {} +
}
# limit LINES FILE...: checks the documented maximum length.
limit() {
  local lines
  lines=$(cat "${@:2}" | wc -l)
  ((lines <= $1)) || { echo "FAIL  ${*:2}: $lines lines, $1 are promised"; exit 1; }
}
limit 40 "$examples"/hello/*
limit 150 "$examples/april_tags/april_tags.cpp"
limit 250 "$examples"/learned_balls/*
limit 80 "$examples/record_patches/record_patches.cpp"
rm -rf "$folder/stages"
build_all >"$folder/build.log" 2>&1 || { tail -n 30 "$folder/build.log"; echo "FAIL  the examples do not build"; exit 1; }
echo "ok    the examples build"
"$python" "$here/checks.py" "$lab" "$folder/stages" "$examples" "$demo" "$folder/run"
