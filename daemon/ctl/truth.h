// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "geometry/scene.h"
#include "pipeline/frame.h"

#include <string>
#include <utility>
#include <vector>

namespace sslv {

/// What a person says of one image of which the detector's finds are the first draft. Robots and balls are
/// named by the numbers of their marks, places are pixels of the image.
struct Corrections {
  struct RobotAt {
    Team team{};
    int id = 0;
    double x_px = 0, y_px = 0;              // middle of the pattern
    double front_x_px = 0, front_y_px = 0;  // any place that it looks towards
  };
  struct BallAt {
    double x_px = 0, y_px = 0;
  };
  std::vector<int> remove{};               // there is no such thing
  std::vector<int> doubtful{};             // may be found or not
  std::vector<std::pair<int, int>> ids{};  // mark, the robot's true id
  std::vector<RobotAt> robots{};           // that were not found
  std::vector<BallAt> balls{};
  bool checked = false;  // what is left is true

  /// Nothing of the image's robots and balls changes.
  bool empty() const {
    return remove.empty() && doubtful.empty() && ids.empty() && robots.empty() && balls.empty();
  }
};

/// A line of a truth file, as `score` reads them, from what was found: places in mm and pixels, "number" of
/// the mark, "by" ("detector" or "hand"), and "checked": false.
Json draft_of_truth(const std::string& name, const Frame& frame);

/// Corrects such a line. Added places are carried to the field by the camera, robots at their team's height,
/// balls at their radius. Numbers stay; what is added gets the next ones. Throws SettingsError, naming the
/// image, for a mark that it has not, a place that is not in it or cannot be located, and a robot that is
/// there twice; the line is then as it was.
void correct(Json& line, const Corrections& corrections, const Scene& scene);

/// The lines of a truth file that was drafted so; none when there is no such file. Throws SettingsError for
/// others, such as those of `simulate`: their things have no marks.
std::vector<Json> read_truth(const std::string& file);

/// A line for each mark, for a terminal.
std::string truth_text(const Json& line);

}  // namespace sslv
