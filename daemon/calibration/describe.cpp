// SPDX-License-Identifier: Apache-2.0
#include "calibration/describe.h"

#include "base/statistics.h"
#include "calibration/measure_lines.h"
#include "calibration/publish.h"
#include "calibration/way_round.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <Eigen/Dense>
#include <fmt/format.h>

namespace sslv {
namespace {

void add_line_figures(const Finding& finding, CalibrationReport& out) {
  const LensCamera& camera = finding.refined.camera;
  const std::vector<Sighting>& sightings = finding.refined.sightings;
  const double scale_mm = 1 / camera.px_per_mm();
  std::map<std::size_t, std::vector<double>> off_px;  // by curve
  const std::vector<double> off = residuals_px(camera, sightings);
  for (std::size_t i = 0; i < off.size(); ++i) {
    const double px = std::abs(off[i]);
    off_px[sightings[i].curve].push_back(px);
    out.worst_px = std::max(out.worst_px, px);
  }
  out.rms_px = rms(off);
  out.rms_mm = scale_mm * out.rms_px;
  out.worst_mm = scale_mm * out.worst_px;

  std::map<std::size_t, int> expected;  // by curve
  for (const CurvePoint& point :
       points_along(finding.curves, kPatchPx * scale_mm, (kPatchPx / 2 + 4) * scale_mm + 10)) {
    const auto pixel = camera.project(point.place_mm);
    if (pixel && camera.is_in_picture(*pixel, kPatchPx)) ++expected[point.curve];
  }
  for (const auto& [curve, count] : expected) {
    LineFigure& line = out.line_figures.emplace_back();
    line.name = finding.curves[curve].name;
    line.expected = count;
    const std::vector<double>& off_line = off_px[curve];
    line.patches = static_cast<int>(off_line.size());
    for (const double px : off_line) line.worst_px = std::max(line.worst_px, px);
    line.rms_px = rms(off_line);
    line.rms_mm = scale_mm * line.rms_px;
  }
}

/// Of the image cells that show the field, the share that contains measured lines.
double coverage(const RefinedCamera& refined, const FieldSize& field) {
  constexpr int kColumns = 6, kRows = 4;
  const LensCamera& camera = refined.camera;
  std::array<bool, static_cast<std::size_t>(kColumns * kRows)> covered{};
  const auto cell_of = [&](const Eigen::Vector2d& pixel) {
    const int x = std::clamp(static_cast<int>(pixel.x() * kColumns / camera.width), 0, kColumns - 1);
    const int y = std::clamp(static_cast<int>(pixel.y() * kRows / camera.height), 0, kRows - 1);
    return static_cast<std::size_t>(y * kColumns + x);
  };
  for (const Sighting& sighting : refined.sightings) covered[cell_of(sighting.pixel)] = true;
  int with_field = 0, with_lines = 0;
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      const Eigen::Vector2d pixel((x + 0.5) * camera.width / kColumns, (y + 0.5) * camera.height / kRows);
      const auto place = camera.unproject(pixel, 0);
      if (!place || std::abs(place->x()) > field.field_length / 2.0 ||
          std::abs(place->y()) > field.field_width / 2.0)
        continue;
      ++with_field;
      with_lines += covered[cell_of(pixel)] ? 1 : 0;
    }
  }
  return with_field > 0 ? static_cast<double>(with_lines) / with_field : 0;
}

std::string label_of(const NamedPoint& point) {
  return point.name.empty() ? fmt::format("({:.0f}, {:.0f}) mm", point.place_mm.x(), point.place_mm.y())
                            : point.name;
}

void add_click_figures(const Finding& finding, CalibrationReport& out) {
  const LensCamera& camera = finding.refined.camera;
  const Clicks& clicks = finding.clicks;
  std::string otherwise;
  for (std::size_t i = 0; i < clicks.pixels.size(); ++i) {
    const Eigen::Vector2d& pixel = clicks.pixels[i];
    const Clicks::Meaning meaning = clicks.meaning(i, camera);
    if (meaning.place == nullptr) continue;
    ClickFigure& figure = out.click_figures.emplace_back();
    figure.pixel = pixel;
    figure.name = meaning.place->name;
    figure.place_mm = meaning.place->place_mm;
    figure.off_px = meaning.off_px;
    const auto shown = camera.unproject(pixel, 0);
    figure.off_mm = shown ? (*shown - figure.place_mm).norm() : 0;
    figure.suspect = meaning.is_far;
    const std::string label = label_of(*meaning.place);
    if (meaning.is_far) {
      out.problems.push_back(
          fmt::format("Point {} at pixel ({:.0f}, {:.0f}) matches none of the given points: the nearest, {}, "
                      "is {:.0f} px away. It was not used; click it again.",
                      i + 1, pixel.x(), pixel.y(), label, figure.off_px));
    } else if (clicks.names_known && figure.name != clicks.places[i].name) {
      otherwise += fmt::format("{}point {} to {}", otherwise.empty() ? "" : ", ", i + 1, label);
    }
  }
  for (const NamedPoint& point : named_points(finding.curves)) {
    const auto pixel = camera.project({point.place_mm.x(), point.place_mm.y(), 0});
    if (pixel && camera.is_in_picture(*pixel))
      out.control_points.push_back({point.name, *pixel, point.place_mm, 0, 0, false});
  }
  if (!otherwise.empty()) {
    out.notes.push_back("Some points did not match their names and were reassigned: " + otherwise + ".");
  }
}

void add_errors(const Finding& finding, CalibrationReport& out) {
  const RefinedCamera& refined = finding.refined;
  const LensCamera published = lens_camera(out.calibration);
  // What is published has also the error of the protocol's lens model.
  const auto error_at = [&](const Eigen::Vector2d& pixel, double height_mm) {
    const auto place = refined.camera.unproject(pixel, height_mm),
               wire = published.unproject(pixel, height_mm);
    return std::hypot(expected_error_mm(refined, pixel, height_mm),
                      place && wire ? (*place - *wire).norm() : 0);
  };
  Rms on_floor, at_150;
  for (const Eigen::Vector2d& place : places_in_view(refined.camera, finding.task.field)) {
    const auto floor_pixel = refined.camera.project({place.x(), place.y(), 0}),
               robot_pixel = refined.camera.project({place.x(), place.y(), kRobotTopsMm});
    if (!floor_pixel || !robot_pixel) continue;
    const ExpectedError& error = out.error_map.emplace_back(
        ExpectedError{place, error_at(*floor_pixel, 0), error_at(*robot_pixel, kRobotTopsMm)});
    on_floor.add(error.on_floor_mm);
    at_150.add(error.at_150_mm);
  }
  out.expected_on_floor_mm = on_floor.value();
  out.expected_at_150_mm = at_150.value();
}

/// Lists the parameters that the image hardly determines: their sigma is more than kHeldShare of the prior's.
void add_held(const Finding& finding, CalibrationReport& out) {
  const LensCamera& camera = finding.refined.camera;
  const CameraPrior& prior = finding.prior;
  const auto sigma = [&](const CameraStep& by) {
    return std::sqrt(std::max(0.0, by.dot(finding.refined.covariance * by)));
  };
  const auto sigma_of = [&](CameraParam param) {
    CameraStep by = CameraStep::Zero();
    by[param] = 1;
    return sigma(by);
  };
  constexpr double kHeldShare = 0.5;
  const auto check = [&](const char* name, double after, double before) {
    if (after > kHeldShare * before) out.held.emplace_back(name);
  };
  const SteppedCamera stepped(camera, CameraStep::Zero());
  out.height_sigma_mm = sigma(stepped.height_by_step());
  check("focal length", sigma_of(kZoom), prior.focal_share);
  if (prior.height_mm) {
    check("height", out.height_sigma_mm, prior.height_sigma_mm);
  } else {
    check("height", out.height_sigma_mm / camera.position_mm.z(), prior.focal_share);
  }
  check("principal point", std::max(sigma_of(kCenterX), sigma_of(kCenterY)), prior.center_sigma_px);
  check("distortion", sigma(stepped.k1_by_step()), prior.k1_sigma);
}

bool is_held(const CalibrationReport& report, const char* name) {
  return std::find(report.held.begin(), report.held.end(), name) != report.held.end();
}

/// Condition number of the Jacobian with its columns scaled to unit length.
double condition(const RefinedCamera& refined) {
  const auto changes = residuals_by_step(refined.camera, refined.sightings);
  CameraInformation information = changes.transpose() * changes;
  const CameraStep scale = (information.diagonal().array() + 1e-12).rsqrt();
  information = scale.asDiagonal() * information * scale.asDiagonal();
  std::vector<int> params{kZoom, kCenterX, kCenterY, kK1, kTurnX, kTurnY, kTurnZ, kMoveX, kMoveY, kMoveZ};
  if (refined.camera.k2 != 0) params.push_back(kK2);
  const Eigen::MatrixXd fitted = information(params, params);
  const Eigen::VectorXd eigen = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(fitted).eigenvalues();
  return std::sqrt(eigen.maxCoeff() / std::max(1e-18, eigen.minCoeff()));
}

void add_problems(const Finding& finding, CalibrationReport& out) {
  if (!finding.only_one) {
    out.problems.emplace_back(
        "Other parts of the field fit the image nearly as well: click at four corners or crossings.");
  }
  if (finding.other_scale) {
    out.problems.push_back(fmt::format(
        "The image shows only parts that another field ({}) has too, in another size, so the "
        "camera's height of {:.0f} mm is not certain: give its height, or turn the camera to more "
        "of the field.",
        finding.other_scale->help, out.height_mm));
  }
  if (out.lens_rms_mm > kMaxLensMm) {
    out.problems.push_back(fmt::format(
        "This lens bends lines in a way that the league's protocol cannot describe: what is published "
        "would differ by {:.0f} mm on average. Use another lens, or a camera that hangs less tilted.",
        out.lens_rms_mm));
  }
  for (std::string& problem : problems_of(finding.verdict, "were the right points clicked"))
    out.problems.push_back(std::move(problem));
}

/// Explains a deviation that is accepted only because the image is large; nothing if it is usual.
std::optional<std::string> uneven_note(const Verdict& verdict, double expected_on_floor_mm) {
  if (verdict.rms_px < kMaxRmsPx || !verdict.lines_are_near()) return std::nullopt;
  return fmt::format(
      "The lines lie {:.2f} px ({:.1f} mm) off on average, more than straight lines do: the paint or tape "
      "may be uneven, or the image blurred. Places on the floor are expected to be off by {:.1f} mm.",
      verdict.rms_px, verdict.rms_mm(), expected_on_floor_mm);
}

void add_notes(const Finding& finding, CalibrationReport& out) {
  const bool height_was_given = finding.prior.height_mm.has_value();
  const bool tops_are_worse = out.expected_at_150_mm > 5 * out.expected_on_floor_mm + 1;
  if (finding.verdict.is_acceptable() && !height_was_given) {
    if (!finding.task.focal_px && (is_held(out, "height") || is_held(out, "focal length"))) {
      out.notes.push_back(
          fmt::format("The camera's height and focal length are not observable from this view (height {:.0f} "
                      "+- {:.0f} mm): give the height, measured to 50 mm, or the focal length. Places on the "
                      "floor are expected to be off by {:.1f} mm, places of robots' tops by {:.1f} mm.",
                      out.height_mm, out.height_sigma_mm, out.expected_on_floor_mm, out.expected_at_150_mm));
    } else if (tops_are_worse) {
      out.notes.push_back(fmt::format(
          "The camera's height is only accurate to {:.0f} mm, so places of robots' tops may be off by "
          "{:.1f} mm. To improve this, measure the height and enter it.",
          out.height_sigma_mm, out.expected_at_150_mm));
    }
  }
  if (is_held(out, "distortion")) {
    out.notes.emplace_back(
        "The lens' distortion is not observable from this view and is held at its usual value.");
  }
  if (auto note = uneven_note(finding.verdict, out.expected_on_floor_mm))
    out.notes.push_back(std::move(*note));
  if (auto note = lens_note({out.calibration, out.lens_rms_mm, out.lens_worst_mm}))
    out.notes.push_back(std::move(*note));
  if (finding.measured == LinesMeasured::kToOuterEdge && !finding.task.measured)
    out.notes.push_back(outer_edge_note(finding.task.field));
  if (finding.either_way_round) {
    out.notes.push_back(
        fmt::format("Both ends of the field look alike: the +x half was taken to be at the {} of the image. "
                    "Name the points, or say where +x is.",
                    side_of_plus_x(finding.refined.camera)));
  }
}

}  // namespace

CalibrationReport describe(const Finding& finding) {
  const LensCamera& camera = finding.refined.camera;
  CalibrationReport out;
  out.found = true;
  out.camera = camera;
  out.measured = finding.measured;
  const Published published = publish(camera, finding.task.previous, finding.task.field);
  out.calibration = published.calibration;
  out.lens_rms_mm = published.rms_mm;
  out.lens_worst_mm = published.worst_mm;
  out.accepted = finding.verdict.is_acceptable() && finding.only_one && !finding.other_scale &&
                 out.lens_rms_mm <= kMaxLensMm;
  out.found_share = finding.verdict.found_share;
  out.unexplained_share = finding.verdict.unexplained_share;
  out.height_mm = camera.position_mm.z();
  out.coverage = coverage(finding.refined, finding.task.field);
  out.condition = condition(finding.refined);
  add_line_figures(finding, out);
  add_click_figures(finding, out);
  add_errors(finding, out);
  add_held(finding, out);
  if (const auto& previous = finding.task.previous) {
    const LensCamera before = lens_camera(*previous);
    const auto places = places_in_view(camera, finding.task.field);
    out.moved_on_floor_mm = moved_mm(before, camera, places, 0);
    out.moved_at_150_mm = moved_mm(before, camera, places, kRobotTopsMm);
  }
  add_problems(finding, out);
  add_notes(finding, out);
  return out;
}

std::vector<std::string> problems_of(const Verdict& verdict, const char* doubt) {
  std::vector<std::string> out;
  if (!verdict.lines_are_found()) {
    out.push_back(
        fmt::format("{:.0f} % of the lines that should be in view were found, and {:.0f} % of the white "
                    "stripes match no line of the field: do the field's sizes fit this field, and {}?",
                    100 * verdict.found_share, 100 * verdict.unexplained_share, doubt));
  }
  if (!verdict.lines_are_near()) {
    out.push_back(
        fmt::format("The lines lie {:.2f} px ({:.1f} mm) off on average, expected less than {:.2f} px: do "
                    "the field's sizes fit this field?",
                    verdict.rms_px, verdict.rms_mm(), verdict.max_rms_px()));
  }
  return out;
}

std::optional<std::string> lens_note(const Published& published) {
  constexpr double kWorthSayingMm = 0.5;
  if (published.rms_mm <= kWorthSayingMm || published.rms_mm > kMaxLensMm) return std::nullopt;
  return fmt::format(
      "This lens bends lines in a way that the league's protocol cannot describe: the published calibration "
      "differs by {:.1f} mm on average and {:.1f} mm at most.",
      published.rms_mm, published.worst_mm);
}

std::string outer_edge_note(const FieldSize& field) {
  const FieldSize by_rules = measured_to_middle(field, LinesMeasured::kToOuterEdge);
  return fmt::format(
      "The line positions match field sizes measured to the outer edges of the lines, not between their "
      "centres as the rules say. This calibration allows for that, but the sizes that teams get do not: "
      "between centres this field is {} x {} mm. Correct its sizes.",
      by_rules.field_length, by_rules.field_width);
}

std::vector<Eigen::Vector2d> places_in_view(const LensCamera& camera, const FieldSize& field) {
  constexpr int kAcross = 16;
  const double step_mm = static_cast<double>(field.field_length) / kAcross;
  const int half_x = kAcross / 2, half_y = static_cast<int>(field.field_width / 2.0 / step_mm);
  std::vector<Eigen::Vector2d> out;
  for (int j = -half_y; j <= half_y; ++j) {
    for (int i = -half_x; i <= half_x; ++i) {
      const Eigen::Vector2d place(i * step_mm, j * step_mm);
      const auto pixel = camera.project({place.x(), place.y(), 0});
      if (pixel && camera.is_in_picture(*pixel)) out.push_back(place);
    }
  }
  return out;
}

std::optional<double> moved_mm(const LensCamera& before, const LensCamera& now,
                               std::span<const Eigen::Vector2d> places_mm, double height_mm) {
  Rms moved;
  bool any = false;
  for (const Eigen::Vector2d& place : places_mm) {
    const auto pixel = now.project({place.x(), place.y(), height_mm});
    const auto was = pixel ? before.unproject(*pixel, height_mm) : std::nullopt;
    if (!was) continue;
    any = true;
    moved.add((*was - place).norm());
  }
  return any ? std::optional(moved.value()) : std::nullopt;
}

}  // namespace sslv
