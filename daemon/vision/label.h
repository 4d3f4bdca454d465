// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"
#include "image/color.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

namespace sslv {

/// The class of colour a pixel belongs to: a LUT entry. Values are the same as in existing league LUT files;
/// values from label::kCount on are defined by the admin.
using Label = std::uint8_t;

namespace label {
inline constexpr Label kClear = 0, kField = 1, kOrange = 2, kYellow = 3, kBlue = 4, kPink = 5, kCyan = 6,
                       kGreen = 7, kWhite = 8, kBlack = 9;
/// Number of built-in labels.
inline constexpr std::size_t kCount = 10;
/// Number of possible values, including the admin's.
inline constexpr std::size_t kMaxCount = 32;
inline constexpr std::array<std::string_view, kCount> kNames{"clear", "field", "orange", "yellow", "blue",
                                                             "pink",  "cyan",  "green",  "white",  "black"};
/// Display colour of each label: no two alike, black darker than clear.
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

/// A label defined by the admin, as in the settings.
struct OwnLabel {
  int value = static_cast<int>(label::kCount);
  std::string name;
  std::string color = "#b45cff";

  static constexpr auto fields() {
    return std::tuple{
        number("value", &OwnLabel::value, static_cast<int>(label::kCount),
               static_cast<int>(label::kMaxCount) - 1, "", "its number in tables and files"),
        text("name", &OwnLabel::name, "unique, printable, up to 32 bytes", 32),
        text("color", &OwnLabel::color, "display colour: #rrggbb", 7),
    };
  }
};

/// A label with its name and display colour.
struct LabelInfo {
  Label value;
  std::string name;
  Rgb color;  // for display
};

/// "#rrggbb".
std::string hex(Rgb color);

/// The labels that have a name: the built-in labels and the admin's labels.
class LabelSet {
 public:
  /// Only the built-in labels.
  LabelSet();
  /// The built-in labels and `own`. Throws SettingsError, its message starting with `path` (of the list) and
  /// an index, for a value or name that occurs twice, a value out of range, a name that cannot be shown, or
  /// an invalid colour.
  LabelSet(const std::vector<OwnLabel>& own, const std::string& path);

  /// LabelSet(), made once.
  static const LabelSet& built_in();

  /// Sorted by value.
  const std::vector<LabelInfo>& all() const { return labels_; }
  /// The label with this name.
  std::optional<Label> find(std::string_view name) const;
  /// True if the label has a name.
  bool has(Label value) const;
  /// Valid for every value: "label 17" if the label has no name.
  std::string name(Label value) const;
  /// Display colour; valid for every value.
  Rgb color(Label value) const { return colors_[value % label::kMaxCount]; }
  /// Human-readable list: "clear, field, ...".
  std::string names() const;

 private:
  std::vector<LabelInfo> labels_;
  std::array<Rgb, label::kMaxCount> colors_;
};

}  // namespace sslv
