// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "colors/surfaces.h"
#include "services/health_report.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sslv {

/// What is known of a camera's colours.
struct ColorFacts {
  int camera_id = 0;
  /// Of its colour table to the carpet; empty: not known.
  struct Margin {
    double share;      // of the light, at most kMax
    std::string text;  // "carpet becomes green at +9 %"; empty: nothing does
    static constexpr double kMax = LabelMargin::kMaxFactor - 1;
  };
  std::optional<Margin> min_margin{};
  std::vector<std::string> missing_labels{};  // that the league's patterns and ball need: no colour has them
  std::vector<std::string> swapped_labels{};  // "green for pink": those that have the hue of another
  std::string grey_format{};                  // its images have no colours, and its stack labels them
};

/// Adds their alerts and the check "colors". `lost_tables`: why saved tables could not be used at start.
void report_colors(std::span<const ColorFacts> cameras, const std::vector<std::string>& lost_tables,
                   HealthReport& report);

}  // namespace sslv
