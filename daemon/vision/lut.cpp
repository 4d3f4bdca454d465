// SPDX-License-Identifier: Apache-2.0
#include "vision/lut.h"

#include "base/error.h"
#include "vision/lut_codec.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <numbers>
#include <tuple>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

using ChromaMasks = std::array<std::uint32_t, std::tuple_size_v<decltype(LutTable::chroma)>>;
using Cells = std::array<int, 2>;  // first and last cell of a channel

constexpr int kBlockSide = 1 << LutTable::kBlockBits, kChromaSide = 1 << LutTable::kChromaBits;
static_assert(label::kMaxCount <= 32);  // a mask has a bit for each label

/// Coarser tables are expanded to 7 bits.
constexpr int kernel_bits(int color_bits) {
  return std::max(color_bits, LutTable::kBits);
}

constexpr int first_level(int cell, int bits) {
  return cell << (8 - bits);
}
constexpr int last_level(int cell, int bits) {
  return first_level(cell + 1, bits) - 1;
}
/// The middle of a table cell's 8-bit range, rounded up.
constexpr std::uint8_t middle(int cell, int bits) {
  return static_cast<std::uint8_t>((first_level(cell, bits) + first_level(cell + 1, bits)) / 2);
}

constexpr std::size_t place(int a, int b, int c, int side) {
  return static_cast<std::size_t>((a * side + b) * side + c);
}

/// The label in the mask; kMixed if there are several, clear if there is none.
Label label_of(std::uint32_t mask) {
  if (mask == 0) return label::kClear;
  return std::has_single_bit(mask) ? static_cast<Label>(std::countr_zero(mask)) : LutTable::kMixed;
}

bool in_hue(const ColorClass& color, double u, double v) {
  double hue = std::atan2(v, u) * 180 / std::numbers::pi;
  while (hue < color.hue_deg[0]) hue += 360;
  return hue <= color.hue_deg[1];
}

/// Checks all but the hue.
bool in_class(const ColorClass& color, int y, double chroma) {
  if (y < color.luma[0] || y > color.luma[1]) return false;
  const double saturation = 100 * chroma / std::max(1, y);
  return saturation >= color.saturation_pct[0] && saturation <= color.saturation_pct[1];
}

ColorTable read_table(const std::string& file, const std::string& path, const LabelSet& labels) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw SettingsError(fmt::format("{}: cannot read \"{}\": {}", path, file, std::strerror(errno)));
  const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(in), {}};
  return decode_lut(bytes, fmt::format("{}: \"{}\"", path, file), labels);
}

// ---- the table over RGB

/// Fills each cell of `rgb` with the label that `yuv` has for the cell's middle.
template <int kBits>
void fill_rgb_lut(const LutTable& yuv, LutTable& rgb) {
  constexpr int kSide = 1 << kBits;
  rgb.labels.resize(yuv.labels.size());
  std::array<std::uint32_t, kSide> cells;
  for (int r = 0; r < kSide; ++r) {
    for (int b = 0; b < kSide; ++b) {
      for (int g = 0; g < kSide; ++g) {
        const Yuv c = to_yuv({middle(r, kBits), middle(g, kBits), middle(b, kBits)});
        cells[static_cast<std::size_t>(g)] =
            static_cast<std::uint32_t>(LutTable::index(c.u, c.v, c.y, kBits));
      }
      Label* row = rgb.labels.data() + place(r, b, 0, kSide);
      for (std::size_t g = 0; g < kSide; ++g) row[g] = yuv.labels[cells[g]];
    }
  }
}

/// Calls `call`(r, g, b) for every cell of an RGB table whose middle lies in the YUV cell (y, u, v).
template <class Call>
void for_rgb_cells(int y, int u, int v, int bits, const Call& call) {
  const int side = 1 << bits;
  // Rounding shifts values by up to half a level; 256 is stored as 255. The inverse is accurate to a
  // hundredth of a level.
  const auto range = [&](int cell, int offset) {
    const int last = last_level(cell, bits);
    return std::array{first_level(cell, bits) - offset - 0.6, last - offset + (last == 255 ? 1.6 : 0.6)};
  };
  const auto [y_low, y_high] = range(y, 0);
  const auto [u_low, u_high] = range(u, 128);
  const auto [v_low, v_high] = range(v, 128);
  const auto cells = [&](double low, double high) {
    return Cells{std::clamp(static_cast<int>(std::floor(low)), 0, 255) >> (8 - bits),
                 std::clamp(static_cast<int>(std::ceil(high)), 0, 255) >> (8 - bits)};
  };
  const Cells red = cells(y_low + 1.402 * v_low, y_high + 1.402 * v_high);
  const Cells blue = cells(y_low + 1.772 * u_low, y_high + 1.772 * u_high);
  const Cells green =
      cells(y_low - 0.34414 * u_high - 0.71414 * v_high, y_high - 0.34414 * u_low - 0.71414 * v_low);
  const std::size_t here = place(u, v, y, side);
  for (int r = red[0]; r <= red[1]; ++r) {
    for (int b = blue[0]; b <= blue[1]; ++b) {
      for (int g = green[0]; g <= green[1]; ++g) {
        const Yuv c = to_yuv({middle(r, bits), middle(g, bits), middle(b, bits)});
        if (LutTable::index(c.u, c.v, c.y, bits) == here) call(r, g, b);
      }
    }
  }
}

// ---- blocks

/// The common label of all cells of block (a, b, c), or kMixed.
Label block_label(const LutTable& table, int a, int b, int c) {
  const int side = 1 << table.bits, cells = side / kBlockSide;
  const Label first = table.labels[place(a * cells, b * cells, c * cells, side)];
  for (int i = 0; i < cells; ++i) {
    for (int j = 0; j < cells; ++j) {
      const Label* row = table.labels.data() + place(a * cells + i, b * cells + j, c * cells, side);
      if (std::any_of(row, row + cells, [first](Label label) { return label != first; }))
        return LutTable::kMixed;
    }
  }
  return first;
}

template <int kBits>
void summarise_blocks(LutTable& table) {
  constexpr int kSide = 1 << kBits, kCells = kSide / kBlockSide;
  table.blocks.resize(std::size_t{1} << (3 * LutTable::kBlockBits));
  Label* out = table.blocks.data();
  for (int a = 0; a < kBlockSide; ++a) {
    for (int b = 0; b < kBlockSide; ++b) {
      std::array<Label, kSide> low, high;
      low.fill(255);
      high.fill(0);
      for (int i = 0; i < kCells * kCells; ++i) {
        const Label* row =
            table.labels.data() + place(a * kCells + i / kCells, b * kCells + i % kCells, 0, kSide);
        for (std::size_t c = 0; c < kSide; ++c) {
          low[c] = std::min(low[c], row[c]);
          high[c] = std::max(high[c], row[c]);
        }
      }
      for (std::size_t c = 0; c < kSide; c += kCells) {
        Label lowest = low[c], highest = high[c];
        for (std::size_t i = 1; i < kCells; ++i) {
          lowest = std::min(lowest, low[c + i]);
          highest = std::max(highest, high[c + i]);
        }
        *out++ = lowest == highest ? lowest : LutTable::kMixed;
      }
    }
  }
}

// ---- chromas

/// The common label of the YUV chroma (a, b), or kMixed.
Label yuv_chroma_label(const LutTable& table, int a, int b) {
  constexpr int kBlocks = kBlockSide / kChromaSide;
  const Label first = table.blocks[place(a * kBlocks, b * kBlocks, 0, kBlockSide)];
  for (int i = 0; i < kBlocks; ++i) {
    for (int j = 0; j < kBlocks; ++j) {
      const Label* row = table.blocks.data() + place(a * kBlocks + i, b * kBlocks + j, 0, kBlockSide);
      if (std::any_of(row, row + kBlockSide, [first](Label label) { return label != first; }))
        return LutTable::kMixed;
    }
  }
  return first;
}

/// First and last RGB chroma, the upper bits of (B + 255 - G + 1) / 2 or (R + 255 - G + 1) / 2, for a range
/// of levels of blue or red (`low`, `high`) and of green.
Cells reached_chromas(int low, int high, int green_low, int green_high) {
  return {(low + 256 - green_high) / 2 * kChromaSide / 256, (high + 256 - green_low) / 2 * kChromaSide / 256};
}

void summarise_rgb_chroma(LutTable& table) {
  const int side = 1 << table.bits, cells = side / kBlockSide, bits = table.bits;
  ChromaMasks masks{};
  const auto add = [&](const Cells& a, const Cells& b, Label label) {
    for (int i = a[0]; i <= a[1]; ++i) {
      for (int j = b[0]; j <= b[1]; ++j) masks[place(0, i, j, kChromaSide)] |= std::uint32_t{1} << label;
    }
  };
  const auto chromas = [&](int first, int last, int green) {
    return reached_chromas(first_level(first, bits), last_level(last, bits), first_level(green, bits),
                           last_level(green, bits));
  };
  for (int r = 0; r < kBlockSide; ++r) {
    for (int b = 0; b < kBlockSide; ++b) {
      for (int g = 0; g < side; ++g) {
        const int red = r * cells, blue = b * cells;
        const Label block = table.blocks[place(r, b, g / cells, kBlockSide)];
        if (block != LutTable::kMixed) {
          // For one level of green, blue and red are independent, so the block's cells reach all pairs of
          // these chromas.
          add(chromas(blue, blue + cells - 1, g), chromas(red, red + cells - 1, g), block);
          continue;
        }
        for (int i = 0; i < cells; ++i) {
          for (int j = 0; j < cells; ++j) {
            add(chromas(blue + j, blue + j, g), chromas(red + i, red + i, g),
                table.labels[place(red + i, blue + j, g, side)]);
          }
        }
      }
    }
  }
  std::transform(masks.begin(), masks.end(), table.chroma.begin(), label_of);
}

/// The label of the RGB chroma (a, b); same result as summarise_rgb_chroma().
Label rgb_chroma_label(const LutTable& table, int a, int b) {
  const int side = 1 << table.bits, bits = table.bits;
  // For each cell of blue (or red): the range of cells of green with which it reaches the chroma.
  const auto greens = [&](int chroma) {
    std::vector<Cells> out(static_cast<std::size_t>(side));
    for (int cell = 0; cell < side; ++cell) {
      // level + 256 - green must be one of the 16 values that give the chroma.
      const int low = first_level(cell, bits) + 256 - (16 * chroma + 15);
      const int high = last_level(cell, bits) + 256 - 16 * chroma;
      out[static_cast<std::size_t>(cell)] =
          high < 0 || low > 255 ? Cells{0, -1}
                                : Cells{std::max(low, 0) >> (8 - bits), std::min(high, 255) >> (8 - bits)};
    }
    return out;
  };
  const std::vector<Cells> of_blue = greens(a), of_red = greens(b);
  std::uint32_t mask = 0;
  for (int red = 0; red < side; ++red) {
    for (int blue = 0; blue < side; ++blue) {
      const Cells& r = of_red[static_cast<std::size_t>(red)];
      const Cells& s = of_blue[static_cast<std::size_t>(blue)];
      for (int g = std::max(r[0], s[0]); g <= std::min(r[1], s[1]); ++g) {
        mask |= std::uint32_t{1} << table.labels[place(red, blue, g, side)];
      }
      if (mask != 0 && !std::has_single_bit(mask)) return LutTable::kMixed;
    }
  }
  return label_of(mask);
}

// ---- chromaticities (shares of red, green and blue)

/// Scale of ChromaticitySums::squares.
constexpr std::int64_t kSquareUnit = 256;

/// Every fourth level of a channel is enough for a mean.
bool counts_for_chromaticity(int cell, int bits) {
  return middle(cell, bits) % 4 == 1;
}

/// A set of indices, each listed once.
class Places {
 public:
  explicit Places(std::size_t count) : seen_(count) {}
  void add(std::size_t place) {
    if (seen_[place]) return;
    seen_[place] = true;
    list_.push_back(place);
  }
  const std::vector<std::size_t>& list() const { return list_; }

 private:
  std::vector<bool> seen_;
  std::vector<std::size_t> list_;
};

/// Changed cells of a table.
class Changes {
 public:
  explicit Changes(LutTable& table) : table_(table), blocks_(table.blocks.size()) {}
  /// Sets a cell's label. Returns whether this changes it.
  bool set(int a, int b, int c, Label label) {
    Label& here = table_.labels[place(a, b, c, 1 << table_.bits)];
    if (here == label) return false;
    here = label;
    const int shift = table_.bits - LutTable::kBlockBits;
    blocks_.add(place(a >> shift, b >> shift, c >> shift, kBlockSide));
    return true;
  }
  void summarise_blocks() {
    for (const std::size_t block : blocks_.list()) {
      const auto i = static_cast<int>(block);
      table_.blocks[block] =
          block_label(table_, i / (kBlockSide * kBlockSide), i / kBlockSide % kBlockSide, i % kBlockSide);
    }
  }

 private:
  LutTable& table_;
  Places blocks_;
};

std::uint64_t next_id() {
  static std::atomic<std::uint64_t> made{0};
  return ++made;
}

ColorTable checked(ColorTable table) {
  if (table.bits < ColorTable::kMinBits || table.bits > ColorTable::kMaxBits) {
    throw SettingsError(fmt::format("a colour table has {} bits a channel; expected {} .. {}", table.bits,
                                    ColorTable::kMinBits, ColorTable::kMaxBits));
  }
  const std::size_t expected = std::size_t{1} << (3 * table.bits);
  if (table.labels.size() != expected) {
    throw SettingsError(
        fmt::format("a lookup table has {} labels; expected {}", table.labels.size(), expected));
  }
  Label highest = 0;
  for (const Label label : table.labels) highest = std::max(highest, label);
  if (highest >= label::kMaxCount) {
    throw SettingsError(
        fmt::format("a lookup table has a label {}; labels are 0 .. {}", highest, label::kMaxCount - 1));
  }
  return table;
}

/// The labels of the same table with more bits: each cell is repeated.
std::vector<Label> spread_out(const ColorTable& table, int bits) {
  const int shift = bits - table.bits, side = 1 << bits;
  std::vector<Label> out(std::size_t{1} << (3 * bits));
  for (int u = 0; u < side; ++u) {
    for (int v = 0; v < side; ++v) {
      const Label* from = table.labels.data() + place(u >> shift, v >> shift, 0, table.side());
      Label* to = out.data() + place(u, v, 0, side);
      for (int y = 0; y < side; ++y) to[y] = from[y >> shift];
    }
  }
  return out;
}

}  // namespace

ColorTable resampled(const ColorTable& table, int bits) {
  if (bits == table.bits) return table;
  ColorTable out(bits);
  out.prints = table.prints;
  if (bits > table.bits) {
    out.labels = spread_out(table, bits);
    return out;
  }
  std::vector<std::array<std::uint16_t, label::kMaxCount>> votes(out.labels.size());
  for (std::size_t cell = 0; cell < table.labels.size(); ++cell) {
    const Yuv color = table.color_of(cell);
    ++votes[out.index(color.y, color.u, color.v)][table.labels[cell] % label::kMaxCount];
  }
  for (std::size_t cell = 0; cell < votes.size(); ++cell) {
    const auto most = std::max_element(votes[cell].begin(), votes[cell].end());
    out.labels[cell] = static_cast<Label>(most - votes[cell].begin());
  }
  return out;
}

void Lut::ChromaticitySums::add(int r, int g, int b, int times) {
  const std::array<std::int64_t, 3> levels{r, g, b};
  std::int64_t squares_here = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    color[c] += times * levels[c];
    squares_here += levels[c] * levels[c];
  }
  // Bright colours count more, because the chromaticity of dark colours is uncertain.
  squares += times * (squares_here * kSquareUnit / (levels[0] + levels[1] + levels[2]));
}

Lut::Chromaticity Lut::ChromaticitySums::chromaticity() const {
  Chromaticity out;
  const auto weight = static_cast<double>(color[0] + color[1] + color[2]);
  if (weight <= 0) return out;
  double length2 = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    out.mean[c] = static_cast<double>(color[c]) / weight;
    length2 += out.mean[c] * out.mean[c];
  }
  out.spread = std::sqrt(
      std::max(0.0, static_cast<double>(squares) / static_cast<double>(kSquareUnit) / weight - length2));
  return out;
}

void Lut::finish_chromaticities() {
  for (std::size_t label = 0; label < chromaticities_.size(); ++label) {
    chromaticities_[label] = chromaticity_sums_[label].chromaticity();
    if (!prints_[label]) continue;
    for (std::size_t c = 0; c < 3; ++c)
      chromaticities_[label].mean[c] = prints_[label]->chromaticity[c] / PrintColor::kUnit;
    chromaticities_[label].spread = prints_[label]->spread / PrintColor::kUnit;
  }
  chromaticities_[label::kClear] = {};
}

Lut::Lut() : Lut(ColorTable()) {}

Lut::Lut(std::vector<Label> yuv) : Lut(ColorTable(kBits, std::move(yuv))) {}

Lut::Lut(ColorTable table) : color_bits_(table.bits), id_(next_id()) {
  table = checked(std::move(table));
  const int bits = kernel_bits(table.bits), side = 1 << bits;
  yuv_.bits = rgb_.bits = bits;
  prints_ = table.prints;
  yuv_.labels = bits == table.bits ? std::move(table.labels) : spread_out(table, bits);
  if (bits == 8) {
    fill_rgb_lut<8>(yuv_, rgb_);
    for (LutTable* each : {&yuv_, &rgb_}) summarise_blocks<8>(*each);
  } else {
    fill_rgb_lut<kBits>(yuv_, rgb_);
    for (LutTable* each : {&yuv_, &rgb_}) summarise_blocks<kBits>(*each);
  }
  for (int a = 0; a < kChromaSide; ++a) {
    for (int b = 0; b < kChromaSide; ++b) {
      yuv_.chroma[place(0, a, b, kChromaSide)] = yuv_chroma_label(yuv_, a, b);
    }
  }
  summarise_rgb_chroma(rgb_);
  const int step = 4 >> (8 - bits), first = bits == 8 ? 1 : 0;
  for (int r = first; r < side; r += step) {
    for (int b = first; b < side; b += step) {
      for (int g = first; g < side; g += step) {
        const Label label = rgb_.labels[place(r, b, g, side)];
        if (label != label::kClear)
          chromaticity_sums_[label].add(middle(r, bits), middle(g, bits), middle(b, bits), 1);
      }
    }
  }
  finish_chromaticities();
}

Lut Lut::with_changes(std::span<const CellRun> changed, const Prints& prints) const {
  const int bits = yuv_.bits, side = 1 << bits, shift = bits - color_bits_, color_side = 1 << color_bits_;
  std::size_t cells = 0;
  const std::size_t all = std::size_t{1} << (3 * color_bits_);
  for (const CellRun& run : changed) {
    if (run.begin > all || run.length > all - run.begin || run.after >= label::kMaxCount) {
      throw SettingsError(
          fmt::format("a change of {} cells starting at {} to label {} exceeds the table of {}", run.length,
                      run.begin, run.after, all));
    }
    cells += run.length;
  }
  // A changed cell costs as much as a hundred cells of a new table.
  if (cells << (3 * shift) > yuv_.labels.size() / 64) {
    ColorTable table = color_table();
    table.prints = prints;
    for (const CellRun& run : changed) std::fill_n(table.labels.begin() + run.begin, run.length, run.after);
    return Lut(std::move(table));
  }

  Lut out = *this;
  out.id_ = next_id();
  out.prints_ = prints;
  Changes yuv(out.yuv_), rgb(out.rgb_);
  Places yuv_chromas(out.yuv_.chroma.size()), rgb_chromas(out.rgb_.chroma.size());
  const auto set_rgb_cell = [&](int r, int g, int b, Label before, Label after) {
    if (!rgb.set(r, b, g, after)) return;
    const auto chromas = [&](int cell) {
      return reached_chromas(first_level(cell, bits), last_level(cell, bits), first_level(g, bits),
                             last_level(g, bits));
    };
    const Cells of_blue = chromas(b), of_red = chromas(r);
    for (int i = of_blue[0]; i <= of_blue[1]; ++i) {
      for (int j = of_red[0]; j <= of_red[1]; ++j) rgb_chromas.add(place(0, i, j, kChromaSide));
    }
    if (!counts_for_chromaticity(r, bits) || !counts_for_chromaticity(g, bits) ||
        !counts_for_chromaticity(b, bits))
      return;
    for (const auto& [label, times] : {std::pair{before, -1}, std::pair{after, 1}}) {
      if (label != label::kClear)
        out.chromaticity_sums_[label].add(middle(r, bits), middle(g, bits), middle(b, bits), times);
    }
  };
  const auto set_cell = [&](int y, int u, int v, Label label) {
    const Label before = out.yuv_.labels[place(u, v, y, side)];
    if (!yuv.set(u, v, y, label)) return;
    yuv_chromas.add(
        place(0, u >> (bits - LutTable::kChromaBits), v >> (bits - LutTable::kChromaBits), kChromaSide));
    for_rgb_cells(y, u, v, bits, [&](int r, int g, int b) { set_rgb_cell(r, g, b, before, label); });
  };
  const int copies = 1 << shift;  // copies of a cell, per channel
  for (const CellRun& run : changed) {
    for (std::uint32_t i = 0; i < run.length; ++i) {
      const auto cell = static_cast<int>(run.begin + i);
      const int y = cell % color_side, v = cell / color_side % color_side,
                u = cell / (color_side * color_side);
      for (int n = 0; n < copies * copies * copies; ++n) {
        set_cell(y * copies + n % copies, u * copies + n / copies / copies, v * copies + n / copies % copies,
                 run.after);
      }
    }
  }
  yuv.summarise_blocks();
  rgb.summarise_blocks();
  for (const std::size_t chroma : yuv_chromas.list()) {
    const auto i = static_cast<int>(chroma);
    out.yuv_.chroma[chroma] = yuv_chroma_label(out.yuv_, i / kChromaSide, i % kChromaSide);
  }
  for (const std::size_t chroma : rgb_chromas.list()) {
    const auto i = static_cast<int>(chroma);
    out.rgb_.chroma[chroma] = rgb_chroma_label(out.rgb_, i / kChromaSide, i % kChromaSide);
  }
  out.finish_chromaticities();
  return out;
}

ColorTable Lut::color_table() const {
  ColorTable out(color_bits_);
  out.prints = prints_;
  if (color_bits_ == yuv_.bits) {
    out.labels = yuv_.labels;
    return out;
  }
  const int shift = yuv_.bits - color_bits_, side = out.side();
  for (int u = 0; u < side; ++u) {
    for (int v = 0; v < side; ++v) {
      const Label* from = yuv_.labels.data() + place(u << shift, v << shift, 0, 1 << yuv_.bits);
      Label* to = out.labels.data() + place(u, v, 0, side);
      for (int y = 0; y < side; ++y) to[y] = from[y << shift];
    }
  }
  return out;
}

ColorTable make_color_table(const ColorSettings& colors, const std::string& path, const LabelSet& labels) {
  for (std::size_t i = 0; i < colors.classes.size(); ++i) {
    if (!labels.find(colors.classes[i].label)) {
      throw SettingsError(fmt::format("{}/classes/{}/label: \"{}\" is not allowed; expected one of {}", path,
                                      i, colors.classes[i].label, labels.names()));
    }
  }
  if (!colors.lut_file.empty())
    return resampled(read_table(colors.lut_file, path + "/lut_file", labels), colors.bits);

  ColorTable table(colors.bits);
  for (const ColorClass& color : colors.classes) {
    const Label label = *labels.find(color.label);
    for (int u = 0; u < table.side(); ++u) {
      for (int v = 0; v < table.side(); ++v) {
        const double du = middle(u, table.bits) - 128.0, dv = middle(v, table.bits) - 128.0;
        if (!in_hue(color, du, dv)) continue;
        const double chroma = std::hypot(du, dv);
        Label* row = table.labels.data() + place(u, v, 0, table.side());
        for (int y = 0; y < table.side(); ++y) {
          if (in_class(color, middle(y, table.bits), chroma)) row[y] = label;
        }
      }
    }
  }
  return table;
}

std::shared_ptr<const Lut> make_lut(const ColorSettings& colors, const std::string& path,
                                    const LabelSet& labels) {
  return std::make_shared<const Lut>(make_color_table(colors, path, labels));
}

std::shared_ptr<const Lut> with_bits(std::shared_ptr<const Lut> lut, int bits) {
  if (lut->color_bits() == bits) return lut;
  return std::make_shared<const Lut>(resampled(lut->color_table(), bits));
}

std::shared_ptr<const Lut> read_lut(const std::string& file, const std::string& path,
                                    const LabelSet& labels) {
  return std::make_shared<const Lut>(read_table(file, path, labels));
}

std::vector<std::uint8_t> lut_file_bytes(const Lut& lut, const LabelSet& labels) {
  return encode_lut(lut.color_table(), labels);
}

}  // namespace sslv
