// SPDX-License-Identifier: Apache-2.0
#include "vision/label.h"

#include "base/error.h"
#include "base/plain_text.h"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr std::size_t kLongestName = 32;
/// Display colour of labels without a name in a table.
constexpr Rgb kNamelessColor{180, 92, 255};
/// Prefix of LabelSet::name() for labels without a name.
constexpr std::string_view kNameless = "label ";

/// Whether the name is plain text without a space at either end.
bool can_be_shown(std::string_view name) {
  return !name.empty() && name.front() != ' ' && name.back() != ' ' && is_plain_text(name);
}

bool looks_nameless(std::string_view name) {
  return name.substr(0, kNameless.size()) == kNameless && name.size() > kNameless.size() &&
         std::all_of(name.begin() + kNameless.size(), name.end(),
                     [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; });
}

std::optional<Rgb> color_of(std::string_view text) {
  if (text.size() != 7 || text[0] != '#') return std::nullopt;
  std::array<int, 6> digits{};
  for (std::size_t i = 0; i < digits.size(); ++i) {
    const char c = text[i + 1];
    if (c >= '0' && c <= '9') {
      digits[i] = c - '0';
    } else if (c >= 'a' && c <= 'f') {
      digits[i] = c - 'a' + 10;
    } else if (c >= 'A' && c <= 'F') {
      digits[i] = c - 'A' + 10;
    } else {
      return std::nullopt;
    }
  }
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(16 * digits[i] + digits[i + 1]); };
  return Rgb{byte(0), byte(2), byte(4)};
}

}  // namespace

std::string hex(Rgb color) {
  return fmt::format("#{:02x}{:02x}{:02x}", color.r, color.g, color.b);
}

LabelSet::LabelSet() {
  colors_.fill(kNamelessColor);
  for (std::size_t i = 0; i < label::kCount; ++i) {
    labels_.push_back({static_cast<Label>(i), std::string(label::kNames[i]), label::kDisplayColors[i]});
    colors_[i] = label::kDisplayColors[i];
  }
}

LabelSet::LabelSet(const std::vector<OwnLabel>& own, const std::string& path) : LabelSet() {
  for (std::size_t i = 0; i < own.size(); ++i) {
    const std::string here = fmt::format("{}/{}", path, i);
    const OwnLabel& label = own[i];
    const auto refuse = [&](std::string_view key, const auto& value, std::string_view why) {
      throw SettingsError(fmt::format("{}/{}: {} {}", here, key, value, why));
    };
    if (label.value < static_cast<int>(label::kCount) || label.value >= static_cast<int>(label::kMaxCount)) {
      refuse("value", label.value,
             fmt::format("is not allowed; expected {} .. {}", label::kCount, label::kMaxCount - 1));
    }
    const auto value = static_cast<Label>(label.value);
    const std::string quoted = '"' + escaped_text(label.name) + '"';
    if (has(value)) refuse("value", label.value, fmt::format("is \"{}\" already", name(value)));
    if (label.name.size() > kLongestName || !can_be_shown(label.name) || looks_nameless(label.name)) {
      refuse("name", quoted,
             fmt::format("is not allowed; expected 1 .. {} bytes without control characters, no space at "
                         "its ends, and not \"{}\" and a number",
                         kLongestName, kNameless));
    }
    if (find(label.name)) refuse("name", quoted, "is taken: each label needs its own name");
    const auto color = color_of(label.color);
    if (!color) refuse("color", '"' + label.color + '"', "is not allowed; expected #rrggbb");
    labels_.push_back({value, label.name, *color});
    colors_[value] = *color;
  }
  std::sort(labels_.begin(), labels_.end(), [](const auto& a, const auto& b) { return a.value < b.value; });
}

const LabelSet& LabelSet::built_in() {
  static const LabelSet kSet;
  return kSet;
}

std::optional<Label> LabelSet::find(std::string_view name) const {
  for (const LabelInfo& label : labels_) {
    if (label.name == name) return label.value;
  }
  return std::nullopt;
}

bool LabelSet::has(Label value) const {
  return std::any_of(labels_.begin(), labels_.end(), [&](const auto& label) { return label.value == value; });
}

std::string LabelSet::name(Label value) const {
  for (const LabelInfo& label : labels_) {
    if (label.value == value) return label.name;
  }
  return fmt::format("{}{}", kNameless, value);
}

std::string LabelSet::names() const {
  std::string out;
  for (const LabelInfo& label : labels_) out += (out.empty() ? "" : ", ") + label.name;
  return out;
}

}  // namespace sslv
