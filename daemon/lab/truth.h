// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "geometry/scene.h"
#include "pipeline/frame.h"

#include <string>
#include <utility>
#include <vector>

namespace sslv {

/// A person's corrections of one image, whose detections are the first draft. Robots and balls are identified
/// by the numbers of their marks; places are pixels of the image.
struct Corrections {
  struct RobotAt {
    Team team{};
    int id = 0;
    double x_px = 0, y_px = 0;              // middle of the pattern
    double front_x_px = 0, front_y_px = 0;  // any place in front of the robot
  };
  struct BallAt {
    double x_px = 0, y_px = 0;
  };
  std::vector<int> remove{};               // false detections
  std::vector<int> doubtful{};             // count neither as found nor as missing
  std::vector<std::pair<int, int>> ids{};  // a robot's mark and its true id
  std::vector<RobotAt> robots{};           // missing in the draft
  std::vector<BallAt> balls{};
  bool checked = false;  // a person has confirmed all remaining marks

  /// Whether the image's robots and balls stay unchanged.
  bool empty() const {
    return remove.empty() && doubtful.empty() && ids.empty() && robots.empty() && balls.empty();
  }
};

/// Returns a line of a truth file, as `score` reads it, from detections: places in mm and pixels, "number" of
/// the mark, "by" ("detector" or "hand"), and "checked": false.
Json draft_of_truth(const std::string& name, const Frame& frame);

/// Corrects such a line. Added places are projected to the field with the camera model, robots at their
/// team's height, balls at their radius. Marks keep their numbers; added marks get the next numbers. Throws
/// SettingsError, naming the image, for an unknown mark, for a place that is outside the image or cannot be
/// located, and for a robot that is there twice; the line is then unchanged.
void correct(Json& line, const Corrections& corrections, const Scene& scene);

/// Reads the lines of such a truth file; none if there is no file. Throws SettingsError for other files, such
/// as truth files of `simulate`, whose robots and balls have no marks.
std::vector<Json> read_truth(const std::string& file);

/// A line for each mark, for a terminal.
std::string truth_text(const Json& line);

}  // namespace sslv
