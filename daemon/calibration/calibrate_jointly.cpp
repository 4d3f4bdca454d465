// SPDX-License-Identifier: Apache-2.0
#include "calibration/calibrate_jointly.h"

#include "base/statistics.h"
#include "calibration/choose_model.h"
#include "calibration/describe.h"
#include "calibration/judge.h"
#include "calibration/publish.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Search window around the lines' expected positions: share of the image's width, and minimum.
constexpr double kWindowShare = 0.02, kMinJointWindowPx = 8;
/// Largest accepted change of a camera's height, as a share of the height. Errors of 7 mm in the robots'
/// heights cause changes of this size.
constexpr double kHeightShare = 0.05;
/// Smaller disagreements are accepted even if they have grown.
constexpr double kAgreeMm = 0.5;

/// Parameters that the lines do not determine, such as the height of a camera that looks straight down, stay
/// at their current values: somebody may have measured them.
CameraPrior prior_in_force(const CameraCalibration& calibration, const MeanPicture& picture) {
  CameraPrior prior = camera_prior(picture.width(), picture.height(), picture.whole);
  prior.focal_px = calibration.focal_length;
  prior.focal_share = kHeightShare;
  return prior;
}

/// For each tie point (OverlapTie), the distance in mm between the positions that its two cameras give. Tie
/// points that a camera cannot unproject are left out.
std::vector<double> distances_mm(std::span<const LensCamera> cameras, std::span<const OverlapTie> ties) {
  std::vector<double> out;
  for (const OverlapTie& tie : ties) {
    const auto a = cameras[tie.camera_a].unproject(tie.pixel_a, tie.height_mm),
               b = cameras[tie.camera_b].unproject(tie.pixel_b, tie.height_mm);
    if (a && b) out.push_back((*a - *b).norm());
  }
  return out;
}

std::string lines_not_found(int camera_id) {
  return fmt::format(
      "Camera {}'s lines were not found near where its calibration predicts them: calibrate it alone first.",
      camera_id);
}

bool is_worse(const std::optional<Disagreement>& disagreement) {
  return disagreement && disagreement->after_mm > std::max(kAgreeMm, disagreement->before_mm);
}

class JointCalibrator {
 public:
  JointCalibrator(const JointTask& task, const std::stop_token& stop)
      : task_(task),
        stop_(stop),
        field_curves_(task.field),
        curves_(field_curves_.measured(task.measured.value_or(LinesMeasured::kToMiddle))) {}

  JointReport run() {
    for (const CalibratedView& view : task_.cameras) {
      report_.cameras.emplace_back().id = view.id;
      in_force_.push_back(lens_camera(view.calibration));
    }
    if (task_.cameras.size() < 2) {
      report_.problems.push_back("A joint calibration needs two or more cameras.");
      return std::move(report_);
    }
    if (!refine_each()) return std::move(report_);
    if (!fit_model()) return std::move(report_);
    const JointCalibration joint = refine_jointly(refined_, curves_, task_.ties, stop_);
    if (stop_.stop_requested()) return std::move(report_);
    fill_report(joint);
    add_remarks();
    return std::move(report_);
  }

 private:
  bool refine_each() {
    for (std::size_t i = 0; i < task_.cameras.size(); ++i) {
      const CalibratedView& view = task_.cameras[i];
      const LensCamera& start = in_force_[i];
      if (view.picture.width() != start.width || view.picture.height() != start.height) {
        report_.problems.push_back(
            fmt::format("Camera {} sends {} x {} pixels, but its calibration was made for {} x {}: calibrate "
                        "it alone first.",
                        view.id, view.picture.width(), view.picture.height(), start.width, start.height));
        continue;
      }
      LinePicture picture = find_line_pixels(view.picture, task_.field.line_thickness * start.px_per_mm());
      const double window_px = std::max(kMinJointWindowPx, kWindowShare * start.width);
      auto refined = refine_camera(picture, start, curves_, prior_in_force(view.calibration, view.picture),
                                   {window_px, false}, stop_);
      if (stop_.stop_requested()) return false;
      if (!refined) {
        report_.problems.push_back(lines_not_found(view.id));
        continue;
      }
      pictures_.push_back(std::move(picture));
      refined_.push_back(std::move(*refined));
    }
    return refined_.size() == task_.cameras.size();
  }

  /// Chooses the part of the lines to which the field's sizes were measured (the same for all cameras) and
  /// each camera's lens model. Returns false if stopped or if a camera's lines are lost.
  bool fit_model() {
    const CalibrationModel model = choose_model(refined_, field_curves_, task_.measured);
    report_.measured = model.measured;
    const auto curves = field_curves_.measured(model.measured);
    for (std::size_t i = 0; i < refined_.size(); ++i) {
      const CalibrationModel::Lens& lens = model.lenses[i];
      if (curves.data() == curves_.data() && !lens.two_radial) continue;
      auto again =
          refine_again(pictures_[i], lens.camera, curves, refined_[i].prior, {0, lens.two_radial}, stop_);
      if (stop_.stop_requested()) return false;
      if (!again) {
        report_.problems.push_back(lines_not_found(task_.cameras[i].id));
        return false;
      }
      refined_[i] = std::move(*again);
    }
    curves_ = curves;
    return true;
  }

  void fill_report(const JointCalibration& joint) {
    report_.found = true;
    std::vector<LensCamera> published;  // the calibrations that teams get
    for (std::size_t i = 0; i < joint.cameras.size(); ++i) {
      JointCameraReport& out = report_.cameras[i];
      RefinedCamera& refined = refined_[i];
      refined.camera = joint.cameras[i];
      refined.rms_px = rms(residuals_px(refined.camera, refined.sightings));
      const Verdict verdict = judge(refined, pictures_[i], curves_, task_.field);
      const Published wire = publish(refined.camera, task_.cameras[i].calibration, task_.field);
      const LensCamera& now = published.emplace_back(lens_camera(wire.calibration));
      out.found = true;
      out.calibration = wire.calibration;
      out.height_before_mm = in_force_[i].position_mm.z();
      out.height_mm = now.position_mm.z();
      out.lens_rms_mm = wire.rms_mm;
      out.found_share = verdict.found_share;
      out.rms_px = verdict.rms_px;
      const auto places = places_in_view(now, task_.field);
      out.moved_on_floor_mm = moved_mm(in_force_[i], now, places, 0).value_or(0);
      out.moved_at_150_mm = moved_mm(in_force_[i], now, places, kRobotTopsMm).value_or(0);
      add_remarks_on(out, verdict, wire);
    }
    const auto lines_before = disagreements_mm(in_force_, refined_, curves_),
               lines_after = disagreements_mm(published, refined_, curves_);
    report_.overlapping_patches = static_cast<int>(lines_after.size());
    if (!lines_before.empty() && !lines_after.empty())
      report_.on_floor = {rms(lines_before), rms(lines_after)};
    const auto ties_before = distances_mm(in_force_, task_.ties),
               ties_after = distances_mm(published, task_.ties);
    report_.ties = static_cast<int>(ties_after.size());
    if (!ties_before.empty() && !ties_after.empty())
      report_.of_robots = {median(ties_before), median(ties_after)};
    find_neighbours(published);
  }

  void add_remarks_on(const JointCameraReport& camera, const Verdict& verdict, const Published& wire) {
    const std::string who = fmt::format("Camera {}: ", camera.id);
    for (const std::string& problem : problems_of(verdict, "does its calibration fit its position"))
      report_.problems.push_back(who + problem);
    if (std::abs(camera.height_mm - camera.height_before_mm) > kHeightShare * camera.height_before_mm) {
      report_.problems.push_back(
          fmt::format("Camera {} would hang at {:.0f} mm instead of {:.0f} mm: measure its height. If the "
                      "new height is wrong, so are the teams' robot heights.",
                      camera.id, camera.height_mm, camera.height_before_mm));
    }
    if (const auto note = lens_note(wire)) report_.notes.push_back(who + *note);
  }

  /// Finds the cameras that share a line or a tie point with another camera.
  void find_neighbours(std::span<const LensCamera> cameras) {
    has_neighbour_.assign(cameras.size(), false);
    for (const OverlapTie& tie : task_.ties)
      has_neighbour_[tie.camera_a] = has_neighbour_[tie.camera_b] = true;
    for (std::size_t a = 0; a < cameras.size(); ++a) {
      for (std::size_t b = a + 1; b < cameras.size(); ++b) {
        const std::array two{cameras[a], cameras[b]};
        const std::array two_seen{refined_[a], refined_[b]};
        if (disagreements_mm(two, two_seen, curves_).empty()) continue;
        has_neighbour_[a] = has_neighbour_[b] = true;
      }
    }
  }

  void add_remarks() {
    std::vector<std::string>&notes = report_.notes, &problems = report_.problems;
    const bool overlap =
        std::find(has_neighbour_.begin(), has_neighbour_.end(), true) != has_neighbour_.end();
    if (!overlap) {
      problems.push_back(
          "No line and no robot was seen by two cameras, so nothing aligns them. Turn or move them until "
          "their views overlap.");
    } else {
      for (std::size_t i = 0; i < has_neighbour_.size(); ++i) {
        if (has_neighbour_[i]) continue;
        notes.push_back(
            fmt::format("Camera {} sees no line and no robot that another camera sees: it was refined alone.",
                        report_.cameras[i].id));
      }
      if (report_.ties == 0) {
        notes.push_back(
            "No robot was seen by two cameras at the same moment: only lines align the cameras, so positions "
            "of robots' tops may still differ. Put robots where the cameras overlap.");
      }
    }
    if (is_worse(report_.on_floor)) {
      problems.push_back(
          fmt::format("The cameras would disagree by {:.1f} mm on the floor; now they disagree by {:.1f} "
                      "mm: the current calibrations are better.",
                      report_.on_floor->after_mm, report_.on_floor->before_mm));
    }
    if (is_worse(report_.of_robots)) {
      problems.push_back(
          fmt::format("The cameras would disagree by {:.1f} mm about robots; now they disagree by {:.1f} "
                      "mm: are the teams' robot heights right?",
                      report_.of_robots->after_mm, report_.of_robots->before_mm));
    }
    if (report_.measured == LinesMeasured::kToOuterEdge && !task_.measured)
      notes.push_back(outer_edge_note(task_.field));
    report_.accepted = problems.empty();
  }

  const JointTask& task_;
  const std::stop_token& stop_;
  FieldCurves field_curves_;
  std::span<const PaintedCurve> curves_;  // the curves of field_curves_ in use
  JointReport report_;
  std::vector<LensCamera> in_force_;
  std::vector<LinePicture> pictures_;
  std::vector<RefinedCamera> refined_;
  std::vector<bool> has_neighbour_;
};

}  // namespace

JointReport calibrate_jointly(const JointTask& task, const std::stop_token& stop) {
  return JointCalibrator(task, stop).run();
}

}  // namespace sslv
