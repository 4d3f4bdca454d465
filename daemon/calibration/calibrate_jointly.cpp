// SPDX-License-Identifier: Apache-2.0
#include "calibration/calibrate_jointly.h"

#include "calibration/publish.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// A camera is good when its lines lie so well, and so much of them is found: as in calibrate.cpp.
constexpr double kMostRmsPx = 0.6, kLeastFoundShare = 0.52;
/// How far lines may be from where the calibration in force has them: a share of the picture's width.
constexpr double kWindowShare = 0.02, kLeastWindowPx = 8;
/// A camera that would hang this much higher or lower than it was said to: a share of its height. Robots
/// whose height is 7 mm wrong do that.
constexpr double kHeightShare = 0.05;
/// Cameras that differ by less than this agree, whatever they did before.
constexpr double kAgreeMm = 0.5;
constexpr double kRobotsMm = 150;

struct Refining {
  LinePicture picture;
  CameraPrior prior;
  RefinedCamera refined;
};

/// What the lines do not show, such as the height of a camera that looks straight down, stays as it is in
/// force: somebody may have measured it.
CameraPrior prior_in_force(const CameraCalibration& calibration) {
  CameraPrior prior = camera_prior(calibration.pixel_image_width, calibration.pixel_image_height);
  prior.focal_px = calibration.focal_length;
  prior.focal_share = kHeightShare;
  return prior;
}

std::optional<Refining> refine_alone(const CalibratedView& view, const FieldSize& field,
                                     std::span<const PaintedCurve> curves, const std::stop_token& stop) {
  const LensCamera start = lens_camera(view.calibration);
  const double line_px = field.line_thickness * start.focal_px / std::max(1.0, start.position_mm.z());
  Refining out{find_line_pixels(view.picture, line_px), prior_in_force(view.calibration), {}};
  const double window_px = std::max(kLeastWindowPx, kWindowShare * start.width);
  auto refined = refine_camera(out.picture, start, curves, out.prior, {window_px, false}, stop);
  if (!refined) return std::nullopt;
  out.refined = std::move(*refined);
  return out;
}

double rms_px(std::span<const Refining> cameras) {
  double squares = 0, count = 0;
  for (const Refining& camera : cameras) {
    const auto sightings = static_cast<double>(camera.refined.sightings.size());
    squares += sightings * camera.refined.rms_px * camera.refined.rms_px;
    count += sightings;
  }
  return count > 0 ? std::sqrt(squares / count) : 0;
}

/// The cameras fitted to the same lines a few millimetres elsewhere; nothing when one of them cannot be.
std::optional<std::vector<Refining>> refine_all_again(std::vector<Refining> cameras,
                                                      std::span<const PaintedCurve> curves,
                                                      const std::stop_token& stop) {
  for (Refining& camera : cameras) {
    auto again = refine_again(camera.picture, camera.refined.camera, curves, camera.prior, {0, false}, stop);
    if (!again) return std::nullopt;
    camera.refined = std::move(*again);
  }
  return cameras;
}

/// Gives a lens a second radial term when that explains its lines clearly better.
void choose_lens(Refining& camera, std::span<const PaintedCurve> curves, const std::stop_token& stop) {
  constexpr double kWorthATerm = 0.9;
  CameraPrior two_radial = camera.prior;
  two_radial.k2_sigma = 0.3;
  const auto fit = [&](const CameraPrior& prior) {
    return fit_camera(camera.refined.camera, camera.refined.sightings, prior, {3, 40});
  };
  const CameraFit with_two = fit(two_radial);
  if (with_two.rms >= kWorthATerm * fit(camera.prior).rms) return;
  auto again = refine_again(camera.picture, with_two.camera, curves, camera.prior, {0, true}, stop);
  if (!again) return;
  camera.refined = std::move(*again);
  camera.prior = two_radial;
}

/// q and -q are the same rotation: the one that looks like the old one.
void keep_sign(const CameraCalibration& old, CameraCalibration& now) {
  if (old.q0 * now.q0 + old.q1 * now.q1 + old.q2 * now.q2 + old.q3 * now.q3 >= 0) return;
  for (double* q : {&now.q0, &now.q1, &now.q2, &now.q3}) *q = -*q;
}

/// Root mean square distance on the plane z = height between where two cameras have the same pixels of the
/// field.
double moved_mm(const LensCamera& before, const LensCamera& now, const FieldSize& field, double height_mm) {
  constexpr int kColumns = 16, kRows = 12;
  double squares = 0;
  int count = 0;
  for (int j = 0; j < kRows; ++j) {
    for (int i = 0; i < kColumns; ++i) {
      const Eigen::Vector2d pixel((i + 0.5) * now.width / kColumns, (j + 0.5) * now.height / kRows);
      const auto there = before.unproject(pixel, height_mm), here = now.unproject(pixel, height_mm);
      if (!there || !here || std::abs(here->x()) > field.field_length / 2.0 ||
          std::abs(here->y()) > field.field_width / 2.0)
        continue;
      squares += (*here - *there).squaredNorm();
      ++count;
    }
  }
  return count > 0 ? std::sqrt(squares / count) : 0;
}

/// How far apart a tie's two cameras have it.
std::vector<double> distances_mm(std::span<const LensCamera> cameras, std::span<const OverlapTie> ties) {
  std::vector<double> out;
  for (const OverlapTie& tie : ties) {
    const auto a = cameras[tie.camera_a].unproject(tie.pixel_a, tie.height_mm),
               b = cameras[tie.camera_b].unproject(tie.pixel_b, tie.height_mm);
    if (a && b) out.push_back((*a - *b).norm());
  }
  return out;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double rms(std::span<const double> values) {
  double squares = 0;
  for (const double value : values) squares += value * value;
  return std::sqrt(squares / static_cast<double>(values.size()));
}

bool is_worse(const std::optional<Disagreement>& disagreement) {
  return disagreement && disagreement->after_mm > std::max(kAgreeMm, disagreement->before_mm);
}

class JointCalibrator {
 public:
  JointCalibrator(const JointTask& task, const std::stop_token& stop) : task_(task), stop_(stop) {}

  JointReport run() {
    for (const CalibratedView& view : task_.cameras) {
      report_.cameras.emplace_back().id = view.id;
      in_force_.push_back(lens_camera(view.calibration));
    }
    if (task_.cameras.size() < 2) {
      report_.problems.push_back("One camera alone agrees with itself: calibrate two or more together.");
      return std::move(report_);
    }
    if (!refine_each()) return std::move(report_);
    choose_model();
    std::vector<JointCamera> seen;
    for (const Refining& camera : cameras_) seen.push_back({camera.refined, camera.prior});
    const JointCalibration joint = refine_jointly(seen, curves_, task_.ties, stop_);
    if (stop_.stop_requested()) return std::move(report_);
    fill_report(joint, seen);
    add_notes();
    return std::move(report_);
  }

 private:
  bool refine_each() {
    report_.measured = task_.measured.value_or(LinesMeasured::kToOuterEdge);
    curves_ = painted_curves(task_.field, report_.measured);
    for (std::size_t i = 0; i < task_.cameras.size(); ++i) {
      const CalibratedView& view = task_.cameras[i];
      if (view.picture.width() != in_force_[i].width || view.picture.height() != in_force_[i].height) {
        report_.problems.push_back(fmt::format(
            "Camera {} sends {} x {} pixels, its calibration was made for {} x {}: calibrate it "
            "by itself first.",
            view.id, view.picture.width(), view.picture.height(), in_force_[i].width, in_force_[i].height));
        continue;
      }
      auto refined = refine_alone(view, task_.field, curves_, stop_);
      if (stop_.stop_requested()) return false;
      if (!refined) {
        report_.problems.push_back(
            fmt::format("Camera {}'s lines were not found near where its calibration has them: calibrate it "
                        "by itself first.",
                        view.id));
        continue;
      }
      cameras_.push_back(std::move(*refined));
    }
    return cameras_.size() == task_.cameras.size();
  }

  /// Which edge the field's sizes were measured to, which is the same for all, and each camera's lens.
  void choose_model() {
    constexpr double kClearlyBetter = 0.8;
    if (!task_.measured) {
      auto middle = painted_curves(task_.field, LinesMeasured::kToMiddle);
      auto others = refine_all_again(cameras_, middle, stop_);
      if (others && rms_px(*others) < kClearlyBetter * rms_px(cameras_)) {
        report_.measured = LinesMeasured::kToMiddle;
        curves_ = std::move(middle);
        cameras_ = std::move(*others);
      }
    }
    for (Refining& camera : cameras_) choose_lens(camera, curves_, stop_);
  }

  void fill_report(const JointCalibration& joint, std::span<const JointCamera> seen) {
    report_.found = true;
    std::vector<LensCamera> published;  // what is compared is what teams get
    for (std::size_t i = 0; i < joint.cameras.size(); ++i) {
      JointCameraReport& out = report_.cameras[i];
      const RefinedCamera& refined = cameras_[i].refined;
      const Published wire = publish(joint.cameras[i]);
      published.push_back(lens_camera(wire.calibration));
      out.found = true;
      out.calibration = wire.calibration;
      keep_sign(task_.cameras[i].calibration, out.calibration);
      out.height_before_mm = in_force_[i].position_mm.z();
      out.height_mm = published[i].position_mm.z();
      out.lens_rms_mm = wire.rms_mm;
      out.found_share = refined.found_share();
      std::vector<double> off_px = residuals(joint.cameras[i], refined.sightings);
      for (std::size_t k = 0; k < off_px.size(); ++k) off_px[k] *= refined.sightings[k].sigma_px;
      out.rms_px = rms(off_px);
      out.moved_on_floor_mm = moved_mm(in_force_[i], published[i], task_.field, 0);
      out.moved_at_150_mm = moved_mm(in_force_[i], published[i], task_.field, kRobotsMm);
    }
    const auto lines_before = disagreements_mm(in_force_, seen, curves_),
               lines_after = disagreements_mm(published, seen, curves_);
    report_.overlapping_patches = static_cast<int>(lines_after.size());
    if (!lines_before.empty() && !lines_after.empty())
      report_.on_floor = {rms(lines_before), rms(lines_after)};
    const auto ties_before = distances_mm(in_force_, task_.ties),
               ties_after = distances_mm(published, task_.ties);
    report_.ties = static_cast<int>(ties_after.size());
    if (!ties_before.empty() && !ties_after.empty())
      report_.of_robots = {median(ties_before), median(ties_after)};
    find_neighbours(published, seen);
  }

  /// Which cameras see something that another one sees.
  void find_neighbours(std::span<const LensCamera> cameras, std::span<const JointCamera> seen) {
    has_neighbour_.assign(cameras.size(), false);
    for (const OverlapTie& tie : task_.ties)
      has_neighbour_[tie.camera_a] = has_neighbour_[tie.camera_b] = true;
    for (std::size_t a = 0; a < cameras.size(); ++a) {
      for (std::size_t b = a + 1; b < cameras.size(); ++b) {
        const std::array two{cameras[a], cameras[b]};
        const std::array two_seen{seen[a], seen[b]};
        if (disagreements_mm(two, two_seen, curves_).empty()) continue;
        has_neighbour_[a] = has_neighbour_[b] = true;
      }
    }
  }

  void add_notes() {
    std::vector<std::string>&notes = report_.notes, &problems = report_.problems;
    for (const JointCameraReport& camera : report_.cameras) {
      if (camera.found_share <= kLeastFoundShare) {
        problems.push_back(fmt::format(
            "Camera {}: only {:.0f} % of the lines that should be in view were found: do the field's sizes "
            "fit this field, and does its calibration?",
            camera.id, 100 * camera.found_share));
      }
      if (camera.rms_px >= kMostRmsPx) {
        problems.push_back(
            fmt::format("Camera {}: its lines lie {:.2f} px off on average (expected less than {}): do the "
                        "field's sizes fit this field?",
                        camera.id, camera.rms_px, kMostRmsPx));
      }
      if (std::abs(camera.height_mm - camera.height_before_mm) > kHeightShare * camera.height_before_mm) {
        problems.push_back(fmt::format(
            "Camera {} would hang at {:.0f} mm instead of {:.0f} mm: measure it. If it does not, the teams' "
            "robot heights are wrong.",
            camera.id, camera.height_mm, camera.height_before_mm));
      }
      if (camera.lens_rms_mm > kAgreeMm) {
        notes.push_back(
            fmt::format("Camera {}: its lens bends lines in a way that the league's protocol cannot say: "
                        "what is published differs by {:.1f} mm on average.",
                        camera.id, camera.lens_rms_mm));
      }
    }
    const bool overlap =
        std::find(has_neighbour_.begin(), has_neighbour_.end(), true) != has_neighbour_.end();
    if (!overlap) {
      problems.push_back(
          "No line and no robot was seen by two cameras: nothing ties them. Turn or move them until they "
          "overlap.");
    } else {
      for (std::size_t i = 0; i < has_neighbour_.size(); ++i) {
        if (has_neighbour_[i]) continue;
        notes.push_back(fmt::format(
            "Camera {} sees no line and no robot that another one sees: it was refined by itself.",
            report_.cameras[i].id));
      }
      if (report_.ties == 0) {
        notes.push_back(
            "No robot was seen by two cameras at the same moment: only lines tie the cameras, so that "
            "robots' tops may go on differing. Put robots where the cameras overlap.");
      }
    }
    if (is_worse(report_.on_floor)) {
      problems.push_back(
          fmt::format("The cameras would disagree by {:.1f} mm on the floor, and do by {:.1f} "
                      "mm now: the calibrations in force are better.",
                      report_.on_floor->after_mm, report_.on_floor->before_mm));
    }
    if (is_worse(report_.of_robots)) {
      problems.push_back(
          fmt::format("The cameras would disagree by {:.1f} mm about robots, and do by {:.1f} "
                      "mm now: are the teams' robot heights right?",
                      report_.of_robots->after_mm, report_.of_robots->before_mm));
    }
    if (report_.measured == LinesMeasured::kToMiddle && !task_.measured) {
      notes.push_back(
          "The lines lie as if the field's sizes had been measured to their middle, not to their outer edge "
          "as the rules say.");
    }
    report_.accepted = problems.empty();
  }

  const JointTask& task_;
  const std::stop_token& stop_;
  JointReport report_;
  std::vector<PaintedCurve> curves_;
  std::vector<LensCamera> in_force_;
  std::vector<Refining> cameras_;
  std::vector<bool> has_neighbour_;
};

}  // namespace

JointReport calibrate_jointly(const JointTask& task, const std::stop_token& stop) {
  return JointCalibrator(task, stop).run();
}

}  // namespace sslv
