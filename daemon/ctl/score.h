// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <cstddef>
#include <iosfwd>
#include <string>
#include <vector>

namespace sslv {

/// Of absolute errors; zeros when there are none.
struct ErrorStatistics {
  std::size_t count = 0;
  double mean = 0, rms = 0, p95 = 0, max = 0;
};

struct ScoreOptions {
  // A true robot or ball of which less shows may be found or not: neither counts.
  double min_robot_share = 1, min_ball_share = 1;
};

/// Things of one kind over all compared frames.
struct FoundCounts {
  std::size_t expected = 0;  // visible enough in the truth
  std::size_t found = 0;     // of these, with the right id
  std::size_t wrong_id =
      0;  // robots at a true robot's place, of its team, with another id; also at partly visible ones
  std::size_t invented = 0;  // detections with nothing at their place

  /// found / expected; 1 when nothing was expected.
  double recall() const;
  /// found / (found + wrong_id + invented); 1 when nothing was detected.
  double precision() const;
};

/// Errors count the found ones only.
struct Score {
  std::size_t frames_compared = 0;
  std::vector<std::string> frames_without_detections, frames_without_truth;  // not compared
  std::vector<std::string> frames_not_checked;  // compared with what no person has looked at
  FoundCounts robots, balls;
  ErrorStatistics robot_position_mm, robot_orientation_deg, ball_position_mm;
};

/// Compares detections with the truth, both one JSON object a line as `process` and `simulate` write them, by
/// frame name. A detection stands for the true robot of its team, or ball, nearest to it within 100 mm;
/// nearest pairs go first. How much of a true thing shows is its "visible_share", where that is missing 1 or
/// 0 after "visible"; "checked" is false while no person has looked at what the detector said. Throws
/// std::runtime_error, naming stream and line, for what is not such a line or a frame that comes twice.
Score score(std::istream& detections, std::istream& truth, const ScoreOptions& options = {});

/// The same for two files; throws std::runtime_error as well when one cannot be read.
Score score_files(const std::string& detections_file, const std::string& truth_file,
                  const ScoreOptions& options = {});

/// The members of Score by their names, with recall and precision.
Json score_json(const Score& score);
/// A table for people.
std::string score_text(const Score& score);

}  // namespace sslv
