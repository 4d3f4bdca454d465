// SPDX-License-Identifier: Apache-2.0
// In a header alone: ssl-visionctl shows margins too, and links no engine.
#pragma once

#include <cmath>
#include <string>
#include <string_view>

#include <fmt/format.h>

namespace sslv {

/// Wanted minimum of all margins: lamps differ by that much over a field, and from day to day.
inline constexpr double kWantedMargin = 0.30;

/// "carpet becomes green at +9 %", or "carpet is green now".
inline std::string margin_text(std::string_view surface, std::string_view label, double change) {
  const double percent = std::round(100 * std::abs(change));
  if (percent == 0) return fmt::format("{} is {} now", surface, label);
  return fmt::format("{} becomes {} at {}{:.0f} %", surface, label, change < 0 ? "\u2212" : "+", percent);
}

}  // namespace sslv
