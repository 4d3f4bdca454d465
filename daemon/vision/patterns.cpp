// SPDX-License-Identifier: Apache-2.0
#include "vision/patterns.h"

#include "base/params_json.h"
#include "vision/league_patterns_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <numbers>
#include <string_view>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Two dots of a pattern that lie closer than this after a rotation cannot be distinguished reliably.
constexpr double kMinDotDistanceMm = 12;

/// Side dots relative to the centre dot.
std::vector<PatternDot> around_center(const PatternTable& table) {
  std::vector<PatternDot> dots = table.dots;
  for (PatternDot& dot : dots) {
    dot.x_mm -= table.center_x_mm;
    dot.y_mm -= table.center_y_mm;
  }
  return dots;
}

/// All rotations about the centre dot that map all dots to dots: `same[i]` is the dot that dot i is mapped
/// to.
std::vector<std::vector<std::size_t>> symmetries(const std::vector<PatternDot>& dots) {
  std::vector<std::vector<std::size_t>> found;
  for (std::size_t target = 0; target < dots.size(); ++target) {
    const double turn =
        std::atan2(dots[target].y_mm, dots[target].x_mm) - std::atan2(dots[0].y_mm, dots[0].x_mm);
    std::vector<std::size_t> same;
    for (const PatternDot& dot : dots) {
      const double x = std::cos(turn) * dot.x_mm - std::sin(turn) * dot.y_mm;
      const double y = std::sin(turn) * dot.x_mm + std::cos(turn) * dot.y_mm;
      const auto near = std::find_if(dots.begin(), dots.end(), [&](const PatternDot& other) {
        return std::hypot(other.x_mm - x, other.y_mm - y) < kMinDotDistanceMm;
      });
      if (near == dots.end()) break;
      same.push_back(static_cast<std::size_t>(near - dots.begin()));
    }
    if (same.size() == dots.size()) found.push_back(same);
  }
  return found;
}

void refuse_look_alikes(const PatternTable& table, const std::string& path) {
  for (const auto& same : symmetries(around_center(table))) {
    for (std::size_t a = 0; a < table.codes.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        bool alike = true;
        for (std::size_t dot = 0; dot < same.size(); ++dot) {
          alike = alike && table.codes[a].colors[dot] == table.codes[b].colors[same[dot]];
        }
        if (alike) {
          throw SettingsError(fmt::format("{}/codes: ids {} and {} look alike when a robot turns", path,
                                          table.codes[b].id, table.codes[a].id));
        }
      }
    }
  }
}

struct Key {
  std::string_view name;
  bool needed;
};
constexpr std::array kKeys{
    Key{"//", false},
    Key{"name", true},
    Key{"center_diameter_mm", true},
    Key{"dot_diameter_mm", true},
    Key{"center", false},
    Key{"dots", true},
    Key{"codes", true},
    Key{"team_colors", false},
    Key{"top_radius_mm", false},
    Key{"top_front_mm", false},
};

void check_keys(const Json& json, const std::string& path) {
  if (!json.is_object()) refuse(path, json, "an object");
  std::string known;
  for (const Key& key : kKeys) {
    if (key.needed && !json.contains(key.name)) {
      throw SettingsError(fmt::format("{}/{}: is missing", path, key.name));
    }
    if (key.name != "//") known += (known.empty() ? "" : ", ") + std::string(key.name);
  }
  for (const auto& item : json.items()) {
    const bool is_known =
        std::any_of(kKeys.begin(), kKeys.end(), [&](const Key& key) { return key.name == item.key(); });
    if (!is_known) {
      throw SettingsError(fmt::format("{}/{}: no such parameter; known: {}", path, item.key(), known));
    }
  }
}

double millimetres(const Json& json, const std::string& path, double min, double max) {
  return read_number<double>(json, path, min, max, "mm");
}

Label color_of(const Json& json, const std::string& path, const LabelSet& labels) {
  const auto label = json.is_string() ? labels.find(json.get<std::string>()) : std::nullopt;
  if (!label || *label == label::kClear) refuse(path, json, "a colour's name");
  return *label;
}

std::vector<PatternDot> dots_of(const Json& dots, double diameter_mm, const std::string& path) {
  if (!dots.is_array() || dots.size() < 2 || dots.size() > PatternTable::kMaxDots)
    refuse(path, dots, "2 .. 16 places [x, y] or [x, y, diameter]");
  std::vector<PatternDot> out;
  for (std::size_t i = 0; i < dots.size(); ++i) {
    const std::string here = fmt::format("{}/{}", path, i);
    const Json& dot = dots[i];
    if (!dot.is_array() || dot.size() < 2 || dot.size() > 3)
      refuse(here, dot, "[x, y] or [x, y, diameter] in mm");
    out.push_back({millimetres(dot[0], here + "/0", -500, 500), millimetres(dot[1], here + "/1", -500, 500),
                   dot.size() == 3 ? millimetres(dot[2], here + "/2", 1, 500) : diameter_mm});
  }
  return out;
}

/// Fills reach_mm, arm_mm and gap_mm, and refuses dots that overlap or extend beyond the rim.
void measure(PatternTable& table, const std::string& path) {
  table.gap_mm = 1000;
  const PatternDot center{table.center_x_mm, table.center_y_mm, table.center_diameter_mm};
  const auto check_rim = [&](const PatternDot& dot, const std::string& where) {
    const double out_mm = std::hypot(dot.x_mm, dot.y_mm) + dot.diameter_mm / 2;
    table.reach_mm = std::max(table.reach_mm, out_mm);
    if (out_mm > table.top_radius_mm || dot.x_mm + dot.diameter_mm / 2 > table.top_front_mm) {
      throw SettingsError(
          fmt::format("{}/{}: extends beyond the rim of the top (top_radius_mm {}, top_front_mm {})", path,
                      where, table.top_radius_mm, table.top_front_mm));
    }
  };
  check_rim(center, "center");
  for (std::size_t i = 0; i < table.dots.size(); ++i) {
    const PatternDot& dot = table.dots[i];
    check_rim(dot, fmt::format("dots/{}", i));
    table.arm_mm = std::max(table.arm_mm,
                            std::hypot(dot.x_mm - center.x_mm, dot.y_mm - center.y_mm) + dot.diameter_mm / 2);
    for (std::size_t j = 0; j <= i; ++j) {
      const PatternDot& other = j == 0 ? center : table.dots[j - 1];
      const double gap_mm = std::hypot(dot.x_mm - other.x_mm, dot.y_mm - other.y_mm) -
                            (dot.diameter_mm + other.diameter_mm) / 2;
      if (gap_mm < 0) {
        throw SettingsError(fmt::format("{}/dots/{}: overlaps {}", path, i,
                                        j == 0 ? "the centre dot" : fmt::format("dot {}", j - 1)));
      }
      table.gap_mm = std::min(table.gap_mm, gap_mm);
    }
  }
}

void collect_rings(PatternTable& table) {
  const std::vector<PatternDot> dots = around_center(table);
  for (const PatternDot& dot : dots) {
    const double radius_mm = std::hypot(dot.x_mm, dot.y_mm);
    auto ring = std::find_if(table.rings.begin(), table.rings.end(), [&](const PatternTable::Ring& r) {
      return std::abs(r.radius_mm - radius_mm) < dot.diameter_mm / 8;
    });
    if (ring == table.rings.end())
      ring = table.rings.insert(ring, {radius_mm, 0.2 * dot.diameter_mm, 0, {}, {}});
    ring->dot_angles_rad.push_back(std::atan2(dot.y_mm, dot.x_mm));
    ring->dot_share += dot.diameter_mm / (2 * std::numbers::pi * ring->radius_mm);
  }
  for (PatternTable::Ring& ring : table.rings) {
    auto& angles = ring.dot_angles_rad;
    std::sort(angles.begin(), angles.end());
    for (std::size_t i = 0; i < angles.size(); ++i) {
      const double next = i + 1 < angles.size() ? angles[i + 1] : angles[0] + 2 * std::numbers::pi;
      const double middle = (angles[i] + next) / 2;
      const double x_mm = ring.radius_mm * std::cos(middle), y_mm = ring.radius_mm * std::sin(middle);
      const bool on_dot = std::any_of(dots.begin(), dots.end(), [&](const PatternDot& dot) {
        return std::hypot(x_mm - dot.x_mm, y_mm - dot.y_mm) < dot.diameter_mm / 2 + ring.spread_mm;
      });
      const double top_x_mm = x_mm + table.center_x_mm, top_y_mm = y_mm + table.center_y_mm;
      const bool on_top = top_x_mm + ring.spread_mm < table.top_front_mm &&
                          std::hypot(top_x_mm, top_y_mm) + ring.spread_mm < table.top_radius_mm;
      if (!on_dot && on_top) ring.gap_angles_rad.push_back(middle);
    }
  }
}

}  // namespace

PatternTable parse_patterns(const std::string& text, const std::string& path, const LabelSet& labels) {
  Json json;
  try {
    json = parse_bounded_json(text);
  } catch (const std::exception& error) {
    throw SettingsError(fmt::format("{}: {}", path, error.what()));
  }
  check_keys(json, path);
  PatternTable table;
  if (!json["name"].is_string()) refuse(path + "/name", json["name"], "a text");
  table.name = json["name"].get<std::string>();
  table.center_diameter_mm = millimetres(json["center_diameter_mm"], path + "/center_diameter_mm", 1, 500);
  if (json.contains("top_radius_mm"))
    table.top_radius_mm = millimetres(json["top_radius_mm"], path + "/top_radius_mm", 1, 1000);
  // A top without a flat front ends at the circle.
  table.top_front_mm = json.contains("top_front_mm")
                           ? millimetres(json["top_front_mm"], path + "/top_front_mm", 1, 1000)
                           : table.top_radius_mm;
  if (json.contains("center")) {
    const Json& center = json["center"];
    if (!center.is_array() || center.size() != 2) refuse(path + "/center", center, "[x, y] in mm");
    table.center_x_mm = millimetres(center[0], path + "/center/0", -500, 500);
    table.center_y_mm = millimetres(center[1], path + "/center/1", -500, 500);
  }
  table.dots = dots_of(json["dots"], millimetres(json["dot_diameter_mm"], path + "/dot_diameter_mm", 1, 500),
                       path + "/dots");
  measure(table, path);
  collect_rings(table);
  if (json.contains("team_colors")) {
    const Json& colors = json["team_colors"];
    const std::string here = path + "/team_colors";
    if (!colors.is_object() || colors.size() != 2 || !colors.contains("yellow") || !colors.contains("blue"))
      refuse(here, colors, "{\"yellow\": colour, \"blue\": colour}");
    table.team_colors = {color_of(colors["yellow"], here + "/yellow", labels),
                         color_of(colors["blue"], here + "/blue", labels)};
    if (table.team_colors[0] == table.team_colors[1])
      throw SettingsError(fmt::format("{}: both teams have the same colour", here));
  }

  const Json& codes = json["codes"];
  if (!codes.is_array() || codes.empty()) refuse(path + "/codes", codes, "a list of {id, colors}");
  for (std::size_t i = 0; i < codes.size(); ++i) {
    const std::string here = fmt::format("{}/codes/{}", path, i);
    if (!codes[i].is_object() || !codes[i].contains("id") || !codes[i].contains("colors") ||
        codes[i].size() != 2) {
      refuse(here, codes[i], "{\"id\": ..., \"colors\": [...]}");
    }
    PatternTable::Code code{read_number<int>(codes[i]["id"], here + "/id", 0, 255, ""), {}};
    const Json& colors = codes[i]["colors"];
    if (!colors.is_array() || colors.size() != table.dots.size()) {
      refuse(here + "/colors", colors, fmt::format("{} colours, one for each dot", table.dots.size()));
    }
    for (std::size_t dot = 0; dot < colors.size(); ++dot) {
      const Label label = color_of(colors[dot], fmt::format("{}/colors/{}", here, dot), labels);
      code.colors.push_back(label);
      if (std::find(table.side_colors.begin(), table.side_colors.end(), label) == table.side_colors.end()) {
        table.side_colors.push_back(label);
      }
    }
    for (const auto& other : table.codes) {
      if (other.id == code.id)
        throw SettingsError(fmt::format("{}/id: id {} is in the list twice", here, code.id));
      if (other.colors == code.colors) {
        throw SettingsError(
            fmt::format("{}/colors: ids {} and {} have the same colours", here, other.id, code.id));
      }
    }
    table.codes.push_back(std::move(code));
  }
  refuse_look_alikes(table, path);
  return table;
}

PatternPose PatternTable::with_center_at(double x_mm, double y_mm, double angle_rad) const {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  return {x_mm - c * center_x_mm + s * center_y_mm, y_mm - s * center_x_mm - c * center_y_mm, angle_rad};
}

std::array<double, 2> PatternTable::center_of(const PatternPose& robot) const {
  const double c = std::cos(robot.angle_rad), s = std::sin(robot.angle_rad);
  return {robot.x_mm + c * center_x_mm - s * center_y_mm, robot.y_mm + s * center_x_mm + c * center_y_mm};
}

const PatternTable& league_patterns() {
  static const PatternTable kTable = parse_patterns(kLeaguePatternsJson, "config/patterns/league.json");
  return kTable;
}

}  // namespace sslv
