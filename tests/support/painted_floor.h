// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/lens_camera.h"
#include "calibration/painted_curves.h"
#include "geometry/field.h"
#include "image/image.h"

#include <cstdint>
#include <vector>

namespace sslv {

/// Pictures of a field for calibration, drawn without the simulator: any lens, and lines as people paint
/// them.
struct PaintedFloor {
  FieldSize field;
  LinesMeasured measured = LinesMeasured::kToMiddle;
  std::vector<std::string> missing;  // lines that are not there
  double wavy_mm = 0;     // rms that lines leave their place, slowly along each and differently each
  double shifted_mm = 0;  // standard deviation of each line's place as a whole, per end
  int robots = 12;
  bool robots_on_lines = false;
  double noise_sigma = 4, blur_px = 0.55;
  double dim_to = 1;  // light at one side, as a share of that at the other
  unsigned seed = 1;
};

struct FloorPicture {
  std::vector<std::uint8_t> bytes;  // rgb24
  ImageView view;
};
FloorPicture draw_floor(const PaintedFloor& floor, const LensCamera& camera);

enum class FloorView { kWhole, kHalf, kQuarter };

/// A field and a camera over it as leagues have them; `size` 0: 780 x 580 over 6 x 4 m, 1: 1280 x 1024 over
/// 9 x 6 m, 2: 2448 x 2048 over 12 x 9 m. And 3: 390 x 290 over 3 x 2 m, as sharp as 0 and looked at in a
/// fraction of the time.
struct FloorSetting {
  int size = 0;
  FloorView view = FloorView::kHalf;
  double tilt_deg = 1.5;
  double k1 = 0.08, k2 = 0;
};
FieldSize floor_field(int size);
LensCamera floor_camera(const FloorSetting& setting);

/// Root mean square distance, in mm, over places that both true cameras see on the plane z = height, between
/// where the two estimates have them.
double overlap_error_mm(const LensCamera& truth_a, const LensCamera& truth_b, const LensCamera& a,
                        const LensCamera& b, const FieldSize& field, double height_mm);

/// Root mean square distance, in mm, over the part of the field that `truth` sees, between a place on the
/// plane z = height and where `estimate` has it.
double field_error_mm(const LensCamera& truth, const LensCamera& estimate, const FieldSize& field,
                      double height_mm);

}  // namespace sslv
