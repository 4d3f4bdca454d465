#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# check_includes.sh ROOT: fails when an #include "folder/..." under ROOT (daemon/) breaks the rules below, which are
# from docs/architecture.md. A folder may always include itself; the most specific rule applies.
set -euo pipefail
cd "$1"

rules='
  from                  may include
  base
  image                 base
  geometry              base
  calibration           base image geometry
  tracking              base geometry
  vision                base image geometry
  colors                base image geometry vision
  gpu                   base image vision
  gpu/module.cpp        gpu kit
  clips                 base image
  capture               base image geometry vision/patterns.h vision/label.h clips
  pipeline/frame.h      image/image.h image/frame_info.h geometry/scene.h vision/detections.h vision/lut.h vision/mask.h vision/patterns.h vision/regions.h pipeline/own_parts.h
  pipeline/field_frame.h tracking/camera_agreement.h tracking/gather.h tracking/sightings.h tracking/tracks.h pipeline/own_parts.h
  pipeline              base image geometry vision tracking
  kit                   base image geometry vision tracking pipeline
  net                   base image/frame_info.h geometry tracking/sightings.h tracking/tracks.h vision/detections.h pipeline/validate.h proto
  recording             base net settings/state_folder.h proto
  settings              base
  health                base image vision/mask.h
  web                   base image
  config                engines
  replay                engines config
  ctl                   base settings colors/margin_text.h config/found_cameras_text.h config/version.h
  lab                   engines config replay ctl
  services              engines config web
  services/access       engines config web services
  services/network      engines config web services
  services/recording    engines config web services replay services/cameras/cameras.h services/cameras/camera_routes.h services/cameras/recorded_camera.h
  services/settings     engines config web services
  services/backup       engines config web services services/settings/settings_editor.h services/settings/settings_routes.h
  services/cameras      engines config web services services/network/teams.h replay/clip_setup.h
  services/calibration  engines config web services services/access/match_lock.h services/cameras/cameras.h services/cameras/camera_routes.h services/cameras/fresh_frames.h services/settings/settings_editor.h
  services/colors       engines config web services services/cameras/cameras.h services/cameras/camera_routes.h services/cameras/fresh_frames.h services/cameras/pictures.h services/cameras/stills.h services/settings/settings_editor.h
  services/field        engines config web services services/settings/settings_editor.h
  services/sources      engines config web services services/cameras/cameras.h services/settings/settings_editor.h
  services/status       engines config web services services/cameras/cameras.h
  services/verdict      engines config web services services/cameras/cameras.h
  top                   anything
'
engines='base image clips geometry tracking calibration vision colors capture pipeline kit net recording settings health proto'

# "top" is daemon/ itself: main and the composition root. Nothing includes top or lab; only lab includes ctl. An engine includes no service. A
# service includes only those headers of other services that are listed here: their small interfaces.
grep -rnE --include='*.h' --include='*.cpp' --include='*.h.in' '^[[:space:]]*#[[:space:]]*include[[:space:]]*"' . |
  awk -v rules="$rules" -v engines="$engines" '
    function folder_of(path) {
      if (path ~ /\.pb\.h$/) return "proto"
      if (path !~ "/") return "top"
      count = split(path, part, "/")
      return part[1] == "services" && count > 2 ? part[1] "/" part[2] : part[1]
    }
    BEGIN {
      lines = split(rules, line, "\n")
      for (i = 1; i <= lines; ++i) {
        words = split(line[i], word, " ")
        if (words == 0 || word[1] == "from") continue
        known[word[1]] = 1
        said[word[1]] = "may include only: itself"
        sub(/engines/, engines, line[i])
        words = split(line[i], word, " ")
        for (w = 2; w <= words; ++w) {
          allowed[word[1], word[w]] = 1
          said[word[1]] = said[word[1]] ", " word[w]
        }
      }
    }
    {
      match($0, /^[^:]*:[0-9]*/)
      place = substr($0, 3, RLENGTH - 2)  # without ./
      file = place
      sub(/:[0-9]*$/, "", file)
      split($0, quoted, "\"")
      target = quoted[2]

      from = (file in known) ? file : folder_of(file)
      folder = folder_of(target)
      if (!(from in known)) {
        problem = "folder " from "/ has no rule in check_includes.sh"
      } else if (folder == from || (from, "anything") in allowed || (from, folder) in allowed || (from, target) in allowed) {
        next
      } else {
        problem = from " " said[from]
      }
      printf "%s: includes \"%s\", but %s\n", place, target, problem
      ++problems
    }
    END {
      printf "%d includes checked, %d forbidden\n", NR, problems
      exit NR == 0 || problems > 0
    }'
