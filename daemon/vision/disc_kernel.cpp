// SPDX-License-Identifier: Apache-2.0
// Highway includes this file once for each instruction set.
#include "vision/disc_kernel.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/disc_kernel.cpp"
// See segment_kernel.cpp for the reasons.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)
#include <hwy/foreach_target.h>
// After foreach_target.h:
#include <hwy/highway.h>

// Highway's own style of names.
// NOLINTBEGIN(readability-identifier-naming)
HWY_BEFORE_NAMESPACE();
namespace sslv {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, PlaneSamples::kPad>;
using Vector = hn::Vec<Floats>;
constexpr float kBeyond = 5e4F;  // px; images have at most 16384

// All CPUs give bit-identical results, so that a clip gives the same robots and balls on each of them:
// otherwise a fit might end earlier or other samples might be left out, which would change the position.
// Therefore no operations are fused (the file is also compiled without contraction), no operation is an
// approximation, and sums do not depend on the number of lanes.
HWY_INLINE Vector PlusProduct(Vector a, Vector b, Vector c) {
  return hn::Add(hn::Mul(a, b), c);
}
HWY_INLINE Vector MinusProduct(Vector a, Vector b, Vector c) {
  return hn::Sub(c, hn::Mul(a, b));
}
HWY_INLINE Vector InverseSqrt(Vector x) {
  return hn::Div(hn::Set(Floats(), 1), hn::Sqrt(x));
}

/// Sum of all lanes: adds the upper half of the lanes to the lower half until one lane is left.
#if HWY_TARGET == HWY_SCALAR
HWY_INLINE float TotalOf(Floats /*d*/, Vector v) {
  return hn::GetLane(v);
}
#else
template <class D>
HWY_INLINE float TotalOf(D d, hn::Vec<D> v) {
  if constexpr (hn::MaxLanes(d) > 4) {
    const hn::Half<D> half;
    return TotalOf(half, hn::Add(hn::LowerHalf(half, v), hn::UpperHalf(half, v)));
  } else {
    const auto two = hn::Add(v, hn::Shuffle1032(v));
    return hn::GetLane(hn::Add(two, hn::Shuffle2301(two)));
  }
}
#endif

/// A sum over samples in kPad parts, for any number of lanes: part i sums the samples i, i + kPad and so on.
/// Total() adds the parts.
class Sum {
 public:
  HWY_INLINE Sum() {
    for (Vector& part : part_) part = hn::Zero(Floats());
  }
  HWY_INLINE void Add(std::size_t sample, Vector values) {
    Vector& part = part_[sample / kLanes % kParts];
    part = hn::Add(part, values);
  }
  HWY_INLINE float Total() const {
    Vector sum[kParts];
    for (std::size_t i = 0; i < kParts; ++i) sum[i] = part_[i];
    for (std::size_t half = kParts / 2; half > 0; half /= 2) {
      for (std::size_t i = 0; i < half; ++i) sum[i] = hn::Add(sum[i], sum[i + half]);
    }
    return TotalOf(Floats(), sum[0]);
  }

 private:
  static constexpr std::size_t kLanes = hn::MaxLanes(Floats()), kParts = PlaneSamples::kPad / kLanes;
  Vector part_[kParts];
};

/// Loads the values of the grid's next samples, one in each lane, for all planes. Reads whole vectors from
/// `bytes`, where the first sample begins. (Gather instructions would do the same, but are slow on CPUs with
/// microcode fixes against data leaks.) kDeep: also reads the low bits, which begin `to_low_bits` bytes
/// later.
template <int kPlanes, bool kDeep>
HWY_INLINE void LoadValues(const SampleGrid& grid, const std::uint8_t* HWY_RESTRICT bytes,
                           std::ptrdiff_t to_low_bits, std::size_t at, PlaneSamples& samples) {
  const Floats d;
  const hn::RebindToSigned<Floats> di;
  const auto store = [&](auto integers, std::size_t plane) {
    hn::StoreU(hn::ConvertTo(d, integers), d, samples.value[plane].data() + at);
  };
  if constexpr (kDeep) {
    static_assert(kPlanes == 1);
    const hn::Rebind<std::uint16_t, Floats> d16;
    const auto upper = hn::LoadU(d16, reinterpret_cast<const std::uint16_t*>(bytes));
    const auto lower = hn::LoadU(d16, reinterpret_cast<const std::uint16_t*>(bytes + to_low_bits));
    const auto first = hn::Set(d16, 255);
    const auto value = grid.offset[0] == 0 ? hn::Or(hn::ShiftLeft<8>(upper), hn::And(lower, first))
                                           : hn::Or(hn::AndNot(first, upper), hn::ShiftRight<8>(lower));
    hn::StoreU(hn::Mul(hn::ConvertTo(d, hn::PromoteTo(di, value)), hn::Set(d, 1.0F / 256)), d,
               samples.value[0].data() + at);
  } else if constexpr (kPlanes == 1) {  // every second byte
    const hn::Rebind<std::uint16_t, Floats> d16;
    const auto pairs = hn::LoadU(d16, reinterpret_cast<const std::uint16_t*>(bytes));
    store(
        hn::PromoteTo(di, grid.offset[0] == 0 ? hn::And(pairs, hn::Set(d16, 255)) : hn::ShiftRight<8>(pairs)),
        0);
  } else if constexpr (kPlanes == 2) {  // two of every four bytes
    const auto fours = hn::LoadU(di, reinterpret_cast<const std::int32_t*>(bytes));
    for (std::size_t p = 0; p < 2; ++p) {
      store(hn::And(hn::ShiftRightSame(fours, 8 * grid.offset[p]), hn::Set(di, 255)), p);
    }
  } else {  // three bytes
    const hn::Rebind<std::uint8_t, Floats> d8;
    hn::Vec<decltype(d8)> byte[3];
    hn::LoadInterleaved3(d8, bytes, byte[0], byte[1], byte[2]);
    for (std::size_t p = 0; p < 3; ++p) store(hn::PromoteTo(di, byte[grid.offset[p]]), p);
  }
}

template <int kPlanes, bool kDeep>
void ReadPlanes(const KernelPatch& patch, float x, float y, float radius, const ImageView& image,
                const SampleGrid& grid, PlaneSamples& samples) {
  const Floats d;
  const auto lanes = static_cast<int>(hn::Lanes(d));
  int count = samples.count;
  // The circle is an ellipse in the image: uu du^2 + 2 uv du dv + vv dv^2 = radius^2. A first-order
  // approximation is sufficient, because half a pixel is added on all sides and the sums ignore samples that
  // are too far out.
  const float uu = patch.xu * patch.xu + patch.yu * patch.yu, uv = patch.xu * patch.xv + patch.yu * patch.yv;
  const float det = patch.xu * patch.yv - patch.xv * patch.yu;
  const float chord2 = radius * radius / uu;
  const float slant = uv / uu, narrowing = det * det / (uu * uu);
  const float half_height = std::sqrt(chord2 / narrowing) + 0.5F;
  const float middle_u = patch.u0 + (patch.yv * x - patch.xv * y) / det;
  const float middle_v = patch.v0 + (patch.xu * y - patch.yu * x) / det;
  const int rows = (image.height - grid.first_y + grid.step_y - 1) / grid.step_y;
  const int columns = (image.width - grid.first_x + grid.step_x - 1) / grid.step_x;
  const float per_x = 1 / static_cast<float>(grid.step_x), per_y = 1 / static_cast<float>(grid.step_y);
  const float first_x = static_cast<float>(grid.first_x) + grid.middle_x;
  const auto up = [](float value) { return static_cast<int>(std::ceil(value)); };
  const float top = (middle_v - static_cast<float>(grid.first_y)) * per_y;
  const int row_begin = std::max(0, up(top - half_height * per_y));
  const int row_end = std::min(rows, up(top + half_height * per_y));
  // If PlaneSamples cannot hold all samples of a disc, only every n-th row is read.
  const float most = 4 * half_height * std::sqrt(chord2) * per_x * per_y;
  const int row_step = 1 + static_cast<int>(2 * most / PlaneSamples::kMax);

  constexpr int kPixels = 512;  // maximum number of samples in a row
  // Every row reads the same number of vectors: loops of varying length cost more than surplus samples, which
  // the next row overwrites.
  const int widest = std::min(kPixels, up((2 * std::sqrt(chord2) + 1) * per_x) + 1);
  const int vectors = (widest + lanes - 1) / lanes;
  const int most_of_a_row = (widest + PlaneSamples::kPad - 1) / PlaneSamples::kPad * PlaneSamples::kPad;
  constexpr std::ptrdiff_t kCopyBytes = 4 * (kPixels + PlaneSamples::kPad);
  std::uint8_t copy[(kDeep ? 2 : 1) * kCopyBytes];
  const Vector step_u = hn::Set(d, static_cast<float>(grid.step_x * lanes));
  const Vector ramp_u = hn::Mul(hn::Iota(d, 0), hn::Set(d, static_cast<float>(grid.step_x)));
  const std::ptrdiff_t row_bytes = std::ptrdiff_t{image.width} * bytes_per_pixel(image.format);
  const std::uint8_t* const image_end = image.row(image.height - 1) + row_bytes;
  // Begin and end of rows, one row per lane.
  const hn::RebindToSigned<Floats> di;
  alignas(64) std::int32_t begins[PlaneSamples::kPad], ends[PlaneSamples::kPad];
  const Vector sandboxed_rows = hn::Set(d, static_cast<float>(row_step * grid.step_y));
  const auto find_spans = [&](int row) {
    const Vector first = hn::Set(d, static_cast<float>(grid.first_y + row * grid.step_y));
    const Vector dv = hn::Sub(PlusProduct(hn::Iota(d, 0), sandboxed_rows, first), hn::Set(d, middle_v));
    const Vector half2 = MinusProduct(hn::Mul(dv, dv), hn::Set(d, narrowing), hn::Set(d, chord2));
    const Vector half = hn::Add(hn::Sqrt(hn::Max(half2, hn::Zero(d))), hn::Set(d, 0.5F));
    const Vector middle = MinusProduct(hn::Set(d, slant), dv, hn::Set(d, middle_u - first_x));
    const auto column = [&](Vector at) {
      return hn::ConvertTo(di, hn::Ceil(hn::Mul(at, hn::Set(d, per_x))));
    };
    const auto begin = hn::Max(column(hn::Sub(middle, half)), hn::Zero(di));
    const auto end = hn::Min(hn::Min(column(hn::Add(middle, half)), hn::Set(di, columns)),
                             hn::Add(begin, hn::Set(di, widest)));
    hn::Store(begin, di, begins);
    hn::Store(end, di, ends);
  };
  int lane = lanes;
  for (int row = row_begin; row < row_end; row += row_step, ++lane) {
    if (lane == lanes) {
      find_spans(row);
      lane = 0;
    }
    const int begin = begins[lane], end = ends[lane];
    if (begin >= end || count + most_of_a_row > PlaneSamples::kMax) continue;
    const int row_y = grid.first_y + row * grid.step_y;
    const std::uint8_t* bytes = image.row(row_y) + std::ptrdiff_t{begin} * grid.bytes_per_step;
    std::ptrdiff_t to_low_bits = image.to_low_bits;
    const std::ptrdiff_t wanted = std::ptrdiff_t{vectors} * lanes * grid.bytes_per_step;
    if (image_end - bytes < wanted) {  // whole vectors would reach beyond the image
      const auto left = static_cast<std::size_t>(image_end - bytes);
      std::memcpy(copy, bytes, left);
      if constexpr (kDeep) {
        std::memcpy(copy + kCopyBytes, bytes + to_low_bits, left);
        to_low_bits = kCopyBytes;
      }
      bytes = copy;
    }
    const Vector v = hn::Set(d, static_cast<float>(row_y) - patch.v0);
    const Vector begin_u = hn::Set(d, first_x + static_cast<float>(begin * grid.step_x) - patch.u0);
    Vector from_begin = ramp_u;  // whole numbers
    for (int i = 0; i < vectors * lanes; i += lanes) {
      const auto at = static_cast<std::size_t>(count + i);
      hn::StoreU(hn::Add(begin_u, from_begin), d, samples.u.data() + at);
      hn::StoreU(v, d, samples.v.data() + at);
      from_begin = hn::Add(from_begin, step_u);
      LoadValues<kPlanes, kDeep>(grid, bytes + i * grid.bytes_per_step, to_low_bits, at, samples);
    }
    count += end - begin;
  }
  samples.planes = kPlanes;
  samples.count = count;
  // The samples that fill the last vector are marked by a position beyond all images.
  hn::StoreU(hn::Set(d, 2 * kBeyond), d, samples.u.data() + count);
  hn::StoreU(hn::Zero(d), d, samples.v.data() + count);
  for (std::size_t p = 0; p < kPlanes; ++p) hn::StoreU(hn::Zero(d), d, samples.value[p].data() + count);
  hn::StoreU(hn::Zero(d), d, samples.keep.data() + count);
}

void ReadSamples(const KernelPatch& patch, float x, float y, float radius, const ImageView& image,
                 const SampleGrid& grid, PlaneSamples& samples) {
  const bool is_deep = image.to_low_bits != 0;
  switch (grid.planes) {
    case 1:
      return is_deep ? ReadPlanes<1, true>(patch, x, y, radius, image, grid, samples)
                     : ReadPlanes<1, false>(patch, x, y, radius, image, grid, samples);
    case 2: return ReadPlanes<2, false>(patch, x, y, radius, image, grid, samples);
    default: return ReadPlanes<3, false>(patch, x, y, radius, image, grid, samples);
  }
}

/// A patch with its numbers in all lanes.
struct PatchVectors {
  Vector xu, xv, xuu, xuv, xvv, yu, yv, yuu, yuv, yvv;
  explicit PatchVectors(const KernelPatch& p) {
    const auto all = [](float value) { return hn::Set(Floats(), value); };
    xu = all(p.xu), xv = all(p.xv), xuu = all(p.xuu), xuv = all(p.xuv), xvv = all(p.xvv);
    yu = all(p.yu), yv = all(p.yv), yuu = all(p.yuu), yuv = all(p.yuv), yvv = all(p.yvv);
  }
  HWY_INLINE Vector X(Vector u, Vector v) const {
    return PlusProduct(u, PlusProduct(xuu, u, PlusProduct(xuv, v, xu)), hn::Mul(v, PlusProduct(xvv, v, xv)));
  }
  HWY_INLINE Vector Y(Vector u, Vector v) const {
    return PlusProduct(u, PlusProduct(yuu, u, PlusProduct(yuv, v, yu)), hn::Mul(v, PlusProduct(yvv, v, yv)));
  }
};

/// Share of a sample that an edge covers: the integral of the triweight kernel (35/32)(1 - z^2)^3, which is
/// near a Gaussian of sigma 1/3 but exactly flat beyond 1; `z` is clamped to -1 .. 1.
HWY_INLINE Vector Covered(Vector z, Vector z2) {
  const Floats d;
  const auto all = [&](float value) { return hn::Set(d, value); };
  const Vector cubic =
      PlusProduct(z2, PlusProduct(z2, PlusProduct(z2, all(-1.0F / 7), all(0.6F)), all(-1)), all(1));
  return PlusProduct(hn::Mul(z, all(35.0F / 32)), cubic, all(0.5F));
}
HWY_INLINE Vector Slope(Vector z2) {
  const Floats d;
  const Vector w = hn::Sub(hn::Set(d, 1), z2);
  return hn::Mul(hn::Mul(w, w), hn::Mul(w, hn::Set(d, 35.0F / 32)));
}

template <int kPlanes, bool kWide>
DiscSums SumDiscPlanes(const DiscTemplate& disc, const PlaneSamples& samples) {
  const Floats d;
  const auto lanes = static_cast<int>(hn::Lanes(d));
  const auto all = [&](float value) { return hn::Set(d, value); };
  const PatchVectors patch(disc.patch);
  const Vector cx = all(disc.x), cy = all(disc.y);
  const Vector outer2 = all(disc.outer_radius * disc.outer_radius);
  const Vector ox = all(disc.outline_x), oy = all(disc.outline_y);
  const Vector oc = all(disc.outline_cos), os = all(disc.outline_sin);
  const Vector outline2 = all(disc.outline_radius * disc.outline_radius), front = all(disc.outline_front);
  // Variance of the edge: the lens' blur and the sample's own width (a box: width^2 / 12).
  const float mm2 = std::abs(disc.patch.xu * disc.patch.yv - disc.patch.xv * disc.patch.yu);
  const float round2 = (disc.blur_px * disc.blur_px + 1.0F / 12) * mm2;
  const Vector round = all(round2), wide = all((disc.wide_px * disc.wide_px - 1) / 12);
  // A blurred circle shrinks by s^2 / 2R.
  const Vector radius = all(disc.radius), half_curve = all(0.5F / disc.radius);
  const Vector even_radius = all(disc.radius - round2 * 0.5F / disc.radius);
  const Vector even_inverse_w = all(1 / (3 * std::sqrt(round2)));
  const Vector one = all(1), third = all(1.0F / 3), beyond = all(kBeyond);

  Sum xx, xy, yy, xt, yt, sx, sy, tt, st, n;
  Sum px[kPlanes], py[kPlanes], pt[kPlanes], p1[kPlanes], p2[kPlanes];

  for (int i = 0; i < samples.count; i += lanes) {
    const auto at = static_cast<std::size_t>(i);
    const Vector u = hn::Load(d, samples.u.data() + at), v = hn::Load(d, samples.v.data() + at);
    const Vector x = patch.X(u, v), y = patch.Y(u, v);
    const Vector rx = hn::Sub(x, cx), ry = hn::Sub(y, cy);
    const Vector r2 = PlusProduct(rx, rx, PlusProduct(ry, ry, all(1e-6F)));
    const Vector from_x = hn::Sub(x, ox), from_y = hn::Sub(y, oy);
    const Vector ahead = PlusProduct(from_x, oc, hn::Mul(from_y, os));
    const auto in_outline =
        hn::And(hn::Lt(ahead, front), hn::Lt(PlusProduct(from_x, from_x, hn::Mul(from_y, from_y)), outline2));
    const auto inside = hn::And(hn::And(hn::Lt(r2, outer2), hn::Lt(u, beyond)), in_outline);
    const Vector inverse_r = InverseSqrt(r2), r = hn::Mul(r2, inverse_r);
    const Vector nx = hn::Mul(rx, inverse_r), ny = hn::Mul(ry, inverse_r);
    Vector edge = even_radius, inverse_w = even_inverse_w;
    if constexpr (kWide) {
      // Millimetres across the edge for one pixel sideways.
      const Vector across = PlusProduct(patch.xu, nx, hn::Mul(patch.yu, ny));
      const Vector s2 = PlusProduct(wide, hn::Mul(across, across), round);
      edge = MinusProduct(s2, half_curve, radius);
      inverse_w = hn::Mul(third, InverseSqrt(s2));
    }
    const Vector z = hn::Min(one, hn::Max(hn::Neg(one), hn::Mul(hn::Sub(edge, r), inverse_w)));
    const Vector z2 = hn::Mul(z, z);
    const Vector cover = hn::IfThenElseZero(inside, Covered(z, z2));
    const Vector slope = hn::IfThenElseZero(inside, hn::Mul(Slope(z2), inverse_w));
    const Vector dx = hn::Mul(slope, nx), dy = hn::Mul(slope, ny);

    xx.Add(at, hn::Mul(dx, dx));
    xy.Add(at, hn::Mul(dx, dy));
    yy.Add(at, hn::Mul(dy, dy));
    xt.Add(at, hn::Mul(dx, cover));
    yt.Add(at, hn::Mul(dy, cover));
    sx.Add(at, dx);
    sy.Add(at, dy);
    tt.Add(at, hn::Mul(cover, cover));
    st.Add(at, cover);
    n.Add(at, hn::IfThenElseZero(inside, one));
    for (int p = 0; p < kPlanes; ++p) {
      const Vector value =
          hn::IfThenElseZero(inside, hn::Load(d, samples.value[static_cast<std::size_t>(p)].data() + at));
      px[p].Add(at, hn::Mul(dx, value));
      py[p].Add(at, hn::Mul(dy, value));
      pt[p].Add(at, hn::Mul(cover, value));
      p1[p].Add(at, value);
      p2[p].Add(at, hn::Mul(value, value));
    }
  }
  DiscSums out{xx.Total(), xy.Total(), yy.Total(), xt.Total(), yt.Total(), sx.Total(),
               sy.Total(), tt.Total(), st.Total(), n.Total(),  {}};
  for (int p = 0; p < kPlanes; ++p) {
    out.planes[static_cast<std::size_t>(p)] = {px[p].Total(), py[p].Total(), pt[p].Total(), p1[p].Total(),
                                               p2[p].Total()};
  }
  return out;
}

DiscSums SumDisc(const DiscTemplate& disc, const PlaneSamples& samples) {
  switch (samples.planes) {
    case 1: return SumDiscPlanes<1, false>(disc, samples);
    case 2: return SumDiscPlanes<2, true>(disc, samples);
    default: return SumDiscPlanes<3, false>(disc, samples);
  }
}

template <int kPlanes>
BallSums SumBallPlanes(const BallTemplate& ball, const PlaneSamples& samples) {
  const Floats d;
  const auto lanes = static_cast<int>(hn::Lanes(d));
  const auto all = [&](float value) { return hn::Set(d, value); };
  const PatchVectors patch(ball.patch);
  const Vector cx = all(ball.x), cy = all(ball.y), radius = all(ball.radius);
  const Vector mxx = all(ball.mxx), mxy = all(ball.mxy), myy = all(ball.myy);
  const Vector outer2 = all(ball.outer_radius * ball.outer_radius);
  const Vector blur2 = all(ball.blur_px * ball.blur_px + 1.0F / 12);
  const Vector wide2 = all(ball.blur_px * ball.blur_px + ball.wide_px * ball.wide_px / 12);
  const Vector half_curve = all(0.5F / ball.radius), inverse_radius = all(1 / ball.radius);
  const Vector zero = hn::Zero(d), one = all(1), third = all(1.0F / 3);

  Sum products[kBallColumns][kBallColumns], with[kPlanes][kBallColumns], square[kPlanes];
  for (int i = 0; i < samples.count; i += lanes) {
    const auto at = static_cast<std::size_t>(i);
    const Vector u = hn::Load(d, samples.u.data() + at), v = hn::Load(d, samples.v.data() + at);
    const Vector rx = hn::Sub(patch.X(u, v), cx), ry = hn::Sub(patch.Y(u, v), cy);
    const Vector gx = PlusProduct(mxx, rx, hn::Mul(mxy, ry)), gy = PlusProduct(mxy, rx, hn::Mul(myy, ry));
    const Vector r2 = hn::Max(PlusProduct(gx, rx, hn::Mul(gy, ry)), all(1e-6F));
    const auto inside = hn::And(hn::Lt(r2, outer2), hn::Gt(hn::Load(d, samples.keep.data() + at), zero));
    const Vector inverse_r = InverseSqrt(r2), r = hn::Mul(r2, inverse_r);
    const Vector nx = hn::Mul(gx, inverse_r), ny = hn::Mul(gy, inverse_r);
    // Change of the distance over a pixel to the right and downwards.
    const Vector right = PlusProduct(patch.xu, nx, hn::Mul(patch.yu, ny));
    const Vector down = PlusProduct(patch.xv, nx, hn::Mul(patch.yv, ny));
    const Vector s2 =
        PlusProduct(wide2, hn::Mul(right, right), PlusProduct(blur2, hn::Mul(down, down), all(1e-6F)));
    const Vector inverse_w = hn::Mul(third, InverseSqrt(s2));
    const Vector edge = MinusProduct(s2, half_curve, radius);
    const Vector z = hn::Min(one, hn::Max(hn::Neg(one), hn::Mul(hn::Sub(edge, r), inverse_w)));
    const Vector z2 = hn::Mul(z, z);
    const Vector cover = hn::IfThenElseZero(inside, Covered(z, z2));
    const Vector slope = hn::IfThenElseZero(inside, hn::Mul(Slope(z2), inverse_w));
    const Vector up = hn::Sqrt(hn::Max(zero, MinusProduct(hn::Mul(r2, inverse_radius), inverse_radius, one)));
    const Vector columns[kBallColumns] = {hn::Mul(slope, nx),
                                          hn::Mul(slope, ny),
                                          slope,
                                          cover,
                                          hn::Mul(cover, hn::Mul(rx, inverse_radius)),
                                          hn::Mul(cover, hn::Mul(ry, inverse_radius)),
                                          hn::Mul(cover, up),
                                          hn::IfThenElseZero(inside, one)};
    for (int a = 0; a < kBallColumns; ++a) {
      for (int b = 0; b <= a; ++b) products[a][b].Add(at, hn::Mul(columns[a], columns[b]));
    }
    for (int p = 0; p < kPlanes; ++p) {
      const Vector value =
          hn::IfThenElseZero(inside, hn::Load(d, samples.value[static_cast<std::size_t>(p)].data() + at));
      for (int a = 0; a < kBallColumns; ++a) with[p][a].Add(at, hn::Mul(columns[a], value));
      square[p].Add(at, hn::Mul(value, value));
    }
  }
  BallSums out;
  for (std::size_t a = 0; a < kBallColumns; ++a) {
    for (std::size_t b = 0; b <= a; ++b) out.products[a][b] = products[a][b].Total();
  }
  for (std::size_t p = 0; p < kPlanes; ++p) {
    for (std::size_t a = 0; a < kBallColumns; ++a) out.planes[p].with[a] = with[p][a].Total();
    out.planes[p].square = square[p].Total();
  }
  return out;
}

BallSums SumBall(const BallTemplate& ball, const PlaneSamples& samples) {
  switch (samples.planes) {
    case 1: return SumBallPlanes<1>(ball, samples);
    case 2: return SumBallPlanes<2>(ball, samples);
    default: return SumBallPlanes<3>(ball, samples);
  }
}

std::string_view KernelTarget() {
  return hwy::TargetName(HWY_TARGET);
}

}  // namespace HWY_NAMESPACE
}  // namespace sslv
HWY_AFTER_NAMESPACE();
// NOLINTEND(readability-identifier-naming)

#if HWY_ONCE
namespace sslv {

HWY_EXPORT(ReadSamples);
HWY_EXPORT(SumDisc);
HWY_EXPORT(SumBall);
HWY_EXPORT(KernelTarget);

void read_samples(const KernelPatch& patch, float x, float y, float radius, const ImageView& image,
                  const SampleGrid& grid, PlaneSamples& samples) noexcept {
  HWY_DYNAMIC_DISPATCH(ReadSamples)(patch, x, y, radius, image, grid, samples);
}

DiscSums sum_disc(const DiscTemplate& disc, const PlaneSamples& samples) noexcept {
  return HWY_DYNAMIC_DISPATCH(SumDisc)(disc, samples);
}

BallSums sum_ball(const BallTemplate& ball, const PlaneSamples& samples) noexcept {
  return HWY_DYNAMIC_DISPATCH(SumBall)(ball, samples);
}

std::string_view disc_kernel_target() {
  return HWY_DYNAMIC_DISPATCH(KernelTarget)();
}

}  // namespace sslv
#endif
