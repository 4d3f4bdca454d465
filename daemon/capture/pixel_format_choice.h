// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"
#include "image/pixel_format_names.h"

#include <array>
#include <cstddef>
#include <optional>

namespace sslv {

/// Choices of a backend's pixel_format option.
inline constexpr auto kPixelFormatChoices = [] {
  std::array<Choice<PixelFormat>, kPixelFormatNames.size()> choices{};
  for (std::size_t i = 0; i < choices.size(); ++i) {
    choices[i] = {kPixelFormatNames[i].name, kPixelFormatNames[i].format};
  }
  return choices;
}();

/// The same for a backend with automatic detection: nullopt means "auto".
using PixelFormatOrAuto = std::optional<PixelFormat>;
inline constexpr auto kPixelFormatOrAutoChoices = [] {
  std::array<Choice<PixelFormatOrAuto>, kPixelFormatNames.size() + 1> choices{};
  choices[0] = {"auto", std::nullopt};
  for (std::size_t i = 0; i < kPixelFormatNames.size(); ++i) {
    choices[i + 1] = {kPixelFormatNames[i].name, kPixelFormatNames[i].format};
  }
  return choices;
}();

}  // namespace sslv
