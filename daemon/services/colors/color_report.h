// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "colors/surfaces.h"
#include "services/health_report.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sslv {

/// State of a camera's colours.
struct ColorFacts {
  int camera_id = 0;
  /// Smallest margin of its colour table to the carpet; nullopt: unknown.
  struct Margin {
    double share;      // relative change of the light; at most kMax
    std::string text;  // "carpet becomes green at +9 %"; empty: the carpet gets no label
    static constexpr double kMax = LabelMargin::kMaxFactor - 1;
  };
  std::optional<Margin> min_margin{};
  std::vector<std::string> missing_labels{};  // labels of the league's patterns and ball that no cell has
  std::vector<std::string> swapped_labels{};  // "green for pink": labels with another label's hue
  std::string grey_format{};  // its pixel format if it has no colours although the stack labels images
};

/// Adds the cameras' alerts and the check "colors". `lost_tables`: the reason for each saved table that could
/// not be used at start.
void report_colors(std::span<const ColorFacts> cameras, const std::vector<std::string>& lost_tables,
                   HealthReport& report);

}  // namespace sslv
