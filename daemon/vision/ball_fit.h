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

/// What the image says about a ball.
struct BallFit {
  bool ok = false;
  double x_mm = 0, y_mm = 0;  // of its centre, one radius above the floor
  double moved_mm = 0;        // from where the fit began
  double r2 = 0;              // share of the samples' variance that a ball there explains
  double radius_mm = 0;       // the radius that would fit best
  double radius_sigma_mm = 0;
  PlaceCov place_cov;
  double clear_share = 0;         // of the samples around it: carpet, and not line, robot or other things
  double visible_share = 0;       // of the ball's own samples: not hidden by a robot
  std::array<double, 3> color{};  // red, green and blue of its middle
  double contrast = 0;  // difference of that from the carpet's, as a share of it (lengths of vectors)
  double misfit = 1;    // root mean square of what the model leaves of the samples, over the contrast
  /// Mean colour of what lies outside the silhouette in the worst of eight directions; 0: carpet, 1: ball.
  double max_alike = 0;
  /// Root of the summed squares of its outline's second to fourth harmonics: what ellipses, triangles and
  /// squares have.
  double out_of_round_mm = 0;
  double out_of_round_sigma_mm = 0;
};

/// Fits the image of a ball on the carpet: the silhouette of a sphere (by each sample's ray's distance from
/// its centre), shaded by light from any side, to the raw samples of each colour plane. Samples around it
/// that are not like the carpet (lines, other robots) and samples that a robot hides are left out.
class BallFitter {
 public:
  /// What stays the same for a frame. All must outlive its use.
  struct Frame {
    const ImageView& image;
    const CameraModel& camera;
    double radius_mm;                        // of the ball
    std::span<const Robot> robots;           // that may hide it
    double robot_radius_mm, robot_front_mm;  // their outline
    double blur_px;
  };

  BallFitter();
  ~BallFitter();

  /// Whether a ball may come of a fit that is not finished, by what it says so far (`ok` is false).
  using MayBeBall = std::function<bool(const BallFit& so_far)>;

  /// Starts at (x, y) on the plane of its centre, good to about the radius. What judge() adds is missing.
  /// `may_be_ball`, unless it is empty, is asked after the first step and before what is unlike a ball is
  /// left out; if it says no, the fit ends there and is not ok. Allocates nothing.
  BallFit fit(const Frame& frame, double x_mm, double y_mm, const MayBeBall& may_be_ball = {}) noexcept;

  /// Adds to the result of the last fit() what the samples say that the model has no room for: misfit,
  /// max_alike, out_of_round_mm and its sigma. It takes about as long as a fit.
  void judge(BallFit& last) const noexcept;

  /// How much better a piece of tape (a rectangle of one colour) explains the image than the ball `found`
  /// there: the logarithm of the ratio of variances that they leave, the mean over all samples. Less than 0:
  /// it explains less; -1 also where nothing can be told. Takes much longer than fit(). Allocates nothing.
  double rectangle_gain(const Frame& frame, const BallFit& found) noexcept;

 private:
  struct Look;
  struct Place;
  BallFit fit_from(const Frame& frame, double x_mm, double y_mm, const MayBeBall& may_be_ball) noexcept;
  bool read(const Frame& frame, Look& look, BallFit& out) noexcept;
  void leave_out_odd(const Look& look, BallFit& out) noexcept;
  int leave_out_unlike(const Look& look) noexcept;

  struct Group;  // planes that share their samples' places
  std::array<std::unique_ptr<Group>, 3> groups_;
  std::unique_ptr<Look> look_;  // of the last fit
};

}  // namespace sslv
