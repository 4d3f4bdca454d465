#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Includes that check_includes.sh must reject or allow, each in a tree with one include.
set -euo pipefail
check=$(dirname "${BASH_SOURCE[0]}")/check_includes.sh
tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
failed=0

# expect RESULT FILE INCLUDE: RESULT is "allowed" or the beginning of the message after FILE:LINE.
expect() {
  local answer result=allowed
  rm -rf "${tree:?}"/*
  mkdir -p "$(dirname "$tree/$2")"
  printf '// a comment\n#include <vector>\n#include "%s"\n' "$3" > "$tree/$2"
  answer=$("$check" "$tree") || result=forbidden
  if [[ $1 == allowed ]]; then
    [[ $result == allowed ]] && return
  else
    [[ $result == forbidden && $answer == "$2:3: includes \"$3\", but $1"* ]] && return
  fi
  echo "FAILED: $2 including $3: expected '$1', got '$answer'"
  failed=1
}

expect allowed image/jpeg.cpp base/log.h
expect allowed image/jpeg.cpp image/jpeg.h
expect allowed capture/simulator/simulator.cpp vision/patterns.h
expect allowed daemon.cpp web/server.h
expect allowed net/packets.cpp ssl_vision_wrapper.pb.h
expect allowed lab/learn.cpp pipeline/pipeline.h
expect allowed lab/track_log.cpp ctl/table.h
expect "base may include only: itself" base/log.h image/image.h
expect "vision may include only: itself, base, image, geometry" vision/find_runs.h pipeline/frame.h
expect "capture may include only:" capture/simulator/simulator.cpp vision/lut.h
expect "net may include only:" net/packets.cpp image/image.h
expect "web may include only: itself, base, image" web/router.cpp settings/store.h
expect "web may include only:" web/router.cpp services/service.h
expect "colors may include only:" colors/surfaces.cpp services/colors/color_desk.h
expect "ctl may include only:" ctl/client.cpp services/service.h
expect "ctl may include only:" ctl/client.cpp web/route.h
expect "ctl may include only:" ctl/main.cpp lab/bench.h
expect "ctl may include only:" ctl/colors.cpp colors/surfaces.h
expect "config may include only:" config/config.cpp services/service.h
expect allowed services/colors/color_service.cpp services/cameras/cameras.h
expect allowed services/colors/color_service.cpp services/service.h
expect allowed services/cameras/camera_json.cpp config/stages.h
expect "services/colors may include only:" services/colors/color_service.cpp services/cameras/camera_service.h
expect allowed gpu/gpu_threshold.cpp vision/lut.h
expect "gpu may include only: itself, base, image, vision" gpu/gpu_threshold.cpp pipeline/frame.h
expect "pipeline may include only:" pipeline/camera_pipeline.cpp gpu/gpu_context.h
expect "services may include only:" services/health_report.cpp services/cameras/cameras.h
expect "pipeline/frame.h may include only:" pipeline/frame.h base/log.h
expect "pipeline/frame.h may include only:" pipeline/frame.h pipeline/stage.h
expect "web may include only:" web/server.h daemon.h
expect "web may include only:" web/server.h ctl/client.h
expect "folder tracker/ has no rule" tracker/filter.cpp base/log.h
exit $failed
