// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace sslv {

/// The class of colour a pixel belongs to: a LUT entry. Values are those of existing league LUT files.
using Label = std::uint8_t;

namespace label {
inline constexpr Label kClear = 0, kField = 1, kOrange = 2, kYellow = 3, kBlue = 4, kPink = 5, kCyan = 6,
                       kGreen = 7, kWhite = 8, kBlack = 9;
inline constexpr std::size_t kCount = 10;
inline constexpr std::array<std::string_view, kCount> kNames{"clear", "field", "orange", "yellow", "blue",
                                                             "pink",  "cyan",  "green",  "white",  "black"};
}  // namespace label

constexpr std::optional<Label> label_named(std::string_view name) {
  for (std::size_t i = 0; i < label::kCount; ++i) {
    if (label::kNames[i] == name) return static_cast<Label>(i);
  }
  return std::nullopt;
}

}  // namespace sslv
