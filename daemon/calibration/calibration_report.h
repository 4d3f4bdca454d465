// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/lens_camera.h"
#include "calibration/painted_curves.h"
#include "geometry/camera_model.h"

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace sslv {

struct LineFigure {
  std::string name;
  int patches = 0, expected = 0;  // measured, and in view
  double rms_px = 0, worst_px = 0, rms_mm = 0;
};

struct ClickFigure {
  std::string name;  // of the point it shows
  Eigen::Vector2d pixel, place_mm;
  double off_px = 0, off_mm = 0;
  bool suspect = false;  // it shows no point that it could have meant
};

/// Expected errors at places of the field, root mean square in mm.
struct ExpectedError {
  Eigen::Vector2d place_mm;
  double on_floor_mm = 0, at_150_mm = 0;
};

/// What came out, and how far it can be trusted.
struct CalibrationReport {
  bool found = false;     // there is a calibration at all
  bool accepted = false;  // and it is as good as such an image allows
  CameraCalibration calibration;
  LensCamera camera;  // with the lens as it is
  LinesMeasured measured = LinesMeasured::kToMiddle;
  double rms_px = 0, worst_px = 0, rms_mm = 0, worst_mm = 0;  // of lines
  double found_share = 0;                                     // of the lines in view
  double unexplained_share = 0;                               // of the bright stripes on the field
  double coverage = 0;                                        // share of the image's field with lines found
  double condition = 0;                                       // of the problem: 1 is best
  double expected_on_floor_mm = 0, expected_at_150_mm = 0;    // over the field in view, root mean square
  double height_mm = 0, height_sigma_mm = 0;
  double lens_rms_mm = 0, lens_worst_mm = 0;                 // what the wire's lens cannot say
  std::optional<double> moved_on_floor_mm, moved_at_150_mm;  // from the previous one, root mean square
  std::vector<LineFigure> line_figures;
  std::vector<ClickFigure> click_figures;
  std::vector<ClickFigure> control_points;  // where the field's points are in the image, to be looked at
  std::vector<ExpectedError> error_map;
  std::vector<std::string> held;      // what the image does not determine: "focal length", "height", ...
  std::vector<std::string> notes;     // for people: what to know
  std::vector<std::string> problems;  // for people: what is wrong and what to do
};

}  // namespace sslv
