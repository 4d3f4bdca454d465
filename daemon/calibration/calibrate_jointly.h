// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/line_picture.h"
#include "calibration/painted_curves.h"
#include "calibration/refine_jointly.h"
#include "geometry/camera_model.h"
#include "geometry/field.h"

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace sslv {

/// A calibrated camera, to be refined together with its neighbours.
struct CalibratedView {
  int id = 0;
  MeanPicture picture;
  CameraCalibration calibration;  // the current calibration; must be accurate to a few cm
};

struct JointTask {
  FieldSize field;
  std::optional<LinesMeasured> measured;  // none: choose_model() decides
  std::vector<CalibratedView> cameras;
  std::vector<OverlapTie> ties;  // camera_a and camera_b are indices into `cameras`
};

struct JointCameraReport {
  int id = 0;
  bool found = false;
  CameraCalibration calibration;
  double rms_px = 0, found_share = 0;  // over the camera's line patches in view
  double height_before_mm = 0, height_mm = 0;
  double lens_rms_mm = 0;                             // error of the protocol's lens model
  double moved_on_floor_mm = 0, moved_at_150_mm = 0;  // RMS shift from the current calibration
};

/// Distance in mm between the positions that two cameras give for the same object, with the current and with
/// the new calibrations.
struct Disagreement {
  double before_mm = 0, after_mm = 0;
};

struct JointReport {
  bool found = false;     // each camera has a new calibration
  bool accepted = false;  // `found` is true and `problems` is empty
  std::vector<JointCameraReport> cameras;
  LinesMeasured measured = LinesMeasured::kToMiddle;
  std::optional<Disagreement> on_floor;   // RMS across the painted lines; none: no overlap
  std::optional<Disagreement> of_robots;  // median over the tie points, at their heights; none: no tie points
  int overlapping_patches = 0, ties = 0;
  std::vector<std::string> notes;     // texts for the user
  std::vector<std::string> problems;  // texts for the user: what is wrong, what to do
};

/// Refines each camera from its current calibration, then all of them together. After a stop request, returns
/// early with `found` false.
JointReport calibrate_jointly(const JointTask& task, const std::stop_token& stop = {});

}  // namespace sslv
