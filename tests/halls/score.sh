#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# For each hall drawn by draw_halls, learns colours from its first frames, then processes and scores other frames, and
# prints a line.
#
#   tests/halls/score.sh [--learn N] [--learn-light F] [--frames M] [--light F] [--kinds "usual hard acceptance"] [--sizes "A B C"]
#       [--formats "uyvy rgb24 bayer_rg8"] [--seeds "1 2 3 4"] [--ball-share 0.4] [--keep FOLDER] [-- OPTIONS OF draw_halls]
#
# BIN: the folder of the programs; default: that of build/release. By default each frame has its own
# light, as suits the kind of hall; --learn-light fixes it for the frames for learning, --light for the others. Balls
# count if fully visible, or if at least the fraction --ball-share is. Times depend on the computer's other load.
set -eu

here=$(cd "$(dirname "$0")" && pwd)
bin=${BIN:-$here/../../build/release/bin}
learn=1 frames=8 kinds="usual hard acceptance" sizes="A B C" formats="uyvy rgb24 bayer_rg8" seeds="1 2 3 4" keep="" learn_light="" light="" ball_share=""

while [ $# -gt 0 ]; do
  case $1 in
    --learn) learn=$2; shift 2 ;;
    --learn-light) learn_light=$2; shift 2 ;;
    --light) light=$2; shift 2 ;;
    --frames) frames=$2; shift 2 ;;
    --kinds) kinds=$2; shift 2 ;;
    --sizes) sizes=$2; shift 2 ;;
    --formats) formats=$2; shift 2 ;;
    --seeds) seeds=$2; shift 2 ;;
    --ball-share) ball_share=$2; shift 2 ;;
    --keep) keep=$2; shift 2 ;;
    --) shift; break ;;
    *) echo "unknown: $1" >&2; exit 2 ;;
  esac
done

if [ -n "$keep" ]; then
  top=$keep
  mkdir -p "$top"
else
  top=$(mktemp -d)
  trap 'rm -rf "$top"' EXIT
fi

# The columns of a line, from the JSON that `score` prints.
line_of='"\(.robots.found)/\(.robots.expected) \(.robots.recall*10000|round/10000) \(.robots.wrong_id) \(.robots.invented) \(.robot_position_mm.rms*1000|round/1000) \(.balls.found)/\(.balls.expected) \(.balls.recall*10000|round/10000) \(.balls.invented) \(.ball_position_mm.rms*1000|round/1000)"'

printf '%-10s %-4s %-9s %4s %-6s %-9s %-7s %5s %5s %7s %-7s %-7s %5s %7s %9s\n' \
  kind size format seed learnt robots recall wrong false mm balls recall false mm "us/frame"
for kind in $kinds; do
  for size in $sizes; do
    case $size in A) pixels=780x580 ;; B) pixels=1280x1024 ;; *) pixels=2448x2048 ;; esac
    for format in $formats; do
      for seed in $seeds; do
        hall=$top/$kind-$size-$format-$seed
        set_of="--kind $kind --size $size --format $format --seed $seed"
        # shellcheck disable=SC2086  # several words each
        "$bin/draw_halls" $set_of --frames "$learn" ${learn_light:+--light $learn_light --lamps 1,1} --output "$hall/learn" "$@"
        # shellcheck disable=SC2086
        "$bin/draw_halls" $set_of --first $((learn + 1)) --frames "$frames" ${light:+--light $light --lamps 1,1} --output "$hall/frames" "$@"
        learnt=yes
        "$bin/ssl-visionlab" learn-colours --settings "$hall/learn/settings.json" --input "$hall/learn" --pixel-format "$format" --size $pixels \
          --frames "$learn" --output "$hall/table.lut" --json > "$hall/learnt.json" 2> "$hall/learnt.err" || learnt=no
        result="- - - - - - - - -" time=-
        if [ $learnt = yes ]; then
          # The settings of a camera with that table.
          jq --arg table "$hall/table.lut" '.cameras[0].colors = {lut_file: $table}' "$hall/frames/settings.json" > "$hall/settings.json"
          "$bin/ssl-visionlab" process --settings "$hall/settings.json" --input "$hall/frames" --pixel-format "$format" --size $pixels \
            --output "$hall/detections.jsonl"
          # shellcheck disable=SC2086
          result=$("$bin/ssl-visionlab" score ${ball_share:+--min-ball-share $ball_share} --detections "$hall/detections.jsonl" --truth "$hall/frames/truth.jsonl" --json | jq -r "$line_of")
          time=$(jq -s '[.[].timing_us|add]|sort|.[length/2|floor]|round' "$hall/detections.jsonl")
        fi
        # shellcheck disable=SC2086
        printf '%-10s %-4s %-9s %4s %-6s %-9s %-7s %5s %5s %7s %-7s %-7s %5s %7s %9s\n' $kind $size $format $seed $learnt $result "$time"
        if [ -z "$keep" ]; then rm -rf "$hall"; fi
      done
    done
  done
done
