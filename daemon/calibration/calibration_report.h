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
  int patches = 0, expected = 0;  // number of patches measured; number in view
  double rms_px = 0, worst_px = 0, rms_mm = 0;
};

struct ClickFigure {
  std::string name;  // name of the field point matched to the click
  Eigen::Vector2d pixel, place_mm;
  double off_px = 0, off_mm = 0;
  bool suspect = false;  // too far from every point that it could mean
};

/// Expected RMS error in mm at a position on the field.
struct ExpectedError {
  Eigen::Vector2d place_mm;
  double on_floor_mm = 0, at_150_mm = 0;
};

/// Result of a calibration, and its quality.
struct CalibrationReport {
  bool found = false;     // there is a calibration
  bool accepted = false;  // the calibration is the only one that explains the lines well
  CameraCalibration calibration;
  LensCamera camera;  // with both radial terms
  LinesMeasured measured = LinesMeasured::kToMiddle;
  double rms_px = 0, worst_px = 0, rms_mm = 0, worst_mm = 0;  // over the line patches
  double found_share = 0;                                     // share of the line patches in view
  double unexplained_share = 0;  // share of the stripe pixels on the field that no line explains
  double coverage = 0;           // share of the field's image cells that have measured lines
  double condition = 0;          // condition number of the fit; 1 is best
  double expected_on_floor_mm = 0, expected_at_150_mm = 0;  // RMS over the field in view
  double height_mm = 0, height_sigma_mm = 0;
  double lens_rms_mm = 0, lens_worst_mm = 0;                 // error of the protocol's lens model
  std::optional<double> moved_on_floor_mm, moved_at_150_mm;  // RMS shift from the previous calibration
  std::vector<LineFigure> line_figures;
  std::vector<ClickFigure> click_figures;
  std::vector<ClickFigure> control_points;  // the field's points in view, for checking by eye
  std::vector<ExpectedError> error_map;
  std::vector<std::string> held;      // parameters not determined by the image: "focal length", "height", ...
  std::vector<std::string> notes;     // texts for the user
  std::vector<std::string> problems;  // texts for the user: what is wrong, what to do
};

}  // namespace sslv
