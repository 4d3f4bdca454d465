// SPDX-License-Identifier: Apache-2.0
#include "vision/patterns.h"

#include "base/params_json.h"
#include "vision/league_patterns_json.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Two dots of a pattern that lie closer than this after a turn cannot be told apart reliably.
constexpr double kSamePlaceMm = 12;

double positive(const Json& json, const std::string& path, double max) {
  return read_number<double>(json, path, 1.0, max, "mm");
}

/// The codes seen from every turn that puts all dots onto dots: `same[i]` is the dot that dot i comes to lie
/// on.
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
        return std::hypot(other.x_mm - x, other.y_mm - y) < kSamePlaceMm;
      });
      if (near == dots.end()) break;
      same.push_back(static_cast<std::size_t>(near - dots.begin()));
    }
    if (same.size() == dots.size()) found.push_back(same);
  }
  return found;
}

void refuse_look_alikes(const PatternTable& table, const std::string& path) {
  for (const auto& same : symmetries(table.dots)) {
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

}  // namespace

PatternTable parse_patterns(const std::string& json_text, const std::string& path) {
  Json json;
  try {
    json = Json::parse(json_text);
  } catch (const Json::exception& error) {
    throw SettingsError(fmt::format("{}: {}", path, error.what()));
  }
  if (!json.is_object()) refuse(path, json, "an object");
  for (const char* key : {"name", "center_diameter_mm", "dot_diameter_mm", "dots", "codes"}) {
    if (!json.contains(key)) throw SettingsError(fmt::format("{}/{}: is missing", path, key));
  }
  for (const auto& item : json.items()) {
    if (item.key() != "//" && item.key() != "name" && item.key() != "center_diameter_mm" &&
        item.key() != "dot_diameter_mm" && item.key() != "dots" && item.key() != "codes") {
      throw SettingsError(fmt::format(
          "{}/{}: no such parameter; known: name, center_diameter_mm, dot_diameter_mm, dots, codes", path,
          item.key()));
    }
  }
  PatternTable table;
  if (!json["name"].is_string()) refuse(path + "/name", json["name"], "a text");
  table.name = json["name"].get<std::string>();
  table.center_diameter_mm = positive(json["center_diameter_mm"], path + "/center_diameter_mm", 500);
  table.dot_diameter_mm = positive(json["dot_diameter_mm"], path + "/dot_diameter_mm", 500);

  const Json& dots = json["dots"];
  if (!dots.is_array() || dots.size() < 2 || dots.size() > 16)
    refuse(path + "/dots", dots, "2 .. 16 places [x, y]");
  for (std::size_t i = 0; i < dots.size(); ++i) {
    const std::string here = fmt::format("{}/dots/{}", path, i);
    if (!dots[i].is_array() || dots[i].size() != 2) refuse(here, dots[i], "[x, y] in mm");
    table.dots.push_back({read_number<double>(dots[i][0], here + "/0", -500.0, 500.0, "mm"),
                          read_number<double>(dots[i][1], here + "/1", -500.0, 500.0, "mm")});
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
      const auto label = colors[dot].is_string() ? label_named(colors[dot].get<std::string>()) : std::nullopt;
      if (!label || *label == label::kClear)
        refuse(fmt::format("{}/colors/{}", here, dot), colors[dot], "a colour's name");
      code.colors.push_back(*label);
      if (std::find(table.side_colors.begin(), table.side_colors.end(), *label) == table.side_colors.end()) {
        table.side_colors.push_back(*label);
      }
    }
    for (const auto& other : table.codes) {
      if (other.id == code.id)
        throw SettingsError(fmt::format("{}/id: id {} stands there twice", here, code.id));
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

const PatternTable& league_patterns() {
  static const PatternTable kTable = parse_patterns(kLeaguePatternsJson, "config/patterns/league.json");
  return kTable;
}

}  // namespace sslv
