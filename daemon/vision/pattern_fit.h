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

/// One dot of a pattern as the image shows it.
struct PatternDotFit {
  bool seen = false;  // there is a disc at this place
  double off_mm = 0;  // distance from its place in the fitted pattern
  double r2 = 0;      // as DiscFit
  double snr = 0;     // contrast over one sample's noise, all channels together
  Label color = 0;    // the likeliest of the colours that a dot here may have
  double off = 0;     // as ColorName
  double margin = 0;  // 0: might as well be the second likeliest; 1: just as the table's colour; less than 0:
                      // the colour table contradicts
  double pixel_x = 0, pixel_y = 0;
  // Red, green and blue, as DiscFit: for those who learn colours instead of naming them.
  std::array<double, 3> contrast_rgb{}, color_rgb{};
};

/// A pattern laid over the image.
struct PatternFit {
  static constexpr std::size_t kCenter = PatternTable::kMaxDots;  // the centre dot's place in `dots`

  PatternPose pose;
  double pixel_x = 0, pixel_y = 0;  // of the pattern's centre
  double px_per_mm = 0;
  std::array<PatternDotFit, PatternTable::kMaxDots + 1> dots;
  int seen = 0;                    // dots, with the centre
  double rms_mm = 0;               // of the seen dots' distances from their places
  double min_r2 = 0, mean_r2 = 0;  // of the seen dots
  PlaceCov place_cov;
  double angle_sigma_rad = 0;
};

/// Lays a pattern over the image: fits each of its dots as a disc (disc_fit.h) and from all of them that
/// are there, weighted by what each of them knows, the pose: the least-squares estimate in field coordinates
/// on the plane of the top.
class PatternFitter {
 public:
  /// What stays the same for a frame. All must outlive its use.
  struct Frame {
    const ImageView& image;
    const CameraModel& camera;
    const PatternTable& patterns;
    const Lut& lut;
    double blur_px;
  };

  /// Starts at `start`, which should be good to some 5 mm; up to `max_passes` Gauss-Newton steps, fewer when
  /// they have become small. Nothing (seen = 0) when fewer than three dots are there. With a rolling shutter
  /// the pattern is `mm_per_row` further in each row of the image than in the one above; its pose is that
  /// in the row of its centre.
  PatternFit fit(const Frame& frame, PatternPose start, double height_mm, int max_passes,
                 const Eigen::Vector2d& mm_per_row = Eigen::Vector2d::Zero()) noexcept;

  /// The centre dot alone.
  struct Center {
    bool seen = false;
    double x_mm = 0, y_mm = 0;
  };
  Center fit_center(const Frame& frame, double x_mm, double y_mm, double height_mm) noexcept;

  /// Looks for side dots all around a centre. The likeliest headings are written to `angles_rad`, best first;
  /// returns how many, 0 when there is nothing like the pattern. Needs neither regions nor colours: dots
  /// differ from the black between them.
  static constexpr std::size_t kMaxHeadings = 3;
  std::size_t find_headings(const Frame& frame, double x_mm, double y_mm, double height_mm,
                            std::array<double, kMaxHeadings>& angles_rad) noexcept;

  /// What was done since the last reset, in discs fitted, or as much time.
  double work() const { return work_; }
  void reset_work() { work_ = 0; }

 private:
  DiscMeter meter_;
  double work_ = 0;
};

}  // namespace sslv
