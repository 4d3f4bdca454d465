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

/// A camera that is calibrated already, to be refined with its neighbours.
struct CalibratedView {
  int id = 0;
  MeanPicture picture;
  CameraCalibration calibration;  // current: good to a few centimetres
};

struct JointTask {
  FieldSize field;
  std::optional<LinesMeasured> measured;  // none: see choose_model()
  std::vector<CalibratedView> cameras;
  std::vector<OverlapTie> ties;  // their cameras are places in the list
};

struct JointCameraReport {
  int id = 0;
  bool found = false;
  CameraCalibration calibration;
  double rms_px = 0, found_share = 0;  // of its lines
  double height_before_mm = 0, height_mm = 0;
  double lens_rms_mm = 0;                             // what the wire's lens cannot say
  double moved_on_floor_mm = 0, moved_at_150_mm = 0;  // from the current one, root mean square
};

/// How far apart cameras have what both see, in mm: with the current calibrations, and with the new ones.
struct Disagreement {
  double before_mm = 0, after_mm = 0;
};

struct JointReport {
  bool found = false;     // there is a calibration for each camera
  bool accepted = false;  // and they are good, and agree better than the current ones
  std::vector<JointCameraReport> cameras;
  LinesMeasured measured = LinesMeasured::kToMiddle;
  std::optional<Disagreement> on_floor;   // painted lines, across them, root mean square; none: no overlap
  std::optional<Disagreement> of_robots;  // ties, at their height, median; none: no ties
  int overlapping_patches = 0, ties = 0;
  std::vector<std::string> notes;     // for people: what to know
  std::vector<std::string> problems;  // for people: what is wrong and what to do
};

/// Refines each camera from its current calibration, then all of them together. `stop` ends it early, with
/// nothing found.
JointReport calibrate_jointly(const JointTask& task, const std::stop_token& stop = {});

}  // namespace sslv
