// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"
#include "image/color.h"
#include "vision/label.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace sslv {

/// A colour lookup table over one colour space, with what a fast look at a picture needs to know of it.
/// Channels are named by their place in the index: `a` outermost (U or R), `b` (V or B), `c` innermost (Y or
/// G), so that the cells of one chroma lie in one cache line.
struct LutTable {
  static constexpr int kBits = 7;
  static constexpr std::size_t kEntries = std::size_t{1} << (3 * kBits);
  static constexpr int kBlockBits = 6, kChromaBits = 5;
  /// Stands for "several labels" in `blocks` and `chroma`.
  static constexpr Label kMixed = 255;

  static constexpr std::size_t index(std::uint8_t a, std::uint8_t b, std::uint8_t c) {
    return static_cast<std::size_t>(a >> 1) << 14 | static_cast<std::size_t>(b >> 1) << 7 |
           static_cast<std::size_t>(c >> 1);
  }
  Label of(std::uint8_t a, std::uint8_t b, std::uint8_t c) const { return labels[index(a, b, c)]; }

  std::vector<Label> labels;  // kEntries, ordered as index() says
  /// The label that all colours of a block of 4x4x4 (2^(8-kBlockBits) a channel) share, or kMixed; ordered
  /// as the labels are.
  std::vector<Label> blocks;
  /// The label that all colours of one chroma share, or kMixed, at chroma_a << 5 | chroma_b. In YUV chroma_a
  /// and chroma_b are the upper five bits of U and V. In RGB they are those of (B + 255 - G + 1) / 2 and
  /// (R + 255 - G + 1) / 2, which byte-wise instructions can make, and a colour may count in several.
  std::array<Label, std::size_t{1} << (2 * kChromaBits)> chroma;
};

/// The colour lookup table: one label for each cell of the colour cube, 7 bits a channel (2 MiB). It is
/// defined over YUV; an RGB twin is derived from it once, so that RGB and Bayer pixels need no conversion.
class Lut {
 public:
  struct Shares {
    std::array<double, 3> mean{1.0 / 3, 1.0 / 3, 1.0 / 3};
    double spread = 0;
  };
  static constexpr int kBits = LutTable::kBits;
  static constexpr std::size_t kEntries = LutTable::kEntries;

  /// All clear.
  Lut();
  /// `yuv` has kEntries labels, ordered as index_yuv says. Throws SettingsError when it has not.
  explicit Lut(std::vector<Label> yuv);

  static constexpr std::size_t index_yuv(std::uint8_t y, std::uint8_t u, std::uint8_t v) {
    return LutTable::index(u, v, y);
  }

  Label of_yuv(std::uint8_t y, std::uint8_t u, std::uint8_t v) const { return yuv_.of(u, v, y); }
  Label of_rgb(std::uint8_t r, std::uint8_t g, std::uint8_t b) const { return rgb_.of(r, b, g); }

  /// Mean shares of red, green and blue (with sum 1) among the label's colours: what stays of a colour when
  /// the light changes. Equal shares for a label without colours.
  const std::array<double, 3>& shares(Label label) const { return shares_[label].mean; }
  /// How far the label's colours lie from that: root mean square distance.
  double share_spread(Label label) const { return shares_[label].spread; }

  const LutTable& yuv() const { return yuv_; }
  const LutTable& rgb() const { return rgb_; }

  /// Another number for every table made in this process: tells whether what was derived from one still
  /// holds.
  std::uint64_t id() const { return id_; }

 private:
  LutTable yuv_, rgb_;
  std::array<Shares, label::kCount> shares_;
  std::uint64_t id_;
};

/// A class of colour by hue and saturation instead of single table cells, so that it holds over a range of
/// light: hue is the angle of (U-128, V-128), counter-clockwise from +U; saturation its length over the luma.
struct ColorClass {
  std::string label;                           // one of label::kNames
  std::array<int, 2> luma{0, 255};             // Y
  std::array<int, 2> hue_deg{0, 360};          // wraps when written as e.g. [340, 380]
  std::array<int, 2> saturation_pct{0, 1000};  // 100 * |(U-128, V-128)| / Y

  static constexpr auto fields() {
    return std::tuple{
        text("label", &ColorClass::label,
             "clear, field, orange, yellow, blue, pink, cyan, green, white or black"),
        range("luma", &ColorClass::luma, 0, 255, "", "brightness Y"),
        range("hue_deg", &ColorClass::hue_deg, 0, 720, "deg",
              "angle of (U-128, V-128) from +U towards +V; may pass 360"),
        range("saturation_pct", &ColorClass::saturation_pct, 0, 10000, "%",
              "length of (U-128, V-128) over Y"),
    };
  }
};

/// Where a camera's table comes from: a `.lut` file, or colour classes of which a later one wins.
struct ColorSettings {
  std::string lut_file;
  std::vector<ColorClass> classes;

  static constexpr auto fields() {
    return std::tuple{
        text("lut_file", &ColorSettings::lut_file, "a .lut file; empty: the table is made from the classes"),
        list("classes", &ColorSettings::classes, "colour classes; a later one wins"),
    };
  }
};

/// Throws SettingsError, beginning with `path`: unknown label, unreadable file, file of the wrong size or
/// format.
std::shared_ptr<const Lut> make_lut(const ColorSettings& colors, const std::string& path);

/// The `.lut` file: 8 bytes "SSLVLUT1", then kEntries labels ordered as Lut::index_yuv.
std::shared_ptr<const Lut> read_lut(const std::string& file, const std::string& path);
std::vector<std::uint8_t> lut_file_bytes(const Lut& lut);

}  // namespace sslv
