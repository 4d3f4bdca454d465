#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# build_hello.sh PREFIX FOLDER: builds FOLDER/build/hello.so from the two files shown in docs/extending.md, against the
# stage kit installed at PREFIX, like an author.
set -euo pipefail
prefix=$(realpath "$1") docs=$(realpath "$(dirname "${BASH_SOURCE[0]}")/../../docs")
rm -rf "$2" && mkdir -p "$2" && cd "$2"

# The first code block in this language.
block() { awk -v begin="^\`\`\`$1\$" '$0 ~ begin {inside = 1; next} /^```$/ {if (inside) exit} inside' "$docs/extending.md"; }
block cpp >hello.cpp
block cmake >CMakeLists.txt
for file in hello.cpp CMakeLists.txt; do cmp "$file" "$docs/examples/hello/$file"; done
lines=$(cat hello.cpp CMakeLists.txt | wc -l)
((lines <= 40)) || { echo "hello has $lines lines, 40 are promised" >&2; exit 1; }
{ cmake -S . -B build -DCMAKE_PREFIX_PATH="$prefix" && cmake --build build; } >build.log 2>&1 ||
  { tail -n 30 build.log >&2; exit 1; }
