// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set: Highway includes this file again and again.
#include "vision/segment_kernel.h"

#include <algorithm>
#include <bit>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/segment_kernel.cpp"
#define HWY_WANT_AVX3_DL
// SSSE3: IfNegativeThenElse is wrong for bytes there (Highway 1.0.3), and CPUs that stop there are of 2006.
// SVE: its vectors have no size at compile time; CPUs that have it have NEON too.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)
#include <hwy/foreach_target.h>
// After foreach_target.h:
#include <hwy/cache_control.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sslv {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Cells looked at together: one bit each in a 64-bit word.
constexpr int kBlock = 64;
/// Blocks looked at together, also a bit each.
constexpr int kGroup = 64;
/// At most this many cells of a block are looked up one by one; with more, all of them are.
constexpr int kFewCandidates = 24;
/// Bytes ahead of which memory is asked for.
constexpr std::size_t kPrefetchAhead = 6 * 1024;
constexpr std::size_t kCacheLine = 64;

// Vectors of up to 64 bytes; all of a block is a multiple of them.
using Bytes = hn::CappedTag<std::uint8_t, kBlock>;
using Vector = hn::Vec<Bytes>;
constexpr int kLanes = static_cast<int>(hn::MaxLanes(Bytes()));

template <class D, class Mask>
HWY_INLINE std::uint64_t bits_of(D d, Mask mask) {
  std::uint64_t bits = 0;
  hn::StoreMaskBits(d, mask, reinterpret_cast<std::uint8_t*>(&bits));
  return bits;
}

/// Writes runs as labels change along a row.
struct RunWriter {
  Run* runs;
  std::size_t begun = 0, ended = 0;
  std::uint16_t y = 0;
  Label current = label::kClear;

  /// From x on, cells have this label.
  HWY_INLINE void set(int x, Label label) {
    if (label == current) return;
    if (current != label::kClear) end(x);
    if (label != label::kClear) begin(x, label);
    current = label;
  }
  HWY_INLINE void begin(int x, Label label) { runs[begun++] = {y, static_cast<std::uint16_t>(x), 0, label}; }
  HWY_INLINE void end(int x) { runs[ended++].x_end = static_cast<std::uint16_t>(x); }

  /// The labels of a block at x. There is room for one more label before them.
  HWY_INLINE void set_block(int x, Label* labels) {
    labels[-1] = current;
    std::uint64_t begins = 0, ends = 0;
    const Bytes d;
    const Vector clear = hn::Zero(d);
    HWY_UNROLL(4)
    for (int i = 0; i < kBlock; i += kLanes) {
      const Vector now = hn::LoadU(d, labels + i), before = hn::LoadU(d, labels + i - 1);
      const auto changes = hn::Ne(now, before);
      begins |= bits_of(d, hn::And(changes, hn::Ne(now, clear))) << i;
      ends |= bits_of(d, hn::And(changes, hn::Ne(before, clear))) << i;
    }
    for (; begins != 0; begins &= begins - 1) {
      const int i = std::countr_zero(begins);
      begin(x + i, labels[i]);
    }
    for (; ends != 0; ends &= ends - 1) end(x + std::countr_zero(ends));
    current = labels[kBlock - 1];
  }
};

#if HWY_TARGET != HWY_SCALAR
/// Background::odd_chroma, looked up by byte shuffles.
class ChromaTest {
 public:
  explicit ChromaTest(const Background& background) : bits_(background.odd_chroma) {}

  /// One bit for each lane: whether it has no label but the background's. Of `a` and `b`, the upper five bits
  /// count.
  template <class D, class V = hn::Vec<D>>
  HWY_INLINE std::uint64_t clear_bits(D d, V a, V b) const {
    // A shuffle has 16 places and gives 0 where the index' highest bit is set: one for a < 128, one above.
    const V low_index = hn::Or(shifted(d, a, 31), hn::And(a, hn::Set(d, 0x80)));
    const V high_index = hn::Xor(low_index, hn::Set(d, 0x90));
    const V plane0 = plane(d, 0, low_index, high_index), plane1 = plane(d, 1, low_index, high_index);
    const V plane2 = plane(d, 2, low_index, high_index), plane3 = plane(d, 3, low_index, high_index);
    const hn::RebindToSigned<D> signed_d;
    const auto by_highest_bit = [&](V bits, V yes, V no) HWY_ATTR {
      return hn::BitCast(d, hn::IfNegativeThenElse(hn::BitCast(signed_d, bits), hn::BitCast(signed_d, yes),
                                                   hn::BitCast(signed_d, no)));
    };
    const V b_twice = hn::Add(b, b);
    const V found =
        by_highest_bit(b, by_highest_bit(b_twice, plane3, plane2), by_highest_bit(b_twice, plane1, plane0));
    alignas(16) static constexpr std::uint8_t kBits[16] = {1, 2, 4, 8, 16, 32, 64, 128,
                                                           1, 2, 4, 8, 16, 32, 64, 128};
    const V wanted = hn::TableLookupBytes(hn::LoadDup128(d, kBits), shifted(d, b, 7));
    return bits_of(d, hn::Eq(hn::And(found, wanted), hn::Zero(d)));
  }

 private:
  /// v / 8, of which `mask` is kept. Bytes cannot be shifted, pairs of them can.
  template <class D, class V>
  HWY_INLINE V shifted(D d, V v, std::uint8_t mask) const {
    const hn::Repartition<std::uint16_t, D> wide;
    return hn::And(hn::BitCast(d, hn::ShiftRight<3>(hn::BitCast(wide, v))), hn::Set(d, mask));
  }
  template <class D, class V>
  HWY_INLINE V plane(D d, int i, V low_index, V high_index) const {
    return hn::Or(hn::TableLookupBytesOr0(hn::LoadDup128(d, bits_[i]), low_index),
                  hn::TableLookupBytesOr0(hn::LoadDup128(d, bits_[i] + 16), high_index));
  }
  const std::uint8_t (&bits_)[4][32];
};
#endif

/// Writes every bit twice: bit i to bits 2i and 2i + 1.
HWY_INLINE std::uint64_t doubled(std::uint64_t bits) {
  bits = (bits | bits << 16) & 0x0000FFFF0000FFFF;
  bits = (bits | bits << 8) & 0x00FF00FF00FF00FF;
  bits = (bits | bits << 4) & 0x0F0F0F0F0F0F0F0F;
  bits = (bits | bits << 2) & 0x3333333333333333;
  bits = (bits | bits << 1) & 0x5555555555555555;
  return bits * 3;
}

// Formats. Each says how a cell lies in memory (kBytes in each of kRows rows of the picture; kChannels: which
// channel of the table a byte belongs to, repeating), what its label is, and which cells of a block have a
// chroma that the background has not.

enum Channel { kA, kB, kC };

/// A table's labels. How many bits a channel has is known at run time only: one more shift costs less than the
/// kernel a second time.
struct Cells {
  explicit Cells(const LutTable& table) : labels(table.labels.data()), bits(table.bits) {}
  HWY_INLINE Label at(std::uint8_t a, std::uint8_t b, std::uint8_t c) const {
    return labels[LutTable::index(a, b, c, bits)];
  }
  const Label* labels;
  int bits;
};

HWY_INLINE std::uint8_t extent(const ColorBox& box, Channel channel) {
  return static_cast<std::uint8_t>(box.high[channel] - box.low[channel]);
}

template <int kLuma>
struct Yuv422 {
  static constexpr int kBytes = 2, kRows = 1, kPeriod = 4;
  static constexpr int kU = kLuma == 1 ? 0 : 1, kV = kU + 2;
  static constexpr Channel kChannels[kRows][kPeriod] = {
      {kLuma == 0 ? kC : kA, kLuma == 0 ? kA : kC, kLuma == 0 ? kC : kB, kLuma == 0 ? kB : kC}};
  static const LutTable& table(const Lut& lut) { return lut.yuv(); }

  static HWY_INLINE Label label(const Cells& cells, const std::uint8_t* block, std::ptrdiff_t, int i) {
    const std::uint8_t* pair = block + i / 2 * 4;
    return cells.at(pair[kU], pair[kV], pair[kLuma + i % 2 * 2]);
  }

#if HWY_TARGET != HWY_SCALAR
  static constexpr int kChromas = kBlock / 2;
  template <class D, class V>
  static HWY_INLINE void load_chroma(D d, const std::uint8_t* block, std::ptrdiff_t, int i, V& a, V& b) {
    constexpr int kPairs = static_cast<int>(hn::MaxLanes(d));
    const std::uint8_t* in = block + i * 4;
    const V v0 = hn::LoadU(d, in), v1 = hn::LoadU(d, in + kPairs);
    const V v2 = hn::LoadU(d, in + 2 * kPairs), v3 = hn::LoadU(d, in + 3 * kPairs);
    const V uv0 = kLuma == 1 ? hn::ConcatEven(d, v1, v0) : hn::ConcatOdd(d, v1, v0);
    const V uv1 = kLuma == 1 ? hn::ConcatEven(d, v3, v2) : hn::ConcatOdd(d, v3, v2);
    a = hn::ConcatEven(d, uv1, uv0);
    b = hn::ConcatOdd(d, uv1, uv0);
  }
#endif
};

#if HWY_TARGET != HWY_SCALAR
/// The chroma of LutTable::chroma for RGB.
template <class D, class V>
HWY_INLINE void rgb_chroma(D, V red, V green, V blue, V& a, V& b) {
  const V not_green = hn::Not(green);
  a = hn::AverageRound(blue, not_green);
  b = hn::AverageRound(red, not_green);
}
#endif

template <int kRed>
struct Rgb24 {
  static constexpr int kBytes = 3, kRows = 1, kPeriod = 3;
  static constexpr Channel kChannels[kRows][kPeriod] = {{kRed == 0 ? kA : kB, kC, kRed == 0 ? kB : kA}};
  static const LutTable& table(const Lut& lut) { return lut.rgb(); }

  static HWY_INLINE Label label(const Cells& cells, const std::uint8_t* block, std::ptrdiff_t, int i) {
    const std::uint8_t* pixel = block + i * 3;
    return cells.at(pixel[kRed], pixel[2 - kRed], pixel[1]);
  }

#if HWY_TARGET != HWY_SCALAR
  static constexpr int kChromas = kBlock;
  template <class D, class V>
  static HWY_INLINE void load_chroma(D d, const std::uint8_t* block, std::ptrdiff_t, int i, V& a, V& b) {
    V first, green, last;
    hn::LoadInterleaved3(d, block + i * 3, first, green, last);
    rgb_chroma(d, kRed == 0 ? first : last, green, kRed == 0 ? last : first, a, b);
  }
#endif
};

/// kRed: where red sits in the quad (0 1 / 2 3); blue sits opposite.
template <int kRed>
struct Bayer {
  static constexpr int kBytes = 2, kRows = 2, kPeriod = 2;
  static constexpr Channel channel(int place) { return place == kRed ? kA : place == 3 - kRed ? kB : kC; }
  static constexpr Channel kChannels[kRows][kPeriod] = {{channel(0), channel(1)}, {channel(2), channel(3)}};
  static constexpr int kGreen1 = kRed == 0 || kRed == 3 ? 1 : 0, kGreen2 = 3 - kGreen1;
  static const LutTable& table(const Lut& lut) { return lut.rgb(); }

  static HWY_INLINE Label label(const Cells& cells, const std::uint8_t* block, std::ptrdiff_t stride,
                                int i) {
    const std::uint8_t *upper = block + i * 2, *lower = upper + stride;
    const std::uint8_t quad[4] = {upper[0], upper[1], lower[0], lower[1]};
    const auto green = static_cast<std::uint8_t>((quad[kGreen1] + quad[kGreen2] + 1) / 2);
    return cells.at(quad[kRed], quad[3 - kRed], green);
  }

#if HWY_TARGET != HWY_SCALAR
  static constexpr int kChromas = kBlock;
  template <class D, class V>
  static HWY_INLINE void load_chroma(D d, const std::uint8_t* block, std::ptrdiff_t stride, int i, V& a,
                                     V& b) {
    constexpr int kQuads = static_cast<int>(hn::MaxLanes(d));
    const std::uint8_t *upper = block + i * 2, *lower = upper + stride;
    const V upper0 = hn::LoadU(d, upper), upper1 = hn::LoadU(d, upper + kQuads);
    const V lower0 = hn::LoadU(d, lower), lower1 = hn::LoadU(d, lower + kQuads);
    const V quad[4] = {hn::ConcatEven(d, upper1, upper0), hn::ConcatOdd(d, upper1, upper0),
                       hn::ConcatEven(d, lower1, lower0), hn::ConcatOdd(d, lower1, lower0)};
    rgb_chroma(d, quad[kRed], hn::AverageRound(quad[kGreen1], quad[kGreen2]), quad[3 - kRed], a, b);
  }
#endif
};

/// Grey: the colours (y, 128, 128).
struct Mono {
  static constexpr int kBytes = 1, kRows = 1, kPeriod = 1;
  static constexpr Channel kChannels[kRows][kPeriod] = {{kC}};
  static const LutTable& table(const Lut& lut) { return lut.yuv(); }

  static HWY_INLINE Label label(const Cells& cells, const std::uint8_t* block, std::ptrdiff_t, int i) {
    return cells.at(128, 128, block[i]);
  }

#if HWY_TARGET != HWY_SCALAR
  static constexpr int kChromas = kBlock;
  template <class D, class V>
  static HWY_INLINE void load_chroma(D d, const std::uint8_t* block, std::ptrdiff_t, int i, V& a, V& b) {
    a = hn::LoadU(d, block + i);
    b = hn::Zero(d);
  }
#endif
};

#if HWY_TARGET != HWY_SCALAR
/// Whether a block lies wholly in the background's box, byte by byte as it lies in memory.
template <class Format>
class BoxTest {
 public:
  explicit BoxTest(const ColorBox& box) {
    alignas(64) std::uint8_t low[kBlock], extents[kBlock];
    for (int row = 0; row < Format::kRows; ++row) {
      for (int k = 0; k < kVectors; ++k) {
        for (int i = 0; i < kLanes; ++i) {
          const Channel channel = Format::kChannels[row][(k * kLanes + i) % Format::kPeriod];
          low[i] = box.low[channel];
          extents[i] = extent(box, channel);
        }
        low_[row][k] = hn::Load(Bytes(), low);
        extent_[row][k] = hn::Load(Bytes(), extents);
      }
    }
  }

  HWY_INLINE bool outside(const std::uint8_t* block, std::ptrdiff_t stride) const {
    const Bytes d;
    Vector beyond = hn::Zero(d);
    HWY_UNROLL(2)
    for (int row = 0; row < Format::kRows; ++row) {
      HWY_UNROLL(12)
      for (int i = 0; i < kBlock * Format::kBytes; i += kLanes) {
        const Vector in = hn::LoadU(d, block + row * stride + i);
        const int k = i / kLanes % kVectors;
        beyond = hn::Or(beyond, hn::SaturatedSub(hn::Sub(in, low_[row][k]), extent_[row][k]));
      }
    }
    return !hn::AllTrue(d, hn::Eq(beyond, hn::Zero(d)));
  }

 private:
  // The pattern of channels begins anew every so many vectors.
  static constexpr int kVectors = Format::kPeriod == 3 ? 3 : 1;
  static_assert(kLanes % 4 == 0);
  Vector low_[Format::kRows][kVectors], extent_[Format::kRows][kVectors];
};
#endif

template <class Format>
class Search {
 public:
  explicit Search(const RunSearch& search)
      : search_(search),
        cells_(Format::table(*search.lut)),
        stride_(search.image.stride_bytes),
        width_(search.image.width / Format::kRows),
#if HWY_TARGET != HWY_SCALAR
        box_(search.background->box[0]),
        second_box_(search.background->box[1]),
        has_second_box_(search.background->boxes == 2),
        chroma_(*search.background),
#endif
        background_(search.background->label),
        out_{search.runs} {
  }

  RunSearchResult run() {
    for (int y = search_.row_begin; y < search_.row_end && out_.begun <= search_.max_runs; ++y) {
      out_.y = static_cast<std::uint16_t>(y);
      const std::uint8_t* row = search_.image.row(y * Format::kRows);
      for (const sslv::Mask::Interval interval : search_.mask->row(y, Format::kRows)) {
        const int end = std::min<int>(interval.end, width_);
        if (interval.begin < end) search_interval(row, interval.begin, end);
      }
    }
    result_.runs = out_.begun;
    return result_;
  }

 private:
  HWY_INLINE Label label(const std::uint8_t* row, int x) const {
    return Format::label(cells_, row, stride_, x);
  }

  HWY_INLINE void look_up(const std::uint8_t* row, int begin, int end) {
    for (int x = begin; x < end; ++x) out_.set(x, label(row, x));
  }

  /// Cells [begin, end) of a row.
  void search_interval(const std::uint8_t* row, int begin, int end) {
#if HWY_TARGET != HWY_SCALAR
    if (width_ >= kBlock) {
      search_blocks(row, begin, end);
    } else  // NOLINT: the loop below is all that is left for SCALAR
#endif
    {
      look_up(row, begin, end);
    }
    out_.set(end, label::kClear);
  }

#if HWY_TARGET != HWY_SCALAR
  void search_blocks(const std::uint8_t* row, int begin, int end) {
    const int last = (end + kBlock - 1) / kBlock;
    int done = begin;
    for (int group = begin / kBlock; group < last; group += kGroup) {
      const int blocks = std::min(kGroup, last - group);
      std::uint64_t odd = odd_blocks(row, group, blocks);
      result_.blocks += static_cast<std::size_t>(blocks);
      result_.odd_blocks += static_cast<std::size_t>(std::popcount(odd));
      if (has_second_box_) odd = not_in_second_box(row, group, odd);
      // All blocks go through one step before any goes through the next: steps without branches overlap.
      std::uint64_t candidates[kGroup];
      std::uint64_t mixed = 0;
      for (; odd != 0; odd &= odd - 1) {
        const int i = std::countr_zero(odd), at = place_of(group + i);
        const int from = std::max((group + i) * kBlock, begin), to = std::min((group + i + 1) * kBlock, end);
        candidates[i] = find_candidates(row + static_cast<std::ptrdiff_t>(at) * Format::kBytes) &
                        ~std::uint64_t{0} << (from - at) & ~std::uint64_t{0} >> (kBlock - (to - at));
        mixed |= static_cast<std::uint64_t>(candidates[i] != 0) << i;
      }
      for (; mixed != 0; mixed &= mixed - 1) {
        const int i = std::countr_zero(mixed);
        const int from = std::max((group + i) * kBlock, begin), to = std::min((group + i + 1) * kBlock, end);
        if (done < from) out_.set(done, background_);
        look_up_block(row, place_of(group + i), from, to, candidates[i]);
        done = to;
      }
    }
    if (done < end) out_.set(done, background_);
  }

  /// Where a block is read: that at the right edge further left, wholly within the row.
  HWY_INLINE int place_of(int block) const {
    return std::min(block * kBlock, width_ - kBlock);
  }

  /// Those of the `odd` blocks from number `first` on that do not lie wholly in the second box.
  HWY_INLINE std::uint64_t not_in_second_box(const std::uint8_t* row, int first, std::uint64_t odd) {
    const BoxTest<Format> box = second_box_;
    std::uint64_t outside = 0;
    for (std::uint64_t left = odd; left != 0; left &= left - 1) {
      const int i = std::countr_zero(left);
      const std::uint8_t* block = row + static_cast<std::ptrdiff_t>(place_of(first + i)) * Format::kBytes;
      outside |= static_cast<std::uint64_t>(box.outside(block, stride_)) << i;
    }
    result_.in_second_box += static_cast<std::size_t>(std::popcount(odd ^ outside));
    return outside;
  }

  /// One bit for each block from number `first` on: whether it is not wholly in the box.
  HWY_INLINE std::uint64_t odd_blocks(const std::uint8_t* row, int first, int count) const {
    if (search_.background->boxes == 0) return ~std::uint64_t{0} >> (kBlock - count);
    constexpr int kBlockBytes = kBlock * Format::kBytes;
    // The block at the right edge is read from further left, wholly within the row.
    const int whole = std::min(count, width_ / kBlock - first);
    const std::uint8_t* block = row + static_cast<std::ptrdiff_t>(first) * kBlockBytes;
    const BoxTest<Format> box = box_;  // stays in registers, which a member would not
    std::uint64_t odd = 0;
    for (int i = 0; i < whole; ++i, block += kBlockBytes) {
      HWY_UNROLL(2)
      for (int r = 0; r < Format::kRows; ++r) {
        // A picture of two rows a cell is read in two streams.
        const std::uint8_t* ahead = block + (Format::kRows == 1 ? static_cast<std::ptrdiff_t>(kPrefetchAhead)
                                                                : (Format::kRows + r) * stride_);
        HWY_UNROLL(3)
        for (int line = 0; line < kBlockBytes; line += static_cast<int>(kCacheLine))
          hwy::Prefetch(ahead + line);
      }
      odd |= static_cast<std::uint64_t>(box.outside(block, stride_)) << i;
    }
    if (whole < count) {
      const std::uint8_t* tail = row + static_cast<std::ptrdiff_t>(width_ - kBlock) * Format::kBytes;
      odd |= static_cast<std::uint64_t>(box.outside(tail, stride_)) << whole;
    }
    return odd;
  }

  /// One bit for each cell of a block: whether its chroma is one that may have another label.
  HWY_INLINE std::uint64_t find_candidates(const std::uint8_t* block) const {
    const hn::CappedTag<std::uint8_t, Format::kChromas> d;
    constexpr int kStep = static_cast<int>(hn::MaxLanes(d));
    std::uint64_t clear = 0;
    HWY_UNROLL(4)
    for (int i = 0; i < Format::kChromas; i += kStep) {
      hn::Vec<decltype(d)> a, b;
      Format::load_chroma(d, block, stride_, i, a, b);
      clear |= chroma_.clear_bits(d, a, b) << i;
    }
    return Format::kChromas == kBlock ? ~clear : ~doubled(clear);
  }

  /// Cells [from, to) of the block that is read at x and has `candidates`.
  HWY_INLINE void look_up_block(const std::uint8_t* row, int x, int from, int to, std::uint64_t candidates) {
    const std::uint8_t* block = row + static_cast<std::ptrdiff_t>(x) * Format::kBytes;
    if (std::popcount(candidates) <= kFewCandidates) {
      look_up_candidates(block, x, from, to, candidates);
    } else if (to - from == kBlock) {
      alignas(64) Label buffer[kBlock + kBlock];
      Label* labels = buffer + kBlock;
      for (int i = 0; i < kBlock; ++i) labels[i] = Format::label(cells_, block, stride_, i);
      out_.set_block(x, labels);
    } else {
      look_up(row, from, to);
    }
  }

  HWY_INLINE void look_up_candidates(const std::uint8_t* block, int x, int from, int to,
                                     std::uint64_t candidates) {
    int done = from;
    while (candidates != 0) {
      int i = std::countr_zero(candidates);
      if (done < x + i) out_.set(done, background_);
      for (; i < kBlock && (candidates >> i & 1) != 0; ++i) {
        out_.set(x + i, Format::label(cells_, block, stride_, i));
      }
      done = x + i;
      if (i == kBlock) break;
      candidates &= ~std::uint64_t{0} << i;
    }
    if (done < to) out_.set(done, background_);
  }
#endif

  const RunSearch& search_;
  const Cells cells_;
  const std::ptrdiff_t stride_;
  const int width_;
#if HWY_TARGET != HWY_SCALAR
  const BoxTest<Format> box_, second_box_;
  const bool has_second_box_;
  const ChromaTest chroma_;
#endif
  const Label background_;
  RunWriter out_;
  RunSearchResult result_;
};

RunSearchResult SearchRuns(const RunSearch& search) {
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

const char* Target() {
  return hwy::TargetName(HWY_TARGET);
}

}  // namespace HWY_NAMESPACE
}  // namespace sslv
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sslv {

HWY_EXPORT(SearchRuns);
HWY_EXPORT(Target);

RunSearchResult search_runs(const RunSearch& search) noexcept {
  return HWY_DYNAMIC_DISPATCH(SearchRuns)(search);
}

std::string_view search_runs_target() {
  return HWY_DYNAMIC_DISPATCH(Target)();
}

}  // namespace sslv
#endif
