// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"
#include "image/color.h"
#include "vision/label.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace sslv {

/// What things of one label look like, whatever the light: shares of red, green and blue in their contrast to
/// black, and how far these scatter (root mean square distance). In units of 1 / kUnit, so that files keep
/// them exactly.
struct PrintColor {
  static constexpr double kUnit = 10'000;
  std::array<std::uint16_t, 3> chromaticity;
  std::uint16_t spread;
  bool operator==(const PrintColor&) const = default;
};
/// Of each label that it is known of.
using Prints = std::array<std::optional<PrintColor>, label::kMaxCount>;

/// A table as people make, save and edit it: one label for each cell of the YUV colour cube.
struct ColorTable {
  static constexpr int kMinBits = 5, kMaxBits = 8;

  /// All clear.
  explicit ColorTable(int bits_a_channel = 7)
      : bits(bits_a_channel), labels(std::size_t{1} << (3 * bits_a_channel)) {}
  ColorTable(int bits_a_channel, std::vector<Label> all) : bits(bits_a_channel), labels(std::move(all)) {}
  bool operator==(const ColorTable&) const = default;

  /// Cells a channel.
  int side() const { return 1 << bits; }
  std::size_t index(std::uint8_t y, std::uint8_t u, std::uint8_t v) const {
    const int shift = 8 - bits;
    return static_cast<std::size_t>(u >> shift) << (2 * bits) | static_cast<std::size_t>(v >> shift) << bits |
           static_cast<std::size_t>(y >> shift);
  }
  Label of(Yuv c) const { return labels[index(c.y, c.u, c.v)]; }
  /// The colour in the middle of a cell, rounded up.
  Yuv color_of(std::size_t cell) const {
    const std::size_t mask = (std::size_t{1} << bits) - 1;
    const auto middle = [this](std::size_t place) {
      const int shift = 8 - bits;
      return static_cast<std::uint8_t>((place << shift) + (std::size_t{1} << shift >> 1));
    };
    return {middle(cell & mask), middle(cell >> (2 * bits)), middle(cell >> bits & mask)};
  }

  int bits;                   // a channel, kMinBits .. kMaxBits
  std::vector<Label> labels;  // ordered U, V, Y, with Y innermost
  /// Where it is known, for instance because the table was learnt from them. A table's cells tell it less
  /// well: what surfaces took from a label is missing there on one side.
  Prints prints{};
};

/// The same table with other bits: finer cells have the label of the one they lie in, a coarser one that of
/// most of those in it, of several the lowest.
ColorTable resampled(const ColorTable& table, int bits);

/// Cells of a ColorTable, one after the other, that changed from one label to another.
struct CellRun {
  std::uint32_t begin, length;
  Label before, after;
  bool operator==(const CellRun&) const = default;
};

/// A colour lookup table over one colour space, with what a fast look at an image needs to know of it.
/// Channels are named by their place in the index: `a` outermost (U or R), `b` (V or B), `c` innermost (Y or
/// G), so that the cells of one chroma lie in one cache line.
struct LutTable {
  /// Of most tables; others have 8.
  static constexpr int kBits = 7;
  static constexpr std::size_t kEntries = std::size_t{1} << (3 * kBits);
  static constexpr int kBlockBits = 6, kChromaBits = 5;
  /// Stands for "several labels" in `blocks` and `chroma`.
  static constexpr Label kMixed = 255;

  static constexpr std::size_t index(std::uint8_t a, std::uint8_t b, std::uint8_t c, int bits = kBits) {
    return static_cast<std::size_t>(a >> (8 - bits)) << (2 * bits) |
           static_cast<std::size_t>(b >> (8 - bits)) << bits | static_cast<std::size_t>(c >> (8 - bits));
  }
  Label of(std::uint8_t a, std::uint8_t b, std::uint8_t c) const { return labels[index(a, b, c, bits)]; }

  int bits = kBits;           // a channel: 7 or 8
  std::vector<Label> labels;  // ordered as index() says
  /// The label that all colours of a block of 4x4x4 (2^(8-kBlockBits) a channel) share, or kMixed; ordered
  /// as the labels are.
  std::vector<Label> blocks;
  /// The label that all colours of one chroma share, or kMixed, at chroma_a << 5 | chroma_b. In YUV chroma_a
  /// and chroma_b are the upper five bits of U and V. In RGB they come from (B + 255 - G + 1) / 2 and
  /// (R + 255 - G + 1) / 2, which byte-wise instructions can make, and a colour may count in several.
  std::array<Label, std::size_t{1} << (2 * kChromaBits)> chroma;
};

/// A colour table made ready for looking up: 7 bits a channel (2 MiB), or 8 (16 MiB) for a table of 8;
/// coarser ones are spread out. It is defined over YUV; an RGB table is derived from it once, so that RGB and
/// Bayer pixels need no conversion.
class Lut {
 public:
  struct Chromaticity {
    std::array<double, 3> mean{1.0 / 3, 1.0 / 3, 1.0 / 3};
    double spread = 0;
  };
  static constexpr int kBits = LutTable::kBits;
  static constexpr std::size_t kEntries = LutTable::kEntries;

  /// All clear.
  Lut();
  /// Throws SettingsError when the number of labels is not that of the bits, or the bits are not allowed.
  explicit Lut(ColorTable table);
  /// `yuv` has kEntries labels, ordered as index_yuv.
  explicit Lut(std::vector<Label> yuv);

  /// What Lut(color_table() with these changes) would be, bit by bit, but for a few hundred cells in a
  /// hundredth of the time. `changed` speaks of cells of color_table(); of labels, only `after`
  /// counts. Throws SettingsError when there are no such cells or labels.
  Lut with_changes(std::span<const CellRun> changed) const { return with_changes(changed, prints_); }
  Lut with_changes(std::span<const CellRun> changed, const Prints& prints) const;

  static constexpr std::size_t index_yuv(std::uint8_t y, std::uint8_t u, std::uint8_t v) {
    return LutTable::index(u, v, y);
  }

  Label of_yuv(std::uint8_t y, std::uint8_t u, std::uint8_t v) const { return yuv_.of(u, v, y); }
  Label of_rgb(std::uint8_t r, std::uint8_t g, std::uint8_t b) const { return rgb_.of(r, b, g); }

  /// The table this was made of.
  ColorTable color_table() const;
  int color_bits() const { return color_bits_; }

  /// Mean chromaticity, the shares of red, green and blue (with sum 1), of the label's prints if the table
  /// has them, else of its cells: what stays of a colour when the light changes. Equal shares for a label
  /// without colours.
  const std::array<double, 3>& chromaticity_mean(Label label) const { return chromaticities_[label].mean; }
  const Prints& prints() const { return prints_; }
  /// How far the label's colours lie from that: root mean square distance.
  double chromaticity_spread(Label label) const { return chromaticities_[label].spread; }

  const LutTable& yuv() const { return yuv_; }
  const LutTable& rgb() const { return rgb_; }

  /// Another number for every table made in this process: tells whether what was derived from one still
  /// holds.
  std::uint64_t id() const { return id_; }
  /// All that it is, its number too, for a copy in another process (pipeline/part_codec.h).
  template <class Self>
  static auto stored(Self& self) {
    return std::tie(self.color_bits_, self.yuv_, self.rgb_, self.prints_, self.chromaticity_sums_,
                    self.chromaticities_, self.id_);
  }

 private:
  /// Sums over a label's colours, so that its chromaticity follows changed cells. Whole numbers: the order of
  /// adding does not matter.
  struct ChromaticitySums {
    std::array<std::int64_t, 3> color{};
    std::int64_t squares = 0;  // of the chromaticities' lengths, times the brightness and kSquareUnit

    void add(int r, int g, int b, int times);
    Chromaticity chromaticity() const;
  };
  void finish_chromaticities();

  int color_bits_;
  LutTable yuv_, rgb_;
  Prints prints_;
  std::array<ChromaticitySums, label::kMaxCount> chromaticity_sums_{};
  std::array<Chromaticity, label::kMaxCount> chromaticities_;
  std::uint64_t id_;
};

/// A class of colour by hue and saturation instead of single table cells, so that it holds over a range of
/// light: hue is the angle of (U-128, V-128), counter-clockwise from +U; saturation its length over the luma.
struct ColorClass {
  std::string label;                           // a LabelSet's name
  std::array<int, 2> luma{0, 255};             // Y
  std::array<int, 2> hue_deg{0, 360};          // wraps when written as e.g. [340, 380]
  std::array<int, 2> saturation_pct{0, 1000};  // 100 * |(U-128, V-128)| / Y

  static constexpr auto fields() {
    return std::tuple{
        text("label", &ColorClass::label,
             "clear, field, orange, yellow, blue, pink, cyan, green, white, black, or an own label"),
        range("luma", &ColorClass::luma, 0, 255, "", "brightness Y"),
        range("hue_deg", &ColorClass::hue_deg, 0, 720, "deg",
              "angle of (U-128, V-128) from +U towards +V; may pass 360"),
        range("saturation_pct", &ColorClass::saturation_pct, 0, 10000, "%",
              "length of (U-128, V-128) over Y"),
    };
  }
};

/// Where a camera's table comes from: one that the service has saved, a `.lut` file, or colour classes of
/// which a later one wins.
struct ColorSettings {
  std::string table;
  std::string lut_file;
  std::vector<ColorClass> classes;
  int bits = 7;

  static constexpr auto fields() {
    return std::tuple{
        text("table", &ColorSettings::table,
             "the table that was edited, learnt or imported on the Colours page; empty: the one of lut_file "
             "or classes"),
        file("lut_file", &ColorSettings::lut_file, "a .lut file; empty: the table is made from the classes"),
        list("classes", &ColorSettings::classes, "colour classes; a later one wins"),
        number("bits", &ColorSettings::bits, ColorTable::kMinBits, ColorTable::kMaxBits, "",
               "of each channel of the table: 5 to 7 cost the same time, 8 more"),
    };
  }
};

/// Throws SettingsError, beginning with `path`: unknown label, unreadable file, file of the wrong size or
/// format.
std::shared_ptr<const Lut> make_lut(const ColorSettings& colors, const std::string& path,
                                    const LabelSet& labels = LabelSet::built_in());
/// The table that make_lut makes ready.
ColorTable make_color_table(const ColorSettings& colors, const std::string& path,
                            const LabelSet& labels = LabelSet::built_in());

/// The same, or one of other bits.
std::shared_ptr<const Lut> with_bits(std::shared_ptr<const Lut> lut, int bits);

/// The `.lut` file, see lut_codec.h.
std::shared_ptr<const Lut> read_lut(const std::string& file, const std::string& path,
                                    const LabelSet& labels = LabelSet::built_in());
std::vector<std::uint8_t> lut_file_bytes(const Lut& lut, const LabelSet& labels = LabelSet::built_in());

}  // namespace sslv
