#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# stack.sh BUILD FOLDER: runs the GPU stage's library in a stack of the command-line tool. Its results must equal the
# CPU's, byte for byte.
set -euo pipefail
build=$(realpath "$1") sources=$(realpath "$(dirname "${BASH_SOURCE[0]}")/../..")
rm -rf "$2" && mkdir -p "$2" && cd "$2"
settings() {
  node -e '
    const settings = JSON.parse(require("fs").readFileSync(process.argv[1]));
    const stack = [process.argv[2], "find_runs", "find_regions", "detect_robots", "detect_balls", "publish"];
    const stages = process.argv[2] === "threshold" ? {} : { gpu_threshold: { use: "always" } };
    settings.cameras = [{ ...settings.cameras[0], stack, stages }];
    console.log(JSON.stringify(settings));' "$sources/config/demo.json" "$1"
}
settings threshold >cpu.json
settings gpu_threshold >gpu.json
"$build/bin/ssl-visionlab" simulate --settings cpu.json --frames 60 --output images
"$build/bin/ssl-visionlab" process --settings cpu.json --input images >cpu.jsonl
"$build/bin/ssl-visionlab" process --stages "$build/stages" --settings gpu.json --input images >gpu.jsonl 2>said.txt ||
  { cat said.txt; exit 1; }
cat said.txt
grep -q '^gpu_threshold: ' said.txt
[[ -s cpu.jsonl ]]
# Removes the stages' times, which differ.
for file in cpu gpu; do sed -i 's/,"timing_us":{[^}]*}//' $file.jsonl; done
cmp cpu.jsonl gpu.jsonl
