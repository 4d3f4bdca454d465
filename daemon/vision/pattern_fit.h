// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/scene.h"
#include "image/image.h"
#include "vision/detections.h"
#include "vision/disc_fit.h"
#include "vision/lut.h"
#include "vision/pattern_pose.h"
#include "vision/patterns.h"

#include <array>
#include <cstddef>

namespace sslv {

/// Fit of one dot of a pattern.
struct PatternDotFit {
  bool seen = false;  // there is a disc at this place
  double off_mm = 0;  // distance from its place in the fitted pattern
  double r2 = 0;      // see DiscFit
  double snr = 0;     // contrast over one sample's noise, all channels together
  Label color = 0;    // the likeliest of the colours allowed for this dot
  double off = 0;     // see ColorName
  double margin = 0;  // see ColorName
  double pixel_x = 0, pixel_y = 0;
  // Red, green and blue as in DiscFit, for learning colours instead of naming them.
  std::array<double, 3> contrast_rgb{}, color_rgb{};
};

/// Fit of a whole pattern.
struct PatternFit {
  static constexpr std::size_t kCenter = PatternTable::kMaxDots;  // the centre dot's index in `dots`

  PatternPose pose;
  double pixel_x = 0, pixel_y = 0;  // the robot's centre
  double px_per_mm = 0;
  std::array<PatternDotFit, PatternTable::kMaxDots + 1> dots;
  int seen = 0;                    // number of dots seen, including the centre
  double rms_mm = 0;               // rms distance of the seen dots from their places
  double min_r2 = 0, mean_r2 = 0;  // least and mean r2 of the seen dots
  PlaceCov place_cov;
  double angle_sigma_rad = 0;
};

/// Fits a pattern to the image: each of its dots as a disc (disc_fit.h), and the pose to all dots that are
/// seen, weighted by the information of each dot. The pose is the least-squares estimate in field coordinates
/// on the plane of the top.
class PatternFitter {
 public:
  /// Constants of a frame. The references must outlive their use.
  struct Frame {
    const ImageView& image;
    const CameraModel& camera;
    const PatternTable& patterns;
    const Lut& lut;
    double blur_px;
  };

  /// Starts at the robot's pose `start`, which should be accurate to about 5 mm. Takes up to `max_passes`
  /// Gauss-Newton steps, fewer if the steps become small. `seen` is 0 if fewer than three dots are seen. With
  /// a rolling shutter, the pattern moves by `mm_per_row` from each row of the image to the next; the result
  /// is its pose when the row of its centre was exposed.
  PatternFit fit(const Frame& frame, PatternPose start, double height_mm, int max_passes,
                 const Eigen::Vector2d& mm_per_row = Eigen::Vector2d::Zero()) noexcept;

  /// Fit of the centre dot alone.
  struct Center {
    bool seen = false;
    double x_mm = 0, y_mm = 0;
  };
  Center fit_center(const Frame& frame, double x_mm, double y_mm, double height_mm) noexcept;

  /// Searches for side dots around a centre dot. Writes the likeliest headings to `angles_rad`, best first,
  /// and returns their number, 0 if nothing looks like the pattern. Needs neither regions nor colours,
  /// because dots differ from the black between the dots.
  static constexpr std::size_t kMaxHeadings = 3;
  std::size_t find_headings(const Frame& frame, double x_mm, double y_mm, double height_mm,
                            std::array<double, kMaxHeadings>& angles_rad) noexcept;

  /// Work done since the last reset; the unit is one fitted disc.
  double work() const { return work_; }
  void reset_work() { work_ = 0; }

 private:
  DiscMeter meter_;
  double work_ = 0;
};

}  // namespace sslv
