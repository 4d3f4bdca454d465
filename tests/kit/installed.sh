#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# installed.sh BUILD FOLDER: installs the stage kit of BUILD into FOLDER and builds the libraries of docs/extending.md
# and docs/examples against it, as a user would; then runs the first one.
set -euo pipefail
build=$(realpath "$1") sources=$(realpath "$(dirname "${BASH_SOURCE[0]}")/../..")
rm -rf "$2" && mkdir -p "$2/hello" && cd "$2"
cmake --install "$build" --component stages --prefix "$PWD/usr" >install.log

# The two files stand in the docs, one block of code each.
block() { awk -v begin="^\`\`\`$1\$" '$0 ~ begin {inside = 1; next} /^```$/ {if (inside) exit} inside' "$sources/docs/extending.md"; }
block cpp >hello/hello.cpp
block cmake >hello/CMakeLists.txt
lines=$(cat hello/hello.cpp hello/CMakeLists.txt | wc -l)
((lines <= 40)) || { echo "hello has $lines lines, 40 are promised" >&2; exit 1; }
cmake -S hello -B hello/build -DCMAKE_PREFIX_PATH="$PWD/usr" >hello.log
cmake --build hello/build >>hello.log 2>&1 || { tail -n 30 hello.log >&2; exit 1; }

node -e '
  const settings = JSON.parse(require("fs").readFileSync(process.argv[1]));
  settings.cameras = [{ ...settings.cameras[0], stack: ["segment", "detect_robots", "detect_balls", "hello", "publish"] }];
  console.log(JSON.stringify(settings));' "$sources/config/demo.json" >settings.json
"$build/bin/ssl-visionctl" simulate --settings settings.json --frames 3 --output images
"$build/bin/ssl-visionctl" process --stages hello/build --settings settings.json --input images >frames.jsonl 2>said.txt
grep -qx 'hello: I see the ball' said.txt || { cat said.txt >&2; exit 1; }
[[ $(wc -l <frames.jsonl) == 3 ]]
