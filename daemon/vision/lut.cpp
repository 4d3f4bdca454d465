// SPDX-License-Identifier: Apache-2.0
#include "vision/lut.h"

#include "base/error.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr std::string_view kMagic = "SSLVLUT1";
constexpr std::size_t kSide = std::size_t{1} << Lut::kBits;

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

/// Takes one more label into account for a place of `blocks` or `chroma`.
void add_label(std::optional<Label>& place, Label label) {
  place = place && *place != label ? LutTable::kMixed : label;
}

template <class Places>
void store(const std::vector<std::optional<Label>>& from, Places& to) {
  std::transform(from.begin(), from.end(), to.begin(), [](auto label) { return label.value_or(0); });
}

void summarise_blocks(LutTable& table) {
  constexpr std::size_t kBlocks = std::size_t{1} << LutTable::kBlockBits, kCells = kSide / kBlocks;
  std::vector<std::optional<Label>> blocks(kBlocks * kBlocks * kBlocks);
  for (std::size_t a = 0; a < kSide; ++a) {
    for (std::size_t b = 0; b < kSide; ++b) {
      for (std::size_t c = 0; c < kSide; ++c) {
        add_label(blocks[((a / kCells) * kBlocks + b / kCells) * kBlocks + c / kCells],
                  table.labels[(a * kSide + b) * kSide + c]);
      }
    }
  }
  table.blocks.resize(blocks.size());
  store(blocks, table.blocks);
}

constexpr std::size_t kChromaSide = std::size_t{1} << LutTable::kChromaBits;

void summarise_yuv_chroma(LutTable& table) {
  std::vector<std::optional<Label>> chroma(table.chroma.size());
  for (std::size_t i = 0; i < table.labels.size(); ++i) {
    const std::size_t u = i / (kSide * kSide), v = i / kSide % kSide;
    add_label(chroma[u * kChromaSide / kSide * kChromaSide + v * kChromaSide / kSide], table.labels[i]);
  }
  store(chroma, table.chroma);
}

void summarise_rgb_chroma(LutTable& table) {
  // Of a cell's 2x2x2 colours, those at its ends reach all chromas that any of them can.
  const auto reached = [](std::size_t cell, std::size_t green_cell) {
    const std::size_t low = (2 * cell + 255 - (2 * green_cell + 1) + 1) / 2;
    const std::size_t high = (2 * cell + 1 + 255 - 2 * green_cell + 1) / 2;
    return std::pair{low * kChromaSide / 256, high * kChromaSide / 256};
  };
  std::vector<std::optional<Label>> chroma(table.chroma.size());
  for (std::size_t i = 0; i < table.labels.size(); ++i) {
    const std::size_t r = i / (kSide * kSide), b = i / kSide % kSide, g = i % kSide;
    const auto [a_low, a_high] = reached(b, g);
    const auto [b_low, b_high] = reached(r, g);
    for (std::size_t chroma_a = a_low; chroma_a <= a_high; ++chroma_a) {
      for (std::size_t chroma_b = b_low; chroma_b <= b_high; ++chroma_b) {
        add_label(chroma[chroma_a * kChromaSide + chroma_b], table.labels[i]);
      }
    }
  }
  store(chroma, table.chroma);
}

/// Every other colour each way is enough for a mean. Bright colours count more: the shares of dark ones are
/// vague.
std::array<Lut::Shares, label::kCount> shares_of(const LutTable& rgb) {
  struct Sums {
    std::array<double, 3> color{};
    double squares = 0;  // of the shares' lengths, times the brightness
  };
  std::array<Sums, label::kCount> sums;
  for (std::size_t r = 0; r < kSide; r += 2) {
    for (std::size_t b = 0; b < kSide; b += 2) {
      for (std::size_t g = 0; g < kSide; g += 2) {
        const Label label = rgb.labels[LutTable::index(middle(r), middle(b), middle(g))];
        if (label == label::kClear) continue;
        const std::array<double, 3> color{static_cast<double>(middle(r)), static_cast<double>(middle(g)),
                                          static_cast<double>(middle(b))};
        double squares = 0;
        for (std::size_t c = 0; c < 3; ++c) {
          sums[label].color[c] += color[c];
          squares += color[c] * color[c];
        }
        sums[label].squares += squares / (color[0] + color[1] + color[2]);
      }
    }
  }
  std::array<Lut::Shares, label::kCount> out;
  for (std::size_t label = 0; label < out.size(); ++label) {
    const auto& [color, squares] = sums[label];
    const double weight = color[0] + color[1] + color[2];
    if (weight <= 0) continue;
    double length2 = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      out[label].mean[c] = color[c] / weight;
      length2 += out[label].mean[c] * out[label].mean[c];
    }
    out[label].spread = std::sqrt(std::max(0.0, squares / weight - length2));
  }
  return out;
}

}  // namespace

Lut::Lut() : Lut(std::vector<Label>(kEntries, label::kClear)) {}

Lut::Lut(std::vector<Label> yuv) {
  static std::atomic<std::uint64_t> made{0};
  id_ = ++made;
  if (yuv.size() != kEntries) {
    throw SettingsError(fmt::format("a lookup table has {} labels; expected {}", yuv.size(), kEntries));
  }
  yuv_.labels = std::move(yuv);
  rgb_.labels.resize(kEntries);
  for (std::size_t r = 0; r < kSide; ++r) {
    for (std::size_t b = 0; b < kSide; ++b) {
      for (std::size_t g = 0; g < kSide; ++g) {
        const Rgb rgb{middle(r), middle(g), middle(b)};
        const Yuv c = to_yuv(rgb);
        rgb_.labels[LutTable::index(rgb.r, rgb.b, rgb.g)] = of_yuv(c.y, c.u, c.v);
      }
    }
  }
  for (LutTable* table : {&yuv_, &rgb_}) summarise_blocks(*table);
  summarise_yuv_chroma(yuv_);
  summarise_rgb_chroma(rgb_);
  shares_ = shares_of(rgb_);
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
  std::vector<std::uint8_t> bytes(kMagic.size() + lut.yuv().labels.size());
  std::copy(lut.yuv().labels.begin(), lut.yuv().labels.end(),
            std::copy(kMagic.begin(), kMagic.end(), bytes.begin()));
  return bytes;
}

}  // namespace sslv
