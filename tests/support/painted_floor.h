// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/lens_camera.h"
#include "calibration/painted_curves.h"
#include "geometry/field.h"
#include "image/image.h"

#include <cstdint>
#include <vector>

namespace sslv {

/// Images of a field for calibration, drawn without the simulator: with any lens, and lines as inexact as
/// real ones.
struct PaintedFloor {
  FieldSize field;
  LinesMeasured measured = LinesMeasured::kToMiddle;
  std::vector<std::string> missing;  // absent lines
  double wavy_mm = 0;     // rms deviation of lines from their place: slow along each, different for each
  double shifted_mm = 0;  // standard deviation of each line's ends
  int robots = 12;
  bool robots_on_lines = false;
  double noise_sigma = 4, blur_px = 0.55;
  double dim_to = 1;  // light at one side relative to the other
  unsigned seed = 1;
};

struct FloorPicture {
  std::vector<std::uint8_t> bytes;  // rgb24
  ImageView view;
};
FloorPicture draw_floor(const PaintedFloor& floor, const LensCamera& camera);

enum class FloorView { kWhole, kHalf, kQuarter };

/// A typical field of the league and a camera over it; `size` 0: 780 x 580 over 6 x 4 m, 1: 1280 x 1024 over
/// 9 x 6 m, 2: 2448 x 2048 over 12 x 9 m, 3: 390 x 290 over 3 x 2 m, with the resolution of 0 but a fraction
/// of its computing time.
struct FloorSetting {
  int size = 0;
  FloorView view = FloorView::kHalf;
  double tilt_deg = 1.5;
  double k1 = 0.08, k2 = 0;
};
FieldSize floor_field(int size);
LensCamera floor_camera(const FloorSetting& setting);

/// Rms distance in mm, over places on the plane z = height that both true cameras see, between the two
/// estimates' positions.
double overlap_error_mm(const LensCamera& truth_a, const LensCamera& truth_b, const LensCamera& a,
                        const LensCamera& b, const FieldSize& field, double height_mm);

/// Rms distance in mm, over the part of the field that `truth` sees, between points on the plane z = height
/// and their positions according to `estimate`.
double field_error_mm(const LensCamera& truth, const LensCamera& estimate, const FieldSize& field,
                      double height_mm);

}  // namespace sslv
