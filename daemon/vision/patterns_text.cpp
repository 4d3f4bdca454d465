// SPDX-License-Identifier: Apache-2.0
#include "vision/patterns_text.h"

#include "base/json.h"

#include <utility>

namespace sslv {

std::string patterns_text(const PatternTable& table, const LabelSet& labels) {
  Json dots = Json::array(), codes = Json::array();
  for (const PatternDot& dot : table.dots) dots.push_back({dot.x_mm, dot.y_mm, dot.diameter_mm});
  for (const PatternTable::Code& code : table.codes) {
    Json colors = Json::array();
    for (const Label color : code.colors) colors.push_back(labels.name(color));
    codes.push_back({{"id", code.id}, {"colors", std::move(colors)}});
  }
  Json out{{"name", table.name},
           {"center_diameter_mm", table.center_diameter_mm},
           {"dot_diameter_mm", table.dots.at(0).diameter_mm},
           {"top_radius_mm", table.top_radius_mm},
           {"top_front_mm", table.top_front_mm},
           {"team_colors",
            {{"yellow", labels.name(table.team_colors[0])}, {"blue", labels.name(table.team_colors[1])}}},
           {"dots", std::move(dots)},
           {"codes", std::move(codes)}};
  // Version 1.0.0 does not know the key.
  if (table.center_x_mm != 0 || table.center_y_mm != 0)
    out["center"] = {table.center_x_mm, table.center_y_mm};
  return json_text(out);
}

}  // namespace sslv
