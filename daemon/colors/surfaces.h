// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "colors/small_picture.h"
#include "image/color.h"
#include "image/image.h"
#include "vision/label.h"
#include "vision/lut.h"
#include "vision/mask.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

namespace sslv {

/// What is large in a camera's frames, unlike dots and balls.
enum class SurfaceKind : std::uint8_t {
  kCarpet,
  kFloor,  // the commonest beside the carpet
  kOther,  // lines, boards, walls, clothes
};
inline constexpr std::size_t kSurfaceKinds = 3;
/// "carpet", "floor", "other surfaces": for people.
std::string_view name_of(SurfaceKind kind);

/// A disc of a frame that is left out, such as a robot.
struct PixelDisc {
  std::size_t frame;
  double x_px, y_px, radius_px;
};

/// Frames of one camera in which surfaces are looked for.
struct SurfaceSearch {
  std::span<const ImageView> frames;  // of one format with colours
  std::span<SmallPictures> pictures;  // of each frame
  const Mask* mask = nullptr;
  std::span<const PixelDisc> left_out = {};
  double largest_dot_px = 0;                       // diameter of the largest dot or ball
  std::optional<Color3> carpet_chromaticity = {};  // of red, green and blue; absent: the commonest surface
  std::function<bool(std::size_t frame, const Eigen::Vector2d& pixel)> on_carpet =
      {};                     // may be known; where the
                              // commonest counts
  std::stop_token stop = {};  // then what is found is of no use
};

/// The colours of large surfaces, texture included, and how far their pixels scatter about them.
class SurfaceColors {
 public:
  /// Levels of a channel that are counted together: 4.
  static constexpr int kBits = 6, kSide = 1 << kBits;

  void add(SurfaceKind kind, Yuv color) {
    ++counts_[static_cast<std::size_t>(kind)][bin_of(color)];
    ++totals_[static_cast<std::size_t>(kind)];
  }
  std::size_t total(SurfaceKind kind) const { return totals_[static_cast<std::size_t>(kind)]; }

  struct Color {
    Yuv color;  // the middle of a bin
    std::uint32_t count;
  };
  /// Every bin that was seen.
  std::vector<Color> colors(SurfaceKind kind) const;

  /// Noise of one pixel's Y, U and V about the colour around it, in grey levels.
  std::array<double, 3> noise_sigma{};

 private:
  static std::size_t bin_of(Yuv c) {
    constexpr int kShift = 8 - kBits;
    return static_cast<std::size_t>(c.u >> kShift) << (2 * kBits) |
           static_cast<std::size_t>(c.v >> kShift) << kBits | static_cast<std::size_t>(c.y >> kShift);
  }
  static std::vector<std::uint32_t> empty() {
    return std::vector<std::uint32_t>(std::size_t{1} << (3 * kBits));
  }
  std::array<std::vector<std::uint32_t>, kSurfaceKinds> counts_{empty(), empty(), empty()};
  std::array<std::size_t, kSurfaceKinds> totals_{};
};

/// Looks at where a colour goes on to the left and right, or up and down, further than any dot or ball does.
/// Takes some tens of milliseconds a frame.
SurfaceColors find_surfaces(const SurfaceSearch& search);

/// How much brighter and darker than they were seen surfaces shall stay clear.
struct ClearRange {
  double darkest = 0.5, brightest = 1.6;
  double noise_sigmas = 2.5;  // so far pixels may scatter
};

/// Makes cells clear that surfaces have, or would have in more or less light. The carpet takes cells from any
/// label, unless `keep` names the cell (a colour of its label that was seen on a robot or ball) and its hue
/// is none of the carpet's: blue in the shade is as dark as carpet in the shade, and still blue. Floor and
/// other surfaces take no cell that `keep` names: an orange board does not make the ball's colour clear.
/// Labels field, white and black stay. Returns the number of cells changed.
std::size_t clear_surfaces(ColorTable& table, const SurfaceColors& surfaces, const ClearRange& range,
                           const std::function<bool(Label, Yuv)>& keep);

/// Field, white and black: surfaces may have these.
bool is_surface_label(Label label);

/// Whether a surface has a colour, or would have it in the light of the range. It keeps nothing of
/// `surfaces`.
using SurfaceReach = std::function<bool(Yuv)>;
SurfaceReach reach_of(const SurfaceColors& surfaces, SurfaceKind kind, const ClearRange& range);

/// How much more or less light it takes for a surface to get a label.
struct LabelMargin {
  Label label;
  SurfaceKind surface;
  /// Factors on the light; absent: beyond kMaxFactor either way.
  std::optional<double> brighter, darker;
  static constexpr double kMaxFactor = 2.5;
};

/// Of every label that a table has, to carpet and floor. A surface has a label when kFloodShare of its pixels
/// do. Values of pixels are taken to grow with the light; cameras with a gamma have more margin than that.
inline constexpr double kFloodShare = 0.004;
/// Of no use once it was told to stop.
std::vector<LabelMargin> table_margins(const Lut& lut, const SurfaceColors& surfaces,
                                       const std::stop_token& stop = {});

/// Whether margins differ by no more than noise and flicker make of them from frame to frame.
bool about_same(std::span<const LabelMargin> a, std::span<const LabelMargin> b);

/// Every margin shall be as large: lamps differ by that much over a field, and from day to day.
inline constexpr double kWantedMargin = 0.30;
/// Lamps flicker and age by so much: what is nearer floods during a match.
inline constexpr double kMinMargin = 0.10;

/// Where a table is nearest to the carpet.
struct MinMargin {
  Label label;
  double change;  // of the light, as a share of it: 0.09 is brighter, -0.09 darker
};
/// Nothing when no margin to the carpet has a limit. Those to the floor do not count: robots and balls stand
/// on the carpet, so a floor that has a label hides none of them, and learning keeps colours of dots that
/// the floor has too.
std::optional<MinMargin> min_to_carpet(std::span<const LabelMargin> margins);
/// "carpet becomes green at +9 %", or "carpet is green now".
std::string margin_text(std::string_view surface, std::string_view label, double change);

}  // namespace sslv
