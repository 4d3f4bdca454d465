// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <cstddef>
#include <iosfwd>
#include <string>
#include <vector>

namespace sslv {

/// Statistics of absolute errors; zeros if there are none.
struct ErrorStatistics {
  std::size_t count = 0;
  double mean = 0, rms = 0, p95 = 0, max = 0;
};

struct ScoreOptions {
  // A true robot or ball that is less visible than this does not count, whether it is found or not.
  double min_robot_share = 1, min_ball_share = 1;
};

/// Counts of robots or of balls over all compared frames.
struct FoundCounts {
  std::size_t expected = 0;  // visible enough in the truth
  std::size_t found = 0;     // found with the right id, out of `expected`
  std::size_t wrong_id = 0;  // right team and place, wrong id; includes partly visible robots
  std::size_t invented = 0;  // detections with nothing at their place

  /// found / expected; 1 when nothing was expected.
  double recall() const;
  /// found / (found + wrong_id + invented); 1 when nothing was detected.
  double precision() const;
};

/// Result of a comparison. The error statistics contain found robots and balls only.
struct Score {
  std::size_t frames_compared = 0;
  std::vector<std::string> frames_without_detections, frames_without_truth;  // not compared
  std::vector<std::string> frames_not_checked;  // compared with a truth that no person has checked
  FoundCounts robots, balls;
  ErrorStatistics robot_position_mm, robot_orientation_deg, ball_position_mm;
};

/// Compares detections with the truth by frame name; both streams have one JSON object per line, as written
/// by `process` and `simulate`. A detection is matched with the nearest true robot of its team, or ball,
/// within 100 mm; nearest pairs first. The visible share of a true thing is its "visible_share"; if that is
/// missing, 1 or 0 by "visible". "checked" is false until a person has checked the detector's draft. Throws
/// std::runtime_error, naming stream and line, for an invalid line or a repeated frame.
Score score(std::istream& detections, std::istream& truth, const ScoreOptions& options = {});

/// The same for two files; also throws std::runtime_error if one cannot be read.
Score score_files(const std::string& detections_file, const std::string& truth_file,
                  const ScoreOptions& options = {});

/// The members of Score by their names, with recall and precision.
Json score_json(const Score& score);
/// A human-readable table.
std::string score_text(const Score& score);

}  // namespace sslv
