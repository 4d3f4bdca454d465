// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/color.h"

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
/// What people see for each label: no two alike, black darker than clear.
inline constexpr std::array<Rgb, kCount> kDisplayColors{{
    {52, 54, 58},     // clear
    {40, 124, 70},    // field
    {255, 138, 31},   // orange
    {255, 212, 0},    // yellow
    {58, 116, 255},   // blue
    {255, 84, 166},   // pink
    {60, 214, 240},   // cyan
    {52, 226, 124},   // green
    {233, 237, 242},  // white
    {0, 0, 0},        // black
}};
}  // namespace label

constexpr std::optional<Label> label_named(std::string_view name) {
  for (std::size_t i = 0; i < label::kCount; ++i) {
    if (label::kNames[i] == name) return static_cast<Label>(i);
  }
  return std::nullopt;
}

}  // namespace sslv
