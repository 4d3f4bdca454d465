#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# installed.sh BUILD FOLDER: installs BUILD's stage kit into FOLDER, builds the library of docs/extending.md against it,
# and runs its stage.
set -euo pipefail
build=$(realpath "$1") here=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
rm -rf "$2" && mkdir -p "$2" && cd "$2"
cmake --install "$build" --component stages --prefix "$PWD/usr" >install.log
"$here/build_hello.sh" usr hello

settings_with() {
  node -e '
    const settings = JSON.parse(require("fs").readFileSync(process.argv[1]));
    const stack = ["segment", "detect_robots", "detect_balls", process.argv[2], "publish"];
    settings.cameras = [{ ...settings.cameras[0], stack }];
    console.log(JSON.stringify(settings));' "$here/../../config/demo.json" "$1"
}
settings_with hello >settings.json
"$build/bin/ssl-visionlab" simulate --settings "$here/../../config/demo.json" --frames 3 --output images
"$build/bin/ssl-visionlab" process --stages hello/build --settings settings.json --input images >frames.jsonl 2>said.txt
grep -qx 'hello: 0 balls removed' said.txt || { cat said.txt >&2; exit 1; }
[[ $(wc -l <frames.jsonl) == 3 ]]

# A library with AddressSanitizer must report where it writes out of range, as docs/extending.md promises.
mkdir faulty && cp "$here/libraries/out_of_range.cpp" faulty/
printf '%s\n' 'cmake_minimum_required(VERSION 3.18)' 'project(faulty CXX)' 'find_package(SslVisiondStages REQUIRED)' \
  'ssl_visiond_stages(out_of_range out_of_range.cpp)' >faulty/CMakeLists.txt
{ cmake -S faulty -B faulty/build -DCMAKE_PREFIX_PATH="$PWD/usr" -DCMAKE_CXX_COMPILER=g++ \
    -DCMAKE_CXX_FLAGS=-fsanitize=address && cmake --build faulty/build; } >faulty.log 2>&1 || { tail -n 30 faulty.log >&2; exit 1; }
settings_with write_behind >faulty.json
if LD_PRELOAD=$(g++ -print-file-name=libasan.so) ASAN_OPTIONS=detect_leaks=0 "$build/bin/ssl-visionlab" process \
  --stages faulty/build --settings faulty.json --input images >frames.jsonl 2>said.txt; then
  echo "nobody noticed the write out of range" >&2
  exit 1
fi
grep -q 'heap-buffer-overflow' said.txt || { cat said.txt >&2; exit 1; }
grep -q 'out_of_range.cpp:16' said.txt || { cat said.txt >&2; exit 1; }
