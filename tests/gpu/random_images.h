// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"
#include "vision/lut.h"
#include "vision/mask.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <random>
#include <utility>
#include <vector>

namespace sslv {

using Random = std::mt19937;

inline constexpr std::array kAllFormats{
    PixelFormat::kUyvy,     PixelFormat::kYuyv,     PixelFormat::kRgb24,
    PixelFormat::kBgr24,    PixelFormat::kMono8,    PixelFormat::kBayerRg8,
    PixelFormat::kBayerGr8, PixelFormat::kBayerGb8, PixelFormat::kBayerBg8};

inline int random_int(Random& random, int low, int high) {
  return std::uniform_int_distribution(low, high)(random);
}

/// An image in a buffer that ends with its last byte, so that sanitizers detect reads beyond it.
class Drawn {
 public:
  /// `more`: padding bytes between two rows.
  Drawn(PixelFormat format, int width, int height, int more = 0)
      : row_(static_cast<std::size_t>(width * bytes_per_pixel(format))),
        size_((row_ + static_cast<std::size_t>(more)) * static_cast<std::size_t>(height) -
              static_cast<std::size_t>(more)),
        bytes_(std::make_unique<std::uint8_t[]>(size_)),
        view_{bytes_.get(), width, height, static_cast<std::ptrdiff_t>(row_) + more, format} {}

  void fill(Random& random) {
    std::generate_n(bytes_.get(), size_, [&] { return static_cast<std::uint8_t>(random() >> 8); });
  }
  /// Stores the last row first, as some drivers do.
  void turn_over() {
    view_.data += view_.stride_bytes * (view_.height - 1);
    view_.stride_bytes = -view_.stride_bytes;
  }
  std::uint8_t* row(int y) { return bytes_.get() + (view_.row(y) - bytes_.get()); }
  const ImageView& view() const { return view_; }
  Image image() const { return {view_, nullptr, nullptr, nullptr}; }

 private:
  std::size_t row_, size_;
  std::unique_ptr<std::uint8_t[]> bytes_;
  ImageView view_;
};

inline Mask random_mask(Random& random, int width, int height) {
  MaskSettings settings;
  for (auto* polygons : {&settings.include, &settings.exclude}) {
    for (int count = random_int(random, 0, 2); count > 0; --count) {
      MaskPolygon& polygon = polygons->emplace_back();
      for (int corners = random_int(random, 3, 6); corners > 0; --corners) {
        polygon.points.push_back(
            {random_int(random, -20, 2 * width + 20) * 0.5, random_int(random, -20, 2 * height + 20) * 0.5});
      }
    }
  }
  return Mask(settings);
}

/// A random label for each colour.
inline Lut random_lut(Random& random, int bits) {
  ColorTable table(bits);
  for (Label& label : table.labels) label = static_cast<Label>(random() % label::kMaxCount);
  return Lut(std::move(table));
}

/// One table of each number of bits, made once: making them takes longer than labelling an image.
inline const std::vector<Lut>& random_luts() {
  static const auto made = [] {
    Random random(10);
    std::vector<Lut> all;
    for (const int bits : {5, 6, 7, 8}) all.push_back(random_lut(random, bits));
    return all;
  }();
  return made;
}
inline const Lut& random_lut(int bits) {
  return random_luts()[static_cast<std::size_t>(bits - 5)];
}

}  // namespace sslv
