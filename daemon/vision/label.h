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
/// from label::kCount on they are an admin's own.
using Label = std::uint8_t;

namespace label {
inline constexpr Label kClear = 0, kField = 1, kOrange = 2, kYellow = 3, kBlue = 4, kPink = 5, kCyan = 6,
                       kGreen = 7, kWhite = 8, kBlack = 9;
/// Built-in ones.
inline constexpr std::size_t kCount = 10;
/// Values there can be, own ones included.
inline constexpr std::size_t kMaxCount = 32;
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

/// A label of the admin's own, as the settings have it.
struct OwnLabel {
  int value = static_cast<int>(label::kCount);
  std::string name;
  std::string color = "#b45cff";

  static constexpr auto fields() {
    return std::tuple{
        number("value", &OwnLabel::value, static_cast<int>(label::kCount),
               static_cast<int>(label::kMaxCount) - 1, "", "its number in tables and files"),
        text("name", &OwnLabel::name, "printable, up to 32 bytes, no other label's", 32),
        text("color", &OwnLabel::color, "display colour: #rrggbb", 7),
    };
  }
};

struct LabelInfo {
  Label value;
  std::string name;
  Rgb color;  // for people
};

/// "#rrggbb".
std::string hex(Rgb color);

/// The labels that have a name: the built-in ones and the admin's own.
class LabelSet {
 public:
  /// The built-in ones.
  LabelSet();
  /// And those. Throws SettingsError, beginning with `path` (of the list) and an index: a value or name
  /// twice, a name that cannot be shown, a colour that is none.
  LabelSet(const std::vector<OwnLabel>& own, const std::string& path);

  static const LabelSet& built_in();

  /// In the order of their values.
  const std::vector<LabelInfo>& all() const { return labels_; }
  std::optional<Label> find(std::string_view name) const;
  bool has(Label value) const;
  /// For every value: "label 17" when it has no name.
  std::string name(Label value) const;
  Rgb color(Label value) const { return colors_[value % label::kMaxCount]; }
  /// "clear, field, ...", for people.
  std::string names() const;

 private:
  std::vector<LabelInfo> labels_;
  std::array<Rgb, label::kMaxCount> colors_;
};

}  // namespace sslv
