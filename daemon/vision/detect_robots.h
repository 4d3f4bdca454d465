// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"
#include "vision/detections.h"
#include "vision/patterns.h"
#include "vision/regions.h"

#include <array>
#include <cstddef>
#include <tuple>
#include <vector>

namespace sslv {

/// Finds robots: a blob of a team's colour and size with side dots at the pattern's places around it. Works
/// in field millimetres on the plane of the team's height; the pose is the least-squares fit of the pattern
/// to all dots. A robot is reported only with every dot proven: with all codes in use, a missing dot leaves
/// more than one id.
class DetectRobots {
 public:
  struct Params {
    double min_area_ratio = 0.35;
    double max_area_ratio = 2.2;
    double max_dot_error_mm = 14;
    double max_rms_mm = 8;
    static constexpr auto fields() {
      return std::tuple{
          number("min_area_ratio", &Params::min_area_ratio, 0.0, 1.0, "",
                 "smallest dot, as a share of its true area"),
          number("max_area_ratio", &Params::max_area_ratio, 1.0, 10.0, "",
                 "largest dot, as a multiple of its true area"),
          number("max_dot_error_mm", &Params::max_dot_error_mm, 1.0, 50.0, "mm",
                 "how far a side dot may lie from its place"),
          number("max_rms_mm", &Params::max_rms_mm, 0.5, 30.0, "mm", "largest rms error of a whole pattern"),
      };
    }
  };

  /// Without a calibrated camera the result is empty. One id is reported at most once a team: the better fit.
  void process(const Params& params, const Scene& scene, const PatternTable& patterns,
               const RegionList& regions, RobotList& robots) noexcept;

 private:
  static constexpr std::size_t kMaxDots = 16;
  /// A blob that may be a dot, seen on the plane of a team's height.
  struct Dot {
    double x_mm, y_mm;
    Label label;
    std::size_t region;  // identity, to give a dot to one robot only
  };
  /// A pattern laid over blobs.
  struct Candidate {
    Robot robot;
    double rms_mm;
    std::array<std::size_t, kMaxDots> used;  // regions of the side dots
    std::size_t center_region;
  };

  void collect_dots(const Params& params, const Scene& scene, double height_mm, const PatternTable& patterns,
                    const RegionList& regions);
  void fit_around(const Params& params, const Scene& scene, const PatternTable& patterns, Team team,
                  const Dot& center);
  /// Replaces `best` when the pattern, turned so about the centre, fits better.
  void try_heading(const Params& params, const Scene& scene, const PatternTable& patterns, Team team,
                   const Dot& center, double turn_rad, Candidate& best) const;
  void choose(const PatternTable& patterns, RobotList& robots);

  std::vector<Dot> dots_, near_;
  std::vector<Candidate> candidates_;
  std::vector<std::size_t> taken_;
};

}  // namespace sslv
