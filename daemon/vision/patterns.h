// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/label.h"

#include <string>
#include <vector>

namespace sslv {

/// A coloured dot on a robot's top, in the robot's frame: x forward, y left, millimetres from the centre.
struct PatternDot {
  double x_mm, y_mm;
};

/// The league's way of telling robots apart: a centre dot in the team's colour and side dots at fixed places
/// whose colours spell the id. Places, sizes, colours and codes are data (config/patterns).
struct PatternTable {
  std::string name;
  double center_diameter_mm = 50;
  double dot_diameter_mm = 40;
  std::vector<PatternDot> dots;  // places of the side dots

  struct Code {
    int id;
    std::vector<Label> colors;  // one for each dot
  };
  std::vector<Code> codes;

  std::vector<Label> side_colors;  // every label that occurs in a code, once
};

/// Reads a pattern table from JSON text. Throws SettingsError, beginning with `path`: wrong type or number of
/// colours, an id twice, or two codes that look alike when the robot turns (both named).
PatternTable parse_patterns(const std::string& json_text, const std::string& path);

/// The league's table, config/patterns/league.json, built into the program.
const PatternTable& league_patterns();

}  // namespace sslv
