// SPDX-License-Identifier: Apache-2.0
// Highway includes this file once for each instruction set.
#include "vision/segment_kernel.h"

#include "vision/rough_yuv.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <iterator>
#include <type_traits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/segment_kernel.cpp"
#define HWY_WANT_AVX3_DL
// SSSE3: IfNegativeThenElse is wrong for bytes there (Highway 1.0.3), and CPUs with no later instructions are
// from 2006.
// SVE: its vectors have no size at compile time; CPUs that have it have NEON too.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)
#include <hwy/foreach_target.h>
// After foreach_target.h:
#include <hwy/cache_control.h>
#include <hwy/highway.h>

// Highway's own style of names.
// NOLINTBEGIN(readability-identifier-naming)
HWY_BEFORE_NAMESPACE();
namespace sslv {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Cells processed together: one bit each in a 64-bit word.
constexpr int kBlock = 64;
/// Blocks processed together, also one bit each.
constexpr int kGroup = 64;
static_assert(kBlock == FloodCut::kBlockCells && kGroup == 64);
/// Prefetch distance in bytes.
constexpr std::size_t kPrefetchAhead = 6 * 1024;
constexpr std::size_t kCacheLine = 64;

// Vectors of up to 64 bytes; a block is a whole number of vectors.
using Bytes = hn::CappedTag<std::uint8_t, kBlock>;
using Vector = hn::Vec<Bytes>;
constexpr int kLanes = static_cast<int>(hn::MaxLanes(Bytes()));

template <class D, class Mask>
HWY_INLINE std::uint64_t bits_of(D d, Mask mask) {
  std::uint64_t bits = 0;
  hn::StoreMaskBits(d, mask, reinterpret_cast<std::uint8_t*>(&bits));
  return bits;
}

/// 64 bits of a row, from index `first` on. One word after the last must be readable.
HWY_INLINE std::uint64_t bits_from(const std::uint64_t* words, int first) {
  const std::uint64_t *word = words + first / 64, low = word[0] >> first % 64;
  return first % 64 == 0 ? low : low | word[1] << (64 - first % 64);
}

/// Writes the runs of a row.
struct RunWriter {
  Run* runs;
  std::size_t begun = 0, ended = 0;
  std::uint16_t y = 0;
  Label current = label::kClear;
  std::uint32_t next = kNone;  // position and label of the cell that would extend the last run

  static constexpr std::uint32_t kNone = 0xFFFF'FFFF;

  /// From x on, cells have this label.
  HWY_INLINE void set(int x, Label label) {
    if (label == current) return;
    if (current != label::kClear) runs[ended++].x_end = static_cast<std::uint16_t>(x);
    if (label != label::kClear) runs[begun++] = {y, static_cast<std::uint16_t>(x), 0, label};
    current = label;
  }

  /// Adds labelled cells, from left to right; the cells between them are clear. There is no branch on whether
  /// a cell extends the previous run, because in a noisy image CPUs cannot predict it.
  HWY_INLINE void add_cells(const std::uint16_t* places, const Label* labels, std::size_t count) {
    std::size_t end = begun;
    std::uint32_t expected = next;
    std::uint16_t begin = end == 0 ? 0 : runs[end - 1].x_begin;
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint16_t x = places[i];
      const std::uint32_t cell = std::uint32_t{x} << 8 | labels[i];
      const bool is_new = cell != expected;
      begin = is_new ? x : begin;
      end += is_new ? 1 : 0;
      runs[end - 1] = {y, begin, static_cast<std::uint16_t>(x + 1), labels[i]};
      expected = cell + (1U << 8);
    }
    next = expected;
    begun = ended = end;
  }
  /// Adds neighbouring cells of one label.
  HWY_INLINE void add_cells(int x_begin, int x_end, Label label) {
    const auto key = [label](int x) { return static_cast<std::uint32_t>(x) << 8 | label; };
    if (key(x_begin) == next) {
      runs[begun - 1].x_end = static_cast<std::uint16_t>(x_end);
    } else {
      runs[begun++] = {y, static_cast<std::uint16_t>(x_begin), static_cast<std::uint16_t>(x_end), label};
    }
    next = key(x_end);
    ended = begun;
  }
  HWY_INLINE void end_cells() { next = kNone; }
};

// Pixel formats. Each format defines the memory layout of a cell (kBytes in each of kRows rows of the image)
// and its colour. Formats with samples of U, V and Y define the channel of each byte (kChannels, repeating)
// and the bytes that share a colour (Lane); the other formats load red, green and blue.

enum Channel : std::size_t { kU, kV, kY };

/// Channels as in LutTable.
struct Color {
  std::uint8_t a, b, c;
};

/// A table's labels. The bits per channel are a run-time value, because an additional shift costs less than a
/// second copy of the kernel.
struct Cells {
  Cells(const LutTable& table, const Background& background)
      : labels(table.labels.data()), background_blocks(background.blocks.data()), bits(table.bits) {}
  HWY_INLINE const Label* place(Color color) const {
    return labels + LutTable::index(color.a, color.b, color.c, bits);
  }
  /// Whether the whole block of the colour has the background's label.
  HWY_INLINE bool in_background(Color color) const {
    constexpr int kBits = LutTable::kBlockBits, kShift = 8 - kBits;
    const std::size_t row = static_cast<std::size_t>(color.a >> kShift) << kBits | color.b >> kShift;
    return (background_blocks[row] >> (color.c >> kShift) & 1) != 0;
  }
  const Label* labels;
  const std::uint64_t* background_blocks;
  int bits;
};

template <int kLuma>
struct Yuv422 {
  static constexpr int kBytes = 2, kRows = 1;
  static constexpr bool kIsRgb = false;
  static constexpr int kUAt = kLuma == 1 ? 0 : 1, kVAt = kUAt + 2;
  static constexpr Channel kChannels[4] = {kLuma == 0 ? kY : kU, kLuma == 0 ? kU : kY, kLuma == 0 ? kY : kV,
                                           kLuma == 0 ? kV : kY};
  using Lane = std::uint32_t;
  using Cell = std::uint16_t;
  static const LutTable& table(const Lut& lut) { return lut.yuv(); }

  static HWY_INLINE Color color(const std::uint8_t* row, std::ptrdiff_t, std::size_t x) {
    const std::uint8_t* pair = row + x / 2 * 4;
    return {pair[kUAt], pair[kVAt], pair[kLuma + x % 2 * 2]};
  }
};

/// Grey: the colours (y, 128, 128).
struct Mono {
  static constexpr int kBytes = 1, kRows = 1;
  static constexpr bool kIsRgb = false;
  static constexpr Channel kChannels[1] = {kY};
  using Lane = std::uint8_t;
  using Cell = std::uint8_t;
  static const LutTable& table(const Lut& lut) { return lut.yuv(); }

  static HWY_INLINE Color color(const std::uint8_t* row, std::ptrdiff_t, std::size_t x) {
    return {128, 128, row[x]};
  }
};

template <int kRed>
struct Rgb24 {
  static constexpr int kBytes = 3, kRows = 1;
  static constexpr bool kIsRgb = true;
  static const LutTable& table(const Lut& lut) { return lut.rgb(); }

  static HWY_INLINE Color color(const std::uint8_t* row, std::ptrdiff_t, std::size_t x) {
    const std::uint8_t* pixel = row + x * 3;
    return {pixel[kRed], pixel[2 - kRed], pixel[1]};
  }

#if HWY_TARGET != HWY_SCALAR
  static HWY_INLINE void load(const std::uint8_t* block, std::ptrdiff_t, int i, Vector& red, Vector& green,
                              Vector& blue) {
    Vector first, last;
    hn::LoadInterleaved3(Bytes(), block + i * 3, first, green, last);
    red = kRed == 0 ? first : last;
    blue = kRed == 0 ? last : first;
  }
#endif
};

/// kRed: position of red in the quad (0 1 / 2 3); blue is at the opposite corner.
template <int kRed>
struct Bayer {
  static constexpr int kBytes = 2, kRows = 2;
  static constexpr bool kIsRgb = true;
  static constexpr int kGreen1 = kRed == 0 || kRed == 3 ? 1 : 0, kGreen2 = 3 - kGreen1;
  static const LutTable& table(const Lut& lut) { return lut.rgb(); }

  static HWY_INLINE Color color(const std::uint8_t* row, std::ptrdiff_t stride, std::size_t x) {
    const std::uint8_t *upper = row + x * 2, *lower = upper + stride;
    const std::uint8_t quad[4] = {upper[0], upper[1], lower[0], lower[1]};
    const auto green = static_cast<std::uint8_t>((quad[kGreen1] + quad[kGreen2] + 1) / 2);
    return {quad[kRed], quad[3 - kRed], green};
  }

#if HWY_TARGET != HWY_SCALAR
  static HWY_INLINE void load(const std::uint8_t* block, std::ptrdiff_t stride, int i, Vector& red,
                              Vector& green, Vector& blue) {
    const Bytes d;
    const std::uint8_t *upper = block + i * 2, *lower = upper + stride;
    const Vector upper0 = hn::LoadU(d, upper), upper1 = hn::LoadU(d, upper + kLanes);
    const Vector lower0 = hn::LoadU(d, lower), lower1 = hn::LoadU(d, lower + kLanes);
    const Vector quad[4] = {hn::ConcatEven(d, upper1, upper0), hn::ConcatOdd(d, upper1, upper0),
                            hn::ConcatEven(d, lower1, lower0), hn::ConcatOdd(d, lower1, lower0)};
    red = quad[kRed];
    green = hn::AverageRound(quad[kGreen1], quad[kGreen2]);
    blue = quad[3 - kRed];
  }
#endif
};

#if HWY_TARGET != HWY_SCALAR
/// Each byte of the result is 0 if the byte of `in` lies in [low, low + extent].
HWY_INLINE Vector beyond(Vector in, Vector low, Vector extent) {
  return hn::SaturatedSub(hn::Sub(in, low), extent);
}

/// The background's boxes for YUV images, compared directly with the bytes in memory.
template <class Format>
class YuvBoxes {
 public:
  explicit YuvBoxes(const Background& background) : count_(background.boxes) {
    constexpr std::size_t kPeriod = std::size(Format::kChannels);
    static_assert(kLanes % kPeriod == 0);
    alignas(64) std::uint8_t low[kLanes], extent[kLanes];
    for (std::size_t k = 0; k < count_; ++k) {
      const ColorBox& box = background.box[k];
      for (std::size_t i = 0; i < kLanes; ++i) {
        const Channel channel = Format::kChannels[i % kPeriod];
        low[i] = box.low[channel];
        extent[i] = static_cast<std::uint8_t>(box.high[channel] - box.low[channel]);
      }
      low_[k] = hn::Load(Bytes(), low);
      extent_[k] = hn::Load(Bytes(), extent);
    }
  }

  /// Whether any cell of a block lies outside the first box.
  HWY_INLINE bool any_outside_first(const std::uint8_t* block) const {
    const Bytes d;
    Vector all = hn::Zero(d);
    HWY_UNROLL(8)
    for (int i = 0; i < kVectors; ++i)
      all = hn::Or(all, beyond(hn::LoadU(d, block + i * kLanes), low_[0], extent_[0]));
    return !hn::AllTrue(d, hn::Eq(all, hn::Zero(d)));
  }

  /// One bit for each cell of a block: whether it lies outside all boxes.
  HWY_INLINE std::uint64_t outside(const std::uint8_t* block, std::ptrdiff_t) const {
    if (count_ == 0) return ~std::uint64_t{0};
    const Bytes d;
    const hn::Repartition<typename Format::Lane, Bytes> lanes;
    const hn::Repartition<typename Format::Cell, Bytes> cells;
    Vector in[kVectors];
    hn::Vec<decltype(lanes)> least[kVectors];  // 0: in a box
    HWY_UNROLL(8)
    for (int i = 0; i < kVectors; ++i) {
      in[i] = hn::LoadU(d, block + i * kLanes);
      least[i] = hn::BitCast(lanes, beyond(in[i], low_[0], extent_[0]));
    }
    for (std::size_t k = 1; k < count_; ++k) {
      HWY_UNROLL(8)
      for (int i = 0; i < kVectors; ++i)
        least[i] = hn::Min(least[i], hn::BitCast(lanes, beyond(in[i], low_[k], extent_[k])));
    }
    std::uint64_t inside = 0;
    HWY_UNROLL(8)
    for (int i = 0; i < kVectors; ++i) {
      const auto zero = hn::VecFromMask(lanes, hn::Eq(least[i], hn::Zero(lanes)));
      inside |= bits_of(cells, hn::MaskFromVec(hn::BitCast(cells, zero))) << (i * (kLanes / Format::kBytes));
    }
    return ~inside;
  }

 private:
  static constexpr int kVectors = kBlock * Format::kBytes / kLanes;
  std::size_t count_;
  Vector low_[Background::kMaxBoxes], extent_[Background::kMaxBoxes];
};

/// The background's boxes for RGB images, compared with rough_yuv() and reduced by its error.
template <class Format>
class RgbBoxes {
 public:
  explicit RgbBoxes(const Background& background) {
    for (std::size_t k = 0; k < background.boxes; ++k) {
      bool is_empty = false;
      for (const Channel channel : {kU, kV, kY}) {
        int low = background.box[k].low[channel], high = background.box[k].high[channel];
        if (low > 0) low -= kRoughYuvError[channel][0];
        if (high < 255) high -= kRoughYuvError[channel][1];
        is_empty = is_empty || low > high;
        low_[count_][channel] = hn::Set(Bytes(), static_cast<std::uint8_t>(low));
        extent_[count_][channel] = hn::Set(Bytes(), static_cast<std::uint8_t>(high - low));
      }
      if (!is_empty) ++count_;
    }
  }

  HWY_INLINE std::uint64_t outside(const std::uint8_t* block, std::ptrdiff_t stride) const {
    const Bytes d;
    std::uint64_t inside = 0;
    HWY_UNROLL(4)
    for (int i = 0; i < kBlock; i += kLanes) {
      Vector red, green, blue;
      Format::load(block, stride, i, red, green, blue);
      const Yuv yuv = rough_yuv(red, green, blue);
      Vector least = hn::Set(d, 255);
      for (std::size_t k = 0; k < count_; ++k) {
        const Vector u = beyond(yuv.u, low_[k][kU], extent_[k][kU]);
        const Vector v = beyond(yuv.v, low_[k][kV], extent_[k][kV]);
        const Vector y = beyond(yuv.y, low_[k][kY], extent_[k][kY]);
        least = hn::Min(least, hn::Or(hn::Or(u, v), y));
      }
      inside |= bits_of(d, hn::Eq(least, hn::Zero(d))) << i;
    }
    return ~inside;
  }

 private:
  struct Yuv {
    Vector u, v, y;
  };
  /// sslv::rough_yuv() for vectors.
  static HWY_INLINE Yuv rough_yuv(Vector r, Vector g, Vector b) {
    const auto average = [](Vector a, Vector c) HWY_ATTR { return hn::AverageRound(a, c); };
    const Vector red_green = average(g, average(r, average(g, average(r, average(g, r)))));
    const Vector green_blue = average(g, average(g, average(b, average(g, average(b, g)))));
    return {average(b, hn::Not(red_green)), average(r, hn::Not(green_blue)),
            average(red_green, average(red_green, average(red_green, b)))};
  }

  std::size_t count_ = 0;
  Vector low_[Background::kMaxBoxes][3], extent_[Background::kMaxBoxes][3];
};
#endif

template <class Format>
class Search {
 public:
  explicit Search(const RunSearch& search)
      : search_(search),
        cells_(Format::table(*search.lut), *search.background),
        stride_(search.image.stride_bytes),
        width_(search.image.width / Format::kRows),
#if HWY_TARGET != HWY_SCALAR
        boxes_(*search.background),
#endif
        background_(search.background->label),
        out_{search.found->runs} {
  }

  BackgroundUse run() {
    for (int y = search_.row_begin; y < search_.row_end; ++y) {
      for (const sslv::Mask::Interval interval : search_.mask->row(y, Format::kRows)) {
        const int end = std::min<int>(interval.end, width_);
        if (interval.begin < end) search_stretch(y, interval.begin, end);
      }
      const bool ends_strip = (y + 1) % FloodCut::kBlockCells == 0 || y + 1 == search_.row_end;
      if (ends_strip || out_.begun - search_.found->noted >= FloodCut::kNoteAfter) note(ends_strip);
    }
    return use_;
  }

 private:
  HWY_INLINE const std::uint8_t* row(int y) const {
    return search_.image.row(y * Format::kRows);
  }

  /// Passes the runs found so far to the FloodCut, which drops the runs of labels that flood.
  void note(bool ends_strip) {
#if HWY_TARGET != HWY_SCALAR
    finish_stretches();
#endif
    search_.found->count = out_.begun;
    search_.flood_cut->note(*search_.found, ends_strip);
    out_.begun = out_.ended = search_.found->count;
  }

  /// Searches cells [begin, end) of a row.
  void search_stretch(int y, int begin, int end) {
#if HWY_TARGET != HWY_SCALAR
    if (width_ >= kBlock) {
      search_blocks(y, begin, end);
    } else  // NOLINT: the loop below is all that is left for SCALAR
#endif
    {
      out_.y = static_cast<std::uint16_t>(y);
      for (int x = begin; x < end; ++x)
        out_.set(x, *cells_.place(Format::color(row(y), stride_, static_cast<std::size_t>(x))));
      out_.set(end, label::kClear);
    }
  }

#if HWY_TARGET != HWY_SCALAR
  using Boxes = std::conditional_t<Format::kIsRgb, RgbBoxes<Format>, YuvBoxes<Format>>;

  /// Cells [begin, end) of a row whose candidates (cells outside all boxes) are listed, but not looked up
  /// yet.
  struct Stretch {
    int y, begin, end;
    std::size_t listed_end;  // end of its candidates in Pending::places
    bool goes_on;            // the next stretch continues this one
  };
  // Candidates of several rows are looked up together, so that the table's memory latency is paid only once.
  static constexpr std::size_t kMaxStretches = 16, kManyListed = 1024;
  // If a block has at least this many candidates, it is faster to look up all of its cells.
  static constexpr int kDense = 20;
  static_assert(2 * (kManyListed + kGroup * kBlock) + kMaxStretches <= kMaxPendingRuns);
  /// Stretches and the positions of their candidates, from left to right. The arrays are not cleared: the
  /// counts define the valid entries.
  struct Pending {
    Stretch stretches[kMaxStretches];
    std::size_t stretch_count = 0, listed = 0;
    std::uint16_t places[kManyListed + kGroup * kBlock + 4];
    Label labels[kManyListed + kGroup * kBlock];
  };

  void search_blocks(int y, int begin, int end) {
    const std::uint8_t* in = row(y);
    const int last = (end + kBlock - 1) / kBlock;
    const std::uint64_t* cut_whole = search_.flood_cut->cut_whole(y / FloodCut::kBlockCells);
    for (int group = begin / kBlock; group < last; group += kGroup) {
      // Each step processes all blocks before the next step begins: the CPU overlaps steps without branches.
      const int blocks = std::min(kGroup, last - group);
      const std::uint64_t odd = odd_blocks(in, group, blocks) & ~bits_from(cut_whole, group);
      std::uint64_t candidates[kGroup];
      std::uint64_t dense = 0;
      const std::uint64_t mixed = find_candidates(in, group, blocks, odd, begin, end, candidates, dense);
      use_.blocks += static_cast<std::size_t>(blocks);
      use_.odd_blocks += static_cast<std::size_t>(std::popcount(odd));
      std::uint64_t left = mixed;
      for (; dense != 0; dense &= dense - 1) {
        const int i = std::countr_zero(dense);
        const std::uint64_t before = (std::uint64_t{1} << i) - 1;
        list_candidates(group, left & before, candidates);
        left &= ~before & ~(std::uint64_t{1} << i);
        const int from = std::max((group + i) * kBlock, begin), to = std::min((group + i + 1) * kBlock, end);
        add_stretch({y, begin, from, pending_.listed, true});
        finish_stretches();
        write_block(y, from, to);
        begin = to;
      }
      list_candidates(group, left, candidates);
      if (pending_.listed < kManyListed && group + kGroup < last) continue;
      const int done = std::min((group + kGroup) * kBlock, end);
      add_stretch({y, begin, done, pending_.listed, done < end});
      begin = done;
      if (pending_.listed >= kManyListed || pending_.stretch_count == kMaxStretches) finish_stretches();
    }
  }

  HWY_INLINE void add_stretch(const Stretch& stretch) {
    pending_.stretches[pending_.stretch_count++] = stretch;
  }

  /// Looks up all of cells [begin, end) of a row, within one block, and writes their runs. The runs of all
  /// cells before `begin` must have been written.
  void write_block(int y, int begin, int end) {
    const Cells cells = cells_;
    const std::uint8_t* in = row(y);
    const std::ptrdiff_t stride = stride_;
    const int count = end - begin;
    alignas(64) Label labels[1 + kBlock];  // with one label before the block
    Label* label = labels + 1;
    for (int i = 0; i < count; ++i)
      label[i] = *cells.place(Format::color(in, stride, static_cast<std::size_t>(begin + i)));
    labels[0] = static_cast<Label>(~label[0]);
    std::fill(label + count, label + kBlock, label[count - 1]);
    const Bytes d;
    std::uint64_t begins = 0;
    for (int i = 0; i < kBlock; i += kLanes)
      begins |= bits_of(d, hn::Ne(hn::LoadU(d, label + i), hn::LoadU(d, labels + i))) << i;
    out_.y = static_cast<std::uint16_t>(y);
    while (begins != 0) {
      const int i = std::countr_zero(begins);
      begins &= begins - 1;
      if (background_ != label::kClear) {
        out_.set(begin + i, label[i]);
      } else if (label[i] != label::kClear) {
        out_.add_cells(begin + i, begin + (begins != 0 ? std::countr_zero(begins) : count), label[i]);
      }
    }
  }

  /// First cell that is read for a block. The block at the right edge is moved to the left, so that it lies
  /// wholly within the row.
  HWY_INLINE int place_of(int block) const {
    return std::min(block * kBlock, width_ - kBlock);
  }
  HWY_INLINE const std::uint8_t* bytes_of(const std::uint8_t* in, int block) const {
    return in + static_cast<std::ptrdiff_t>(place_of(block)) * Format::kBytes;
  }

  HWY_INLINE void prefetch(const std::uint8_t* block) const {
    HWY_UNROLL(2)
    for (int r = 0; r < Format::kRows; ++r) {
      // An image with two rows per cell is read in two streams.
      const std::uint8_t* ahead = block + (Format::kRows == 1 ? static_cast<std::ptrdiff_t>(kPrefetchAhead)
                                                              : (3 * Format::kRows + r) * stride_);
      HWY_UNROLL(3)
      for (int line = 0; line < kBlock * Format::kBytes; line += static_cast<int>(kCacheLine))
        hwy::Prefetch(ahead + line);
    }
  }

  /// One bit for each of `count` blocks from index `first` on: set if the block is not wholly in the first
  /// box. All bits are set if this test is not worthwhile.
  HWY_INLINE std::uint64_t odd_blocks(const std::uint8_t* in, int first, int count) const {
    const std::uint64_t all = ~std::uint64_t{0} >> (kGroup - count);
    if constexpr (Format::kIsRgb) {
      return all;
    } else {
      if (search_.background->boxes == 0 || !search_.background->first_alone) return all;
      const Boxes boxes = boxes_;  // a local copy stays in registers, unlike a member
      std::uint64_t odd = 0;
      for (int i = 0; i < count; ++i) {
        const std::uint8_t* block = bytes_of(in, first + i);
        prefetch(block);
        odd |= static_cast<std::uint64_t>(boxes.any_outside_first(block)) << i;
      }
      return odd;
    }
  }

  /// For each of the `odd` blocks from index `first` on, sets one bit in `candidates` for each of its cells
  /// in [begin, end) that is outside all boxes. Returns one bit for each block with such cells; `dense` gets
  /// one bit for each block with many such cells.
  HWY_INLINE std::uint64_t find_candidates(const std::uint8_t* in, int first, int count, std::uint64_t odd,
                                           int begin, int end, std::uint64_t* candidates,
                                           std::uint64_t& dense) const {
    std::uint64_t mixed = 0, many = 0;
    const auto find = [&](int i, const std::uint8_t* block) HWY_ATTR __attribute__((always_inline)) {
      prefetch(block);
      candidates[i] = boxes_.outside(block, stride_);
      mixed |= static_cast<std::uint64_t>(candidates[i] != 0) << i;
      many |= static_cast<std::uint64_t>(std::popcount(candidates[i]) >= kDense) << i;
    };
    if (std::popcount(odd) == count) {
      const int whole = std::min(count, width_ / kBlock - first);
      const std::uint8_t* block = bytes_of(in, first);
      for (int i = 0; i < whole; ++i, block += kBlock * Format::kBytes) find(i, block);
      if (whole < count) find(whole, bytes_of(in, first + whole));
    } else {
      for (std::uint64_t left = odd; left != 0; left &= left - 1) {
        const int i = std::countr_zero(left);
        find(i, bytes_of(in, first + i));
      }
    }
    // Only the first and last blocks have cells outside [begin, end). A block at the right edge also has
    // cells of the previous block.
    for (const int i : {0, count - 1}) {
      const int at = place_of(first + i);
      const int from = std::max((first + i) * kBlock, begin), to = std::min((first + i + 1) * kBlock, end);
      candidates[i] &= ~std::uint64_t{0} << (from - at) & ~std::uint64_t{0} >> (kBlock - (to - at));
      if (candidates[i] == 0) mixed &= ~(std::uint64_t{1} << i);
    }
    dense = many & mixed;
    return mixed;
  }

  /// Adds the places of the candidates of `mixed` blocks to the list.
  HWY_INLINE void list_candidates(int first, std::uint64_t mixed, const std::uint64_t* candidates) {
    constexpr int kAtOnce = 4;
    std::uint16_t* next = pending_.places + pending_.listed;
    for (; mixed != 0; mixed &= mixed - 1) {
      const int i = std::countr_zero(mixed), at = place_of(first + i);
      std::uint64_t left = candidates[i];
      const int count = std::popcount(left);
      // Surplus positions are overwritten.
      for (int done = 0; done < count; done += kAtOnce) {
        HWY_UNROLL(4)
        for (int k = 0; k < kAtOnce; ++k, left &= left - 1)
          next[done + k] = static_cast<std::uint16_t>(at + std::countr_zero(left));
      }
      next += count;
    }
    pending_.listed = static_cast<std::size_t>(next - pending_.places);
  }

  /// Looks up the candidates of all stretches and writes their runs.
  void finish_stretches() {
    drop_background();
    look_up();
    std::size_t begin = 0;
    for (std::size_t i = 0; i < pending_.stretch_count; ++i) {
      write_runs(pending_.stretches[i], begin);
      begin = pending_.stretches[i].listed_end;
    }
    pending_.stretch_count = pending_.listed = 0;
  }

  /// Drops candidates that the bitmap of background blocks identifies as background: this bitmap stays in the
  /// cache, unlike most of the table.
  HWY_INLINE void drop_background() {
    const Cells cells = cells_;
    std::size_t i = 0, kept = 0;
    for (std::size_t k = 0; k < pending_.stretch_count; ++k) {
      Stretch& stretch = pending_.stretches[k];
      const std::uint8_t* in = row(stretch.y);
      for (; i < stretch.listed_end; ++i) {
        const std::uint16_t x = pending_.places[i];
        pending_.places[kept] = x;
        kept += cells.in_background(Format::color(in, stride_, x)) ? 0 : 1;
      }
      stretch.listed_end = kept;
    }
    pending_.listed = kept;
  }

  /// Looks up the candidates' labels, and drops candidates with the background's label.
  HWY_INLINE void look_up() {
    const Cells cells = cells_;
    const Label background = background_;
    const std::ptrdiff_t stride = stride_;
    // Prefetches all needed entries of the table before the first entry is used.
    std::size_t i = 0;
    for (std::size_t k = 0; k < pending_.stretch_count; ++k) {
      const std::uint8_t* in = row(pending_.stretches[k].y);
      for (; i < pending_.stretches[k].listed_end; ++i)
        hwy::Prefetch(cells.place(Format::color(in, stride, pending_.places[i])));
    }
    std::size_t kept = 0;
    i = 0;
    for (std::size_t k = 0; k < pending_.stretch_count; ++k) {
      const std::uint8_t* in = row(pending_.stretches[k].y);
      for (const std::size_t end = pending_.stretches[k].listed_end; i < end; ++i) {
        const std::uint16_t x = pending_.places[i];
        const Label found = *cells.place(Format::color(in, stride, x));
        pending_.places[kept] = x;
        pending_.labels[kept] = found;
        kept += found != background ? 1 : 0;
      }
      pending_.stretches[k].listed_end = kept;
    }
    pending_.listed = kept;
  }

  HWY_INLINE void write_runs(const Stretch& stretch, std::size_t begin) {
    out_.y = static_cast<std::uint16_t>(stretch.y);
    if (background_ == label::kClear) {
      out_.add_cells(pending_.places + begin, pending_.labels + begin, stretch.listed_end - begin);
      if (!stretch.goes_on) out_.end_cells();
      return;
    }
    int done = stretch.begin;
    for (std::size_t i = begin; i < stretch.listed_end; ++i) {
      const int x = pending_.places[i];
      if (done < x) out_.set(done, background_);
      out_.set(x, pending_.labels[i]);
      done = x + 1;
    }
    if (done < stretch.end) out_.set(done, background_);
    if (!stretch.goes_on) out_.set(stretch.end, label::kClear);
  }
#endif

  const RunSearch& search_;
  const Cells cells_;
  const std::ptrdiff_t stride_;
  const int width_;
#if HWY_TARGET != HWY_SCALAR
  const Boxes boxes_;
  Pending pending_;
#endif
  const Label background_;
  RunWriter out_;
  BackgroundUse use_;
};

BackgroundUse SearchRuns(const RunSearch& search) {
  switch (search.image.format) {
    case PixelFormat::kUyvy: return Search<Yuv422<1>>(search).run();
    case PixelFormat::kYuyv: return Search<Yuv422<0>>(search).run();
    case PixelFormat::kRgb24: return Search<Rgb24<0>>(search).run();
    case PixelFormat::kBgr24: return Search<Rgb24<2>>(search).run();
    case PixelFormat::kMono8: return Search<Mono>(search).run();
    case PixelFormat::kBayerRg8: return Search<Bayer<0>>(search).run();
    case PixelFormat::kBayerGr8: return Search<Bayer<1>>(search).run();
    case PixelFormat::kBayerGb8: return Search<Bayer<2>>(search).run();
    case PixelFormat::kBayerBg8: return Search<Bayer<3>>(search).run();
  }
  return {};
}

void FindUniformBlocks(const LutTable& table, Label label, std::uint64_t* uniform) {
  constexpr int kRow = 1 << LutTable::kBlockBits;
  for (std::size_t i = 0; i < table.blocks.size() / kRow; ++i) {
    const Label* row = table.blocks.data() + i * kRow;
    std::uint64_t bits = 0;
#if HWY_TARGET == HWY_SCALAR
    for (int k = 0; k < kRow; ++k) bits |= static_cast<std::uint64_t>(row[k] == label) << k;
#else
    const Bytes d;
    for (int k = 0; k < kRow; k += kLanes)
      bits |= bits_of(d, hn::Eq(hn::LoadU(d, row + k), hn::Set(d, label))) << k;
#endif
    uniform[i] = bits;
  }
}

const char* Target() {
  return hwy::TargetName(HWY_TARGET);
}

}  // namespace HWY_NAMESPACE
}  // namespace sslv
HWY_AFTER_NAMESPACE();
// NOLINTEND(readability-identifier-naming)

#if HWY_ONCE
namespace sslv {

HWY_EXPORT(SearchRuns);
HWY_EXPORT(FindUniformBlocks);
HWY_EXPORT(Target);

BackgroundUse search_runs(const RunSearch& search) noexcept {
  return HWY_DYNAMIC_DISPATCH(SearchRuns)(search);
}

void find_uniform_blocks(const LutTable& table, Label label, std::uint64_t* uniform) noexcept {
  HWY_DYNAMIC_DISPATCH(FindUniformBlocks)(table, label, uniform);
}

std::string_view search_runs_target() {
  return HWY_DYNAMIC_DISPATCH(Target)();
}

}  // namespace sslv
#endif
