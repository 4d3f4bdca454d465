// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/lens_camera.h"
#include "calibration/line_picture.h"
#include "calibration/painted_curves.h"
#include "calibration/refine.h"
#include "geometry/camera_model.h"
#include "geometry/field.h"

#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// A point of the field that somebody pointed at in the picture.
struct ClickedPoint {
  Eigen::Vector2d pixel;
  std::string name;                         // one of named_points(), or empty
  std::optional<Eigen::Vector2d> place_mm;  // instead of a name
};

/// Where the +x half of the field lies in the picture. Asked for when both halves look alike.
enum class PlusX : std::uint8_t { kUnknown, kRight, kLeft, kUp, kDown };

struct CalibrationTask {
  FieldSize field;
  std::optional<LinesMeasured> measured;  // none: whichever suits the picture better
  /// Any four or more, in any order: names only say which points were meant. None: the corners are looked
  /// for.
  std::vector<ClickedPoint> clicks;
  double click_sigma_px = 3;
  PlusX plus_x = PlusX::kUnknown;
  std::optional<double> height_mm;  // of the camera, measured to
  double height_sigma_mm = 20;
  std::optional<double> focal_px;  // of the lens, known to
  double focal_share = 0.02;
  std::optional<CameraCalibration> previous;  // to compare with
};

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
  bool accepted = false;  // and it is as good as such a picture allows
  CameraCalibration calibration;
  LensCamera camera;  // with the lens as it is
  LinesMeasured measured = LinesMeasured::kToOuterEdge;
  double rms_px = 0, worst_px = 0, rms_mm = 0, worst_mm = 0;  // of lines
  double found_share = 0;                                     // of the lines in view
  double unexplained_share = 0;                               // of the bright stripes on the field
  double coverage = 0;                                        // share of the picture's field with lines found
  double condition = 0;                                       // of the problem: 1 is best
  double expected_on_floor_mm = 0, expected_at_150_mm = 0;    // over the field in view, root mean square
  double height_mm = 0, height_sigma_mm = 0;
  double lens_rms_mm = 0, lens_worst_mm = 0;                 // what the wire's lens cannot say
  std::optional<double> moved_on_floor_mm, moved_at_150_mm;  // from the previous one, root mean square
  std::vector<LineFigure> line_figures;
  std::vector<ClickFigure> click_figures;
  std::vector<ClickFigure> control_points;  // where the field's points are in the picture, to be looked at
  std::vector<ExpectedError> error_map;
  std::vector<std::string> held;      // what the picture does not determine: "focal length", "height", ...
  std::vector<std::string> notes;     // for people: what to know
  std::vector<std::string> problems;  // for people: what is wrong and what to do
};

/// Calibrates a camera from its picture, in a few tenths of a second to two. `stop` ends it early, with
/// nothing found. Throws SettingsError for clicks that name no point, or are too few.
CalibrationReport calibrate(const MeanPicture& picture, const CalibrationTask& task,
                            const std::stop_token& stop = {});

}  // namespace sslv
