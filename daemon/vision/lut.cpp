// SPDX-License-Identifier: Apache-2.0
#include "vision/lut.h"

#include "base/error.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <numbers>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr std::string_view kMagic = "SSLVLUT1";

/// The middle of a table cell's 8-bit range, rounded up.
constexpr std::uint8_t middle(std::size_t cell) {
  return static_cast<std::uint8_t>(cell * 2 + 1);
}

bool in_class(const ColorClass& color, Yuv c) {
  if (c.y < color.luma[0] || c.y > color.luma[1]) return false;
  const double u = c.u - 128.0, v = c.v - 128.0;
  const double saturation = 100 * std::hypot(u, v) / std::max<double>(1, c.y);
  if (saturation < color.saturation_pct[0] || saturation > color.saturation_pct[1]) return false;
  double hue = std::atan2(v, u) * 180 / std::numbers::pi;
  while (hue < color.hue_deg[0]) hue += 360;
  return hue <= color.hue_deg[1];
}

}  // namespace

Lut::Lut() : yuv_(kEntries, label::kClear), rgb_(kEntries, label::kClear) {}

Lut::Lut(std::vector<Label> yuv) : yuv_(std::move(yuv)), rgb_(kEntries) {
  if (yuv_.size() != kEntries) {
    throw SettingsError(fmt::format("a lookup table has {} labels; expected {}", yuv_.size(), kEntries));
  }
  constexpr std::size_t kSide = std::size_t{1} << kBits;
  for (std::size_t r = 0; r < kSide; ++r) {
    for (std::size_t b = 0; b < kSide; ++b) {
      for (std::size_t g = 0; g < kSide; ++g) {
        const Rgb rgb{middle(r), middle(g), middle(b)};
        const Yuv c = to_yuv(rgb);
        rgb_[index_rgb(rgb.r, rgb.g, rgb.b)] = of_yuv(c.y, c.u, c.v);
      }
    }
  }
}

std::shared_ptr<const Lut> make_lut(const ColorSettings& colors, const std::string& path) {
  for (std::size_t i = 0; i < colors.classes.size(); ++i) {
    if (!label_named(colors.classes[i].label)) {
      std::string known;
      for (const auto name : label::kNames) known += (known.empty() ? "" : ", ") + std::string(name);
      throw SettingsError(fmt::format("{}/classes/{}/label: \"{}\" is not allowed; expected one of {}", path,
                                      i, colors.classes[i].label, known));
    }
  }
  if (!colors.lut_file.empty()) return read_lut(colors.lut_file, path + "/lut_file");

  std::vector<Label> yuv(Lut::kEntries, label::kClear);
  constexpr std::size_t kSide = std::size_t{1} << Lut::kBits;
  for (const ColorClass& color : colors.classes) {
    const Label label = *label_named(color.label);
    for (std::size_t u = 0; u < kSide; ++u) {
      for (std::size_t v = 0; v < kSide; ++v) {
        for (std::size_t y = 0; y < kSide; ++y) {
          const Yuv c{middle(y), middle(u), middle(v)};
          if (in_class(color, c)) yuv[Lut::index_yuv(c.y, c.u, c.v)] = label;
        }
      }
    }
  }
  return std::make_shared<const Lut>(std::move(yuv));
}

std::shared_ptr<const Lut> read_lut(const std::string& file, const std::string& path) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw SettingsError(fmt::format("{}: cannot read \"{}\": {}", path, file, std::strerror(errno)));
  std::vector<Label> bytes{std::istreambuf_iterator<char>(in), {}};
  const std::size_t expected = kMagic.size() + Lut::kEntries;
  if (bytes.size() != expected) {
    throw SettingsError(
        fmt::format("{}: \"{}\" has {} bytes; a .lut file has {} (8 of \"{}\", then one label for each of "
                    "128 x 128 x 128 colours)",
                    path, file, bytes.size(), expected, kMagic));
  }
  if (!std::equal(kMagic.begin(), kMagic.end(), bytes.begin())) {
    throw SettingsError(
        fmt::format("{}: \"{}\" does not begin with \"{}\", so it is no .lut file", path, file, kMagic));
  }
  bytes.erase(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(kMagic.size()));
  const Label highest = *std::max_element(bytes.begin(), bytes.end());
  if (highest >= label::kCount) {
    throw SettingsError(
        fmt::format("{}: \"{}\" holds label {}; labels are 0 .. {}", path, file, highest, label::kCount - 1));
  }
  return std::make_shared<const Lut>(std::move(bytes));
}

std::vector<std::uint8_t> lut_file_bytes(const Lut& lut) {
  std::vector<std::uint8_t> bytes(kMagic.size() + lut.yuv().size());
  std::copy(lut.yuv().begin(), lut.yuv().end(), std::copy(kMagic.begin(), kMagic.end(), bytes.begin()));
  return bytes;
}

}  // namespace sslv
