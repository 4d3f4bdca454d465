// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/camera_model.h"
#include "image/image.h"
#include "vision/detections.h"
#include "vision/rectangle_fit.h"

#include <array>
#include <functional>
#include <memory>
#include <span>

namespace sslv {

/// Result of fitting a ball to the image.
struct BallFit {
  bool ok = false;
  double x_mm = 0, y_mm = 0;  // the ball's centre, one radius above the floor
  double moved_mm = 0;        // distance from the start of the fit
  double r2 = 0;              // share of the samples' variance that a ball there explains
  double radius_mm = 0;       // the radius that fits best
  double radius_sigma_mm = 0;
  PlaceCov place_cov;
  double clear_share = 0;         // share of carpet among the samples around the ball
  double visible_share = 0;       // share of the ball's samples that no robot hides
  std::array<double, 3> color{};  // red, green and blue at the ball's middle
  /// Length of the vector from the carpet's colour to `color`, divided by the length of `color`.
  double contrast = 0;
  double misfit = 1;  // root mean square of the residuals, divided by the contrast
  /// Mean colour outside the silhouette, in the most ball-like of eight directions (0: carpet, 1: ball).
  double max_alike = 0;
  /// Root of the summed squares of the outline's second to fourth harmonics, by which ellipses, triangles and
  /// squares differ from a circle.
  double out_of_round_mm = 0;
  double out_of_round_sigma_mm = 0;
};

/// Fits a ball on the carpet to the raw samples of each colour plane: the silhouette of a sphere (from the
/// distance of each sample's ray to the sphere's centre), shaded by light from any side. Leaves out samples
/// around the ball that differ from the carpet (lines, other robots) and samples that a robot hides.
class BallFitter {
 public:
  /// Constants of a frame. The references must outlive their use.
  struct Frame {
    const ImageView& image;
    const CameraModel& camera;
    double radius_mm;                        // the ball's radius
    std::span<const Robot> robots;           // robots that may hide the ball
    double robot_radius_mm, robot_front_mm;  // the robots' outline
    double blur_px;
  };

  BallFitter();
  ~BallFitter();

  /// Whether an unfinished fit may still become a ball, judged by its preliminary result (`ok` is false).
  using MayBeBall = std::function<bool(const BallFit& so_far)>;

  /// Starts at (x, y) on the plane of the ball's centre, which should be accurate to about the radius. Does
  /// not set the values that judge() adds. `may_be_ball`, unless it is empty, is called after the first step
  /// and before samples unlike a ball are left out; if it returns false, the fit ends there and is not ok.
  /// Allocates nothing.
  BallFit fit(const Frame& frame, double x_mm, double y_mm, const MayBeBall& may_be_ball = {}) noexcept;

  /// Adds the deviations from the model to the result of the last fit(): misfit, max_alike, out_of_round_mm
  /// and its sigma. Takes about as long as a fit.
  void judge(BallFit& last) const noexcept;

  /// How much better a piece of tape (a rectangle of one colour) explains the image than the ball `found`:
  /// the logarithm of the ratio of their residual variances, averaged over all samples. Below 0: worse; also
  /// -1 if the fit fails. Takes much longer than fit(). Allocates nothing.
  double rectangle_gain(const Frame& frame, const BallFit& found) noexcept;

 private:
  struct Look;
  struct Place;
  BallFit fit_from(const Frame& frame, double x_mm, double y_mm, const MayBeBall& may_be_ball) noexcept;
  bool read(const Frame& frame, Look& look, BallFit& out) noexcept;
  void leave_out_odd(const Look& look, BallFit& out) noexcept;
  int leave_out_unlike(const Look& look) noexcept;

  struct Group;  // planes that share the positions of their samples
  std::array<std::unique_ptr<Group>, 3> groups_;
  std::unique_ptr<Look> look_;  // state of the last fit
};

}  // namespace sslv
