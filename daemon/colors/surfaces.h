// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "colors/margin_text.h"
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

/// Kinds of large surfaces in a camera's frames, unlike dots and balls.
enum class SurfaceKind : std::uint8_t {
  kCarpet,
  kFloor,  // the most common surface besides the carpet
  kOther,  // lines, boards, walls, clothes
};
inline constexpr std::size_t kSurfaceKinds = 3;
/// "carpet", "floor", "other surfaces": for the user.
std::string_view name_of(SurfaceKind kind);

/// A disc of a frame that is excluded, such as a robot.
struct PixelDisc {
  std::size_t frame;
  double x_px, y_px, radius_px;
};

/// Frames of one camera in which surfaces are searched.
struct SurfaceSearch {
  std::span<const ImageView> frames;  // all of one format, with colours
  std::span<SmallPictures> pictures;  // one for each frame
  const Mask* mask = nullptr;
  std::span<const PixelDisc> left_out = {};
  double largest_dot_px = 0;                       // diameter of the largest dot or ball
  std::optional<Color3> carpet_chromaticity = {};  // none: the most common surface
  std::function<bool(std::size_t frame, const Eigen::Vector2d& pixel)> on_carpet =
      {};                     // pixels to search for the carpet; may be empty
  std::stop_token stop = {};  // after a stop request, the result is useless
};

/// The colours of large surfaces, texture included, and the noise of their pixels.
class SurfaceColors {
 public:
  /// Bins per channel, of 4 levels each.
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
  /// All bins that are not empty.
  std::vector<Color> colors(SurfaceKind kind) const;

  /// Standard deviation of one pixel's Y, U and V from the colour around it, in grey levels.
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

/// Uses places where a colour continues to the left and right, or up and down, further than any dot or ball
/// extends. Takes tens of milliseconds per frame.
SurfaceColors find_surfaces(const SurfaceSearch& search);

/// Range of light, relative to the light in the frames, in which surfaces must stay clear.
struct ClearRange {
  double darkest = 0.5, brightest = 1.6;
  double noise_sigmas = 2.5;  // how far pixels may scatter
};

/// Clears cells with colours that surfaces have, or would have in more or less light. Clears colours of the
/// carpet regardless of their label, unless `keep` accepts the cell (its colour was seen with its label on a
/// robot or ball) and the cell's hue differs from the carpet's: shaded blue is as dark as shaded carpet, but
/// still blue. Clears colours of the floor and other surfaces unless `keep` accepts them, so an orange board
/// does not clear the ball's colour. Keeps cells labelled field, white or black. Returns the number of cells
/// changed.
std::size_t clear_surfaces(ColorTable& table, const SurfaceColors& surfaces, const ClearRange& range,
                           const std::function<bool(Label, Yuv)>& keep);

/// True for the labels that surfaces may have: field, white and black.
bool is_surface_label(Label label);

/// Whether a surface has a colour, or would have it in light within the range. The result holds no reference
/// to `surfaces`.
using SurfaceReach = std::function<bool(Yuv)>;
SurfaceReach reach_of(const SurfaceColors& surfaces, SurfaceKind kind, const ClearRange& range);

/// Change of light that gives a surface a label.
struct LabelMargin {
  Label label;
  SurfaceKind surface;
  /// Factors on the light; none: beyond kMaxFactor or its inverse.
  std::optional<double> brighter, darker;
  static constexpr double kMaxFactor = 2.5;
};

/// A surface counts as having a label if this share of its pixels has the label.
inline constexpr double kFloodShare = 0.004;
/// Margins of every label in a table to carpet and floor. Assumes that pixel values are proportional to the
/// light; cameras with a gamma have more margin. The result is useless after a stop request.
std::vector<LabelMargin> table_margins(const Lut& lut, const SurfaceColors& surfaces,
                                       const std::stop_token& stop = {});

/// Whether the margins differ by no more than noise and flicker between frames.
bool about_same(std::span<const LabelMargin> a, std::span<const LabelMargin> b);

/// Lamps flicker and age by this much: smaller margins lead to floods during a match.
inline constexpr double kMinMargin = 0.10;

/// A table's smallest margin to the carpet.
struct MinMargin {
  Label label;
  double change;  // relative change of the light: 0.09 is brighter, -0.09 darker
};
/// Returns nothing if no margin to the carpet is within kMaxFactor. Margins to the floor do not count: robots
/// and balls are on the carpet, so a floor with a label hides no robot or ball, and learning keeps the
/// colours of dots even if the floor has these colours, too.
std::optional<MinMargin> min_to_carpet(std::span<const LabelMargin> margins);

}  // namespace sslv
