// SPDX-License-Identifier: Apache-2.0
#pragma once

// JSON of colour tables, as specified in docs/openapi.json.

#include "base/json.h"
#include "colors/light_follower.h"
#include "colors/lut_file.h"
#include "colors/surfaces.h"
#include "services/colors/color_desk.h"
#include "services/colors/color_learning.h"

#include <optional>
#include <string>
#include <vector>

namespace sslv {

/// Difference between the table in use and the accepted table.
struct LightView {
  LightState state;
  std::vector<LightStep> steps;  // oldest first
  bool changed = false;          // the table in use is not the accepted table
};

Json light_json(const LightView& light);
Json colors_json(int camera_id, const std::string& origin, ColorDesk& desk, const LabelSet& labels,
                 const LightView& light, const std::optional<std::vector<LabelMargin>>& margins);
/// JSON of an edit: "cells", "from" and "left_to_carpet".
Json table_change_json(const TableChange& change, const LabelSet& labels);
Json imported_json(const std::vector<ImportedTable>& tables, const LabelSet& labels);
Json learning_json(int camera_id, const ColorLearning::Job& job, const LabelSet& labels);

/// A client's request to learn colours.
struct LearningClick {
  std::string label;
  int x = 0, y = 0, still = 0;
  static constexpr auto fields() {
    using C = LearningClick;
    return std::tuple{text("label", &C::label, "a label's name"), number("x", &C::x, 0, 16383, "px", "place"),
                      number("y", &C::y, 0, 16383, "px", "place"),
                      number("still", &C::still, 0, 2'000'000'000, "", "that was clicked in")};
  }
};
struct LearningRequest {
  int frames = 3;
  std::vector<LearningClick> guide;
  static constexpr auto fields() {
    return std::tuple{number("frames", &LearningRequest::frames, 1, 10, "", "images to learn from"),
                      list("guide", &LearningRequest::guide, "what somebody pointed at")};
  }
};
/// Throws SettingsError.
LearningRequest read_learning_request(const Json& json);

}  // namespace sslv
