// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/label.h"
#include "vision/pattern_pose.h"

#include <array>
#include <string>
#include <vector>

namespace sslv {

/// A coloured dot on a robot's top, in the robot's frame: x forward, y left, millimetres from the centre.
struct PatternDot {
  double x_mm, y_mm, diameter_mm;
};

/// Identifies robots as the league does: a centre dot in the team's colour, and side dots at fixed places
/// whose colours encode the id. Places, sizes, colours and codes are data (config/patterns).
struct PatternTable {
  static constexpr std::size_t kMaxDots = 16;  // side dots

  std::string name;
  double center_diameter_mm = 50;
  double center_x_mm = 0, center_y_mm = 0;  // the centre dot's place, as of the side dots
  std::array<Label, 2> team_colors{label::kYellow, label::kBlue};  // centre dot's colour, by Team
  std::vector<PatternDot> dots;                                    // side dots
  /// The robot's top: black, round, with a flat front. Nothing beyond it is part of the robot.
  double top_radius_mm = 90, top_front_mm = 55;

  /// The side dots' colours of one robot id.
  struct Code {
    int id;
    std::vector<Label> colors;  // one for each dot
  };
  std::vector<Code> codes;

  // Derived from the above.
  std::vector<Label> side_colors;  // every label that occurs in a code, once
  double reach_mm = 0;             // distance from the centre to the outermost dot's rim
  double arm_mm = 0;               // distance from the centre dot's middle to the outermost dot's rim
  double gap_mm = 0;               // smallest gap between two dots
  /// Dots at about the same distance from the centre dot, by angle, and the middles of the gaps between them.
  struct Ring {
    double radius_mm;
    double spread_mm;  // distance from a dot's middle that is still inside the dot
    double dot_share;  // share of the ring that dots cover
    std::vector<double> dot_angles_rad, gap_angles_rad;
  };
  std::vector<Ring> rings;

  /// The pose of a robot that has its centre dot at this place.
  PatternPose with_center_at(double x_mm, double y_mm, double angle_rad) const;
  /// The place of a robot's centre dot.
  std::array<double, 2> center_of(const PatternPose& robot) const;
};

/// Reads a pattern table from JSON text. Throws SettingsError, its message starting with `path`, for a wrong
/// type or number of colours, an id that occurs twice, dots that overlap or extend beyond the top's rim, or
/// two codes that look alike when the robot turns (the message names both).
PatternTable parse_patterns(const std::string& text, const std::string& path,
                            const LabelSet& labels = LabelSet::built_in());

/// The league's table, config/patterns/league.json, built into the program.
const PatternTable& league_patterns();

}  // namespace sslv
