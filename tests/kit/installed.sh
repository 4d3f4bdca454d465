#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# installed.sh BUILD FOLDER: installs the stage kit of BUILD into FOLDER, builds the library of docs/extending.md
# against it, and runs its stage.
set -euo pipefail
build=$(realpath "$1") here=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
rm -rf "$2" && mkdir -p "$2" && cd "$2"
cmake --install "$build" --component stages --prefix "$PWD/usr" >install.log
"$here/build_hello.sh" usr hello

node -e '
  const settings = JSON.parse(require("fs").readFileSync(process.argv[1]));
  settings.cameras = [{ ...settings.cameras[0], stack: ["segment", "detect_robots", "detect_balls", "hello", "publish"] }];
  console.log(JSON.stringify(settings));' "$here/../../config/demo.json" >settings.json
"$build/bin/ssl-visionctl" simulate --settings settings.json --frames 3 --output images
"$build/bin/ssl-visionctl" process --stages hello/build --settings settings.json --input images >frames.jsonl 2>said.txt
grep -qx 'hello: 0 balls removed' said.txt || { cat said.txt >&2; exit 1; }
[[ $(wc -l <frames.jsonl) == 3 ]]
