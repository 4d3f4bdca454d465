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

/// Colour of the prints of one label (robots' dots, or the ball), independent of the light: the chromaticity
/// (shares of red, green and blue) of their contrast to black, and its spread (root mean square distance). In
/// units of 1 / kUnit, so that files store the values exactly.
struct PrintColor {
  static constexpr double kUnit = 10'000;
  std::array<std::uint16_t, 3> chromaticity;
  std::uint16_t spread;
  bool operator==(const PrintColor&) const = default;
};
/// Print colours, indexed by label; empty if not known.
using Prints = std::array<std::optional<PrintColor>, label::kMaxCount>;

/// A table in the form in which it is made, saved and edited: one label for each cell of the YUV colour cube.
struct ColorTable {
  static constexpr int kMinBits = 5, kMaxBits = 8;

  /// All clear.
  explicit ColorTable(int bits_a_channel = 7)
      : bits(bits_a_channel), labels(std::size_t{1} << (3 * bits_a_channel)) {}
  /// `all` has 2^(3 * bits_a_channel) labels in the order of `labels`.
  ColorTable(int bits_a_channel, std::vector<Label> all) : bits(bits_a_channel), labels(std::move(all)) {}
  bool operator==(const ColorTable&) const = default;

  /// Cells per channel.
  int side() const { return 1 << bits; }
  /// The cell that contains this colour.
  std::size_t index(std::uint8_t y, std::uint8_t u, std::uint8_t v) const {
    const int shift = 8 - bits;
    return static_cast<std::size_t>(u >> shift) << (2 * bits) | static_cast<std::size_t>(v >> shift) << bits |
           static_cast<std::size_t>(y >> shift);
  }
  /// The label of this colour.
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

  int bits;                   // per channel, kMinBits .. kMaxBits
  std::vector<Label> labels;  // ordered U, V, Y, with Y innermost
  /// Known, for instance, if the table was learnt from prints. The table's cells are a worse source: if a
  /// label lost cells to surfaces, these cells are missing on one side of its colour.
  Prints prints{};
};

/// The same table with another number of bits. A finer cell gets the label of the cell that contains it. A
/// coarser cell gets the most frequent label of the cells in it; if there are several, the lowest of these
/// labels.
ColorTable resampled(const ColorTable& table, int bits);

/// Consecutive cells of a ColorTable that changed from one label to another.
struct CellRun {
  std::uint32_t begin, length;
  Label before, after;
  bool operator==(const CellRun&) const = default;
};

/// A colour lookup table over one colour space, with summaries for fast segmentation. Channels are named by
/// their position in the index: `a` outermost (U or R), `b` (V or B), `c` innermost (Y or G), so that the
/// cells of one chroma lie in one cache line.
struct LutTable {
  /// Bits per channel of most tables; the other tables have 8.
  static constexpr int kBits = 7;
  static constexpr std::size_t kEntries = std::size_t{1} << (3 * kBits);
  static constexpr int kBlockBits = 6, kChromaBits = 5;
  /// Stands for "several labels" in `blocks` and `chroma`.
  static constexpr Label kMixed = 255;

  /// The cell that contains this colour.
  static constexpr std::size_t index(std::uint8_t a, std::uint8_t b, std::uint8_t c, int bits = kBits) {
    return static_cast<std::size_t>(a >> (8 - bits)) << (2 * bits) |
           static_cast<std::size_t>(b >> (8 - bits)) << bits | static_cast<std::size_t>(c >> (8 - bits));
  }
  /// The label of this colour.
  Label of(std::uint8_t a, std::uint8_t b, std::uint8_t c) const { return labels[index(a, b, c, bits)]; }

  int bits = kBits;           // per channel: 7 or 8
  std::vector<Label> labels;  // ordered by index()
  /// The label that all colours of a block of 4x4x4 levels (2^(8-kBlockBits) per channel) share, or kMixed;
  /// ordered like `labels`.
  std::vector<Label> blocks;
  /// The label that all colours of one chroma share, or kMixed, at chroma_a << 5 | chroma_b. In YUV, chroma_a
  /// and chroma_b are the upper five bits of U and V. In RGB, they are the upper five bits of (B + 255 - G +
  /// 1) / 2 and (R + 255 - G + 1) / 2, which byte-wise instructions can compute; a cell of the RGB table may
  /// belong to several chromas.
  std::array<Label, std::size_t{1} << (2 * kChromaBits)> chroma;
};

/// A colour table prepared for lookup: 7 bits per channel (2 MiB), or 8 (16 MiB) for a table with 8 bits;
/// coarser tables are expanded. It is defined over YUV; an RGB table is derived from it once, so that RGB and
/// Bayer pixels need no conversion.
class Lut {
 public:
  /// A label's mean chromaticity and the spread of its colours about it.
  struct Chromaticity {
    std::array<double, 3> mean{1.0 / 3, 1.0 / 3, 1.0 / 3};
    double spread = 0;
  };
  static constexpr int kBits = LutTable::kBits;
  static constexpr std::size_t kEntries = LutTable::kEntries;

  /// All clear.
  Lut();
  /// Throws SettingsError if the number of labels does not match the bits, or if bits or a label are not
  /// allowed.
  explicit Lut(ColorTable table);
  /// `yuv` has kEntries labels, ordered by index_yuv().
  explicit Lut(std::vector<Label> yuv);

  /// Bit-identical to a Lut of color_table() with these changes, but a hundred times faster for a few hundred
  /// cells. `changed` refers to cells of color_table(); only its `after` labels count. Throws SettingsError
  /// for cells or labels that do not exist.
  Lut with_changes(std::span<const CellRun> changed) const { return with_changes(changed, prints_); }
  /// The same with other prints.
  Lut with_changes(std::span<const CellRun> changed, const Prints& prints) const;

  /// The cell of yuv() that contains this colour.
  static constexpr std::size_t index_yuv(std::uint8_t y, std::uint8_t u, std::uint8_t v) {
    return LutTable::index(u, v, y);
  }

  /// The label of a YUV colour.
  Label of_yuv(std::uint8_t y, std::uint8_t u, std::uint8_t v) const { return yuv_.of(u, v, y); }
  /// The label of an RGB colour.
  Label of_rgb(std::uint8_t r, std::uint8_t g, std::uint8_t b) const { return rgb_.of(r, b, g); }

  /// The table from which this Lut was made.
  ColorTable color_table() const;
  /// Bits per channel of color_table().
  int color_bits() const { return color_bits_; }

  /// Mean chromaticity: the shares of red, green and blue (with sum 1), which do not change with the light.
  /// From the label's prints if the table has them, else from its cells. Equal shares for a label without
  /// colours.
  const std::array<double, 3>& chromaticity_mean(Label label) const { return chromaticities_[label].mean; }
  /// Print colours of color_table().
  const Prints& prints() const { return prints_; }
  /// Root mean square distance of the label's colours from chromaticity_mean().
  double chromaticity_spread(Label label) const { return chromaticities_[label].spread; }

  /// The table over YUV: a = U, b = V, c = Y.
  const LutTable& yuv() const { return yuv_; }
  /// The table over RGB: a = R, b = B, c = G.
  const LutTable& rgb() const { return rgb_; }

  /// Unique for every table made in this process: shows whether data derived from a table is still valid.
  std::uint64_t id() const { return id_; }
  /// All members, including the id, for a copy in another process (pipeline/part_codec.h).
  template <class Self>
  static auto stored(Self& self) {
    return std::tie(self.color_bits_, self.yuv_, self.rgb_, self.prints_, self.chromaticity_sums_,
                    self.chromaticities_, self.id_);
  }

 private:
  /// Sums over a label's colours, so that its chromaticity can follow changed cells. Whole numbers, so that
  /// the order of adding does not matter.
  struct ChromaticitySums {
    std::array<std::int64_t, 3> color{};
    /// Squared lengths of the chromaticities, weighted by brightness, times kSquareUnit.
    std::int64_t squares = 0;

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

/// A colour class defined by hue and saturation instead of single table cells, so that it is valid for a
/// range of light. Hue: angle of (U-128, V-128), counter-clockwise from +U. Saturation: length of (U-128,
/// V-128) divided by the luma.
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

/// Source of a camera's table: a table that the service has saved, a `.lut` file, or colour classes, where
/// later classes have priority.
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
        list("classes", &ColorSettings::classes, "colour classes; later classes have priority"),
        number("bits", &ColorSettings::bits, ColorTable::kMinBits, ColorTable::kMaxBits, "",
               "bits per channel of the table: 5 to 7 are equally fast, 8 is slower"),
    };
  }
};

/// Throws SettingsError, its message starting with `path`, for an unknown label, an unreadable file, or a
/// file of the wrong size or format.
std::shared_ptr<const Lut> make_lut(const ColorSettings& colors, const std::string& path,
                                    const LabelSet& labels = LabelSet::built_in());
/// The table of make_lut(), not yet prepared for lookup.
ColorTable make_color_table(const ColorSettings& colors, const std::string& path,
                            const LabelSet& labels = LabelSet::built_in());

/// `lut` itself if it has this number of bits, else a resampled copy.
std::shared_ptr<const Lut> with_bits(std::shared_ptr<const Lut> lut, int bits);

/// Reads a `.lut` file, see lut_codec.h.
std::shared_ptr<const Lut> read_lut(const std::string& file, const std::string& path,
                                    const LabelSet& labels = LabelSet::built_in());
std::vector<std::uint8_t> lut_file_bytes(const Lut& lut, const LabelSet& labels = LabelSet::built_in());

}  // namespace sslv
