// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/label.h"

#include <array>
#include <string>
#include <vector>

namespace sslv {

/// A coloured dot on a robot's top, in the robot's frame: x forward, y left, millimetres from the centre.
struct PatternDot {
  double x_mm, y_mm, diameter_mm;
};

/// The league's way of telling robots apart: a centre dot in the team's colour and side dots at fixed places
/// whose colours spell the id. Places, sizes, colours and codes are data (config/patterns).
struct PatternTable {
  static constexpr std::size_t kMaxDots = 16;  // side dots

  std::string name;
  double center_diameter_mm = 50;
  std::array<Label, 2> team_colors{label::kYellow, label::kBlue};  // of the centre dot, by Team
  std::vector<PatternDot> dots;                                    // side dots
  /// The robot's top: black, round, with a flat front. What lies beyond it is not the robot's.
  double top_radius_mm = 90, top_front_mm = 55;

  struct Code {
    int id;
    std::vector<Label> colors;  // one for each dot
  };
  std::vector<Code> codes;

  // Derived from the above.
  std::vector<Label> side_colors;  // every label that occurs in a code, once
  double reach_mm = 0;             // from the centre to the outermost dot's rim
  double gap_mm = 0;               // least black between two dots
  /// The dots that lie about as far from the centre, by angle, and the middles of the black between them.
  struct Ring {
    double radius_mm;
    double spread_mm;  // stays inside a dot from its middle
    std::vector<double> dot_angles_rad, gap_angles_rad;
  };
  std::vector<Ring> rings;
};

/// Reads a pattern table from JSON text. Throws SettingsError, beginning with `path`: wrong type or number of
/// colours, an id twice, dots that overlap or stand over the top's rim, or two codes that look alike when the
/// robot turns (both named).
PatternTable parse_patterns(const std::string& json_text, const std::string& path,
                            const LabelSet& labels = LabelSet::built_in());

/// The league's table, config/patterns/league.json, built into the program.
const PatternTable& league_patterns();

}  // namespace sslv
