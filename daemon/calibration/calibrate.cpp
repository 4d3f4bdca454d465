// SPDX-License-Identifier: Apache-2.0
#include "calibration/calibrate.h"

#include "base/error.h"
#include "calibration/find_pose.h"
#include "calibration/measure_lines.h"
#include "calibration/propose.h"
#include "calibration/publish.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <Eigen/Dense>
#include <fmt/format.h>

namespace sslv {
namespace {

/// A calibration is accepted when its lines lie so well, and so much of them is found; stripes of the picture
/// that are no lines of the field count against it by this factor: a camera that is taken for another always
/// leaves some, and missing lines leave none.
constexpr double kMostRmsPx = 0.6, kLeastFoundShare = 0.52, kUnexplainedWeight = 4;
/// A click further than this from all points that it could mean is wrong: a share of the picture's width, and
/// more than unsteady hands miss.
constexpr double kFarClickShare = 0.012, kFarClickPx = 16;
constexpr double kRobotsMm = 150;

double mm_per_px(const LensCamera& camera) {
  return camera.position_mm.z() / camera.focal_px;
}

bool same_way_round(const LensCamera& a, const LensCamera& b) {
  return (a.rotation * b.rotation.transpose()).trace() > 2;
}

/// Where +x points in the picture.
Eigen::Vector2d plus_x_of(const LensCamera& camera) {
  const Eigen::Vector2d x = camera.rotation.col(0).head<2>();
  return x.norm() > 0 ? Eigen::Vector2d(x.normalized()) : x;
}

Eigen::Vector2d direction_of(PlusX side) {
  switch (side) {
    case PlusX::kRight: return {1, 0};
    case PlusX::kLeft: return {-1, 0};
    case PlusX::kUp: return {0, -1};
    case PlusX::kDown: return {0, 1};
    case PlusX::kUnknown: break;
  }
  return {0, 0};
}

const char* word_of(const Eigen::Vector2d& direction) {
  if (std::abs(direction.x()) > std::abs(direction.y())) return direction.x() > 0 ? "right" : "left";
  return direction.y() > 0 ? "bottom" : "top";
}

struct Solution {
  RefinedCamera refined;
  std::vector<std::size_t> place_of_pixel;
  bool either_way_round = false;  // turned by half a turn it suits the picture as well
};

/// The same sightings with the places that other curves have there.
std::vector<Sighting> on_curves(std::span<const Sighting> sightings, std::span<const PaintedCurve> from,
                                std::span<const PaintedCurve> to) {
  std::vector<Sighting> out(sightings.begin(), sightings.end());
  for (Sighting& sighting : out) {
    const PaintedCurve &old = from[sighting.curve], &now = to[sighting.curve];
    const Eigen::Vector2d place = sighting.place_mm.head<2>();
    Eigen::Vector2d there;
    if (old.is_arc) {
      there = now.from + now.radius_mm * (place - old.from).normalized();
    } else {
      there = now.point((place - old.from).dot(old.direction(0)) * now.length_mm() / old.length_mm());
    }
    sighting.place_mm = {there.x(), there.y(), 0};
  }
  return out;
}

class Calibrator {
 public:
  Calibrator(const MeanPicture& picture, const CalibrationTask& task, const std::stop_token& stop)
      : task_(task),
        stop_(stop),
        // Before the scale is known: about half a field's length across the picture.
        picture_(find_line_pixels(picture, 1.4 * picture.width() * task.field.line_thickness /
                                               std::max(1000, task.field.field_length))),
        prior_(camera_prior(picture.width(), picture.height())),
        outer_(painted_curves(task.field, LinesMeasured::kToOuterEdge)),
        middle_(painted_curves(task.field, LinesMeasured::kToMiddle)) {
    if (task.height_mm) {
      prior_.height_mm = task.height_mm;
      prior_.height_sigma_mm = task.height_sigma_mm;
    }
    if (task.focal_px) {
      prior_.focal_px = *task.focal_px;
      prior_.focal_share = task.focal_share;
    }
  }

  CalibrationReport run() {
    read_clicks();
    std::optional<Solution> best = pixels_.empty() ? propose() : solve(pixels_, prior_);
    const bool all_fits = best && is_acceptable(best->refined) && !has_far_click(best->refined.camera);
    if (!all_fits && pixels_.size() >= 4) {
      auto other = solve_without_one();
      if (other && !(best && best->refined.score() >= other->refined.score())) best = std::move(other);
    }
    if (!best) {
      if (!stop_.stop_requested() && report_.problems.empty()) {
        report_.problems.push_back(
            "The field's lines were not found from these points: click at least four corners or crossings, "
            "well apart, and check the field's sizes.");
      }
      return std::move(report_);
    }
    choose_model(*best);
    fill_report(*best);
    return std::move(report_);
  }

 private:
  std::span<const PaintedCurve> curves() const { return curves(report_.measured); }
  std::span<const PaintedCurve> curves(LinesMeasured measured) const {
    return measured == LinesMeasured::kToOuterEdge ? outer_ : middle_;
  }

  void read_clicks() {
    report_.measured = task_.measured.value_or(LinesMeasured::kToOuterEdge);
    points_ = named_points(curves());
    if (task_.clicks.empty()) {
      places_ = points_;
      return;
    }
    if (task_.clicks.size() < 4) {
      throw SettingsError(
          fmt::format("/points: {} are too few; expected four or more corners or crossings, or none at all",
                      task_.clicks.size()));
    }
    bool all_known = true;
    for (std::size_t i = 0; i < task_.clicks.size(); ++i) {
      const ClickedPoint& click = task_.clicks[i];
      pixels_.push_back(click.pixel);
      if (click.place_mm) {
        places_.push_back({click.name, *click.place_mm});
      } else if (!click.name.empty()) {
        const auto found = std::find_if(points_.begin(), points_.end(),
                                        [&](const NamedPoint& point) { return point.name == click.name; });
        if (found == points_.end()) {
          std::string names;
          for (const NamedPoint& point : points_)
            names += (names.empty() ? "\"" : ", \"") + point.name + "\"";
          throw SettingsError(fmt::format(
              "/points/{}/name: \"{}\" is no point of this field; expected one of {}", i, click.name, names));
        }
        places_.push_back(*found);
      } else {
        all_known = false;
      }
    }
    if (!all_known) places_ = points_;
    names_known_ = all_known;
  }

  std::vector<Eigen::Vector2d> place_list() const {
    std::vector<Eigen::Vector2d> out;
    for (const NamedPoint& place : places_) out.push_back(place.place_mm);
    return out;
  }

  /// How many clicks show what their names say.
  std::size_t agreeing(const PoseGuess& guess) const {
    if (!names_known_ || guess.place_of_pixel.size() != places_.size()) return 0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < places_.size(); ++i) count += guess.place_of_pixel[i] == i ? 1 : 0;
    return count;
  }

  /// Whether a camera has +x where it should be, as far as anything says so.
  bool is_right_way_round(const LensCamera& camera) const {
    const Eigen::Vector2d x = plus_x_of(camera);
    if (task_.plus_x != PlusX::kUnknown) return x.dot(direction_of(task_.plus_x)) > 0;
    if (task_.previous) return same_way_round(camera, lens_camera(*task_.previous));
    return std::abs(x.x()) > std::abs(x.y()) ? x.x() > 0 : x.y() < 0;  // to the right, or upwards
  }

  std::optional<Solution> solve(std::span<const Eigen::Vector2d> pixels, const CameraPrior& prior) {
    const auto places = place_list();
    auto guesses = guess_poses(pixels, places, true, task_.click_sigma_px, picture_, curves(), prior);
    // The best of each way round: turned by half a turn, most of a field's lines fit as well.
    constexpr double kMostBehind = 0.45;
    constexpr std::size_t kMost = 3;
    std::vector<PoseGuess> chosen;
    for (PoseGuess& guess : guesses) {
      if (chosen.size() >= kMost ||
          guesses.front().evidence - guess.evidence > kMostBehind * guesses.front().evidence)
        break;
      const bool is_new = std::none_of(chosen.begin(), chosen.end(), [&](const PoseGuess& other) {
        return same_way_round(guess.camera, other.camera);
      });
      if (is_new) chosen.push_back(guess);
    }
    struct Try {
      Solution solution;
      std::size_t agreeing;
      int score;
    };
    std::vector<Try> tries;
    for (const PoseGuess& guess : chosen) {
      auto refined = refine_camera(picture_, guess.camera, curves(), prior,
                                   {kFirstWindowShare * picture_.width(), false}, stop_);
      if (!refined) continue;
      const int score = refined->score();
      tries.push_back({{std::move(*refined), guess.place_of_pixel, false}, agreeing(guess), score});
    }
    if (tries.empty()) return std::nullopt;
    auto best = std::max_element(tries.begin(), tries.end(),
                                 [](const Try& a, const Try& b) { return a.score < b.score; });
    for (auto other = tries.begin(); other != tries.end(); ++other) {
      constexpr double kAlike = 0.04;
      if (other == best || best->score - other->score > kAlike * best->solution.refined.expected) continue;
      // Both ends of the field look alike: names, or what is known of the camera, must tell.
      const bool by_names = other->agreeing != best->agreeing && task_.plus_x == PlusX::kUnknown;
      const bool other_is_better =
          by_names ? other->agreeing > best->agreeing : is_right_way_round(other->solution.refined.camera);
      if (other_is_better) best = other;
      best->solution.either_way_round = !by_names && task_.plus_x == PlusX::kUnknown && !task_.previous;
    }
    return std::move(best->solution);
  }

  /// With nobody pointing at anything: the best of what the straight lines suggest.
  std::optional<Solution> propose() {
    const Proposal proposal = propose_cameras(picture_, curves(), prior_);
    if (!proposal.problem.empty())
      report_.problems.push_back(proposal.problem + " Click at four corners or crossings instead.");
    std::vector<RefinedCamera> found;
    const double window_px = std::max(8.0, kFarClickShare * picture_.width());
    for (const LensCamera& camera : proposal.cameras) {
      auto refined = refine_camera(picture_, camera, curves(), prior_, {window_px, false}, stop_);
      if (!refined) continue;
      found.push_back(std::move(*refined));
    }
    if (found.empty()) return std::nullopt;
    std::sort(found.begin(), found.end(),
              [&](const RefinedCamera& a, const RefinedCamera& b) { return credit(a) > credit(b); });
    is_clear_proposal_ = std::none_of(found.begin() + 1, found.end(), [&](const RefinedCamera& other) {
      return is_acceptable(other) && !shows_the_same(other.camera, found.front().camera);
    });
    Solution best{std::move(found.front()), {}, false};
    if (same_turned(curves())) {
      best.either_way_round = task_.plus_x == PlusX::kUnknown && !task_.previous;
      if (!is_right_way_round(best.refined.camera)) turn_round(best.refined);
    }
    return best;
  }

  /// Whether two cameras see the same part of the field, or parts that look alike.
  bool shows_the_same(const LensCamera& a, const LensCamera& b) const {
    constexpr double kSameMm = 100;
    const auto same = [&](double sign) {
      for (const double share : {0.2, 0.8}) {
        const Eigen::Vector2d pixel(share * a.width, 0.5 * a.height);
        const auto p = a.unproject(pixel, 0), q = b.unproject(pixel, 0);
        if (!p || !q || (*p - sign * *q).norm() > kSameMm) return false;
      }
      return true;
    };
    return same(1) || (same_turned(curves()) && same(-1));
  }

  /// The same picture with the field turned by half a turn, which looks alike.
  void turn_round(RefinedCamera& refined) const {
    const Eigen::DiagonalMatrix<double, 3> turn(-1, -1, 1);
    const Eigen::Matrix3d rotation = refined.camera.rotation * turn;
    refined.camera.rotation = rotation;
    refined.camera.position_mm = turn * refined.camera.position_mm;
    auto again = refine_again(picture_, refined.camera, curves(), prior_, {0, false}, stop_);
    if (again) refined = std::move(*again);
  }

  /// The place that a click may mean and is nearest to it, and how far that is.
  std::pair<const NamedPoint*, double> nearest_place(const LensCamera& camera,
                                                     const Eigen::Vector2d& click) const {
    std::pair<const NamedPoint*, double> out{nullptr, 1e9};
    for (const NamedPoint& place : places_) {
      const auto pixel = camera.project({place.place_mm.x(), place.place_mm.y(), 0});
      if (pixel && (*pixel - click).norm() < out.second) out = {&place, (*pixel - click).norm()};
    }
    return out;
  }
  static bool is_far(double off_px, const LensCamera& camera) {
    return off_px > std::max(kFarClickPx, kFarClickShare * camera.width);
  }
  bool has_far_click(const LensCamera& camera) const {
    return std::any_of(pixels_.begin(), pixels_.end(), [&](const Eigen::Vector2d& click) {
      return is_far(nearest_place(camera, click).second, camera);
    });
  }

  /// Share of the bright stripes on the field that lie on no line of it.
  double unexplained_share(const LensCamera& camera) const {
    constexpr double kOnLineMm = 50, kAroundMm = 100;
    const double half_x = task_.field.field_length / 2.0 + kAroundMm,
                 half_y = task_.field.field_width / 2.0 + kAroundMm;
    int all = 0, unexplained = 0;
    for (int y = 0; y < picture_.height(); ++y) {
      const float* row = picture_.line.row(y);
      for (int x = 0; x < picture_.width(); ++x) {
        if (row[x] < picture_.least_line) continue;
        const auto place = camera.unproject({x, y}, 0);
        if (!place || std::abs(place->x()) > half_x || std::abs(place->y()) > half_y) continue;
        ++all;
        unexplained += std::none_of(curves().begin(), curves().end(), [&](const PaintedCurve& curve) {
          return curve.distance_mm(*place) < kOnLineMm;
        });
      }
    }
    return all > 0 ? static_cast<double>(unexplained) / all : 0;
  }

  double credit(const RefinedCamera& refined) const {
    return refined.found_share() - kUnexplainedWeight * unexplained_share(refined.camera);
  }
  bool is_acceptable(const RefinedCamera& refined) const {
    return refined.rms_px < kMostRmsPx && credit(refined) > kLeastFoundShare;
  }

  /// One wrong click spoils the start: the one is looked for without which all else fits.
  std::optional<Solution> solve_without_one() {
    CameraPrior prior = prior_;
    prior.focal_share = std::min(prior.focal_share, 0.12);
    std::optional<Solution> best;
    for (std::size_t left_out = 0; left_out < pixels_.size(); ++left_out) {
      std::vector<Eigen::Vector2d> others;
      for (std::size_t i = 0; i < pixels_.size(); ++i) {
        if (i != left_out) others.push_back(pixels_[i]);
      }
      auto found = solve(others, prior);
      if (!found || !is_acceptable(found->refined)) continue;
      if (best && best->refined.score() >= found->refined.score()) continue;
      best = std::move(found);
    }
    return best;
  }

  /// Which edge the sizes were measured to, and whether the lens needs a second radial term: each is taken
  /// when it explains the lines clearly better.
  void choose_model(Solution& solution) {
    RefinedCamera& refined = solution.refined;
    const auto fit_rms = [&](std::span<const Sighting> sightings, bool two_radial) {
      CameraPrior prior = prior_;
      if (two_radial) prior.k2_sigma = 0.3;
      const CameraFit fit = fit_camera(refined.camera, sightings, prior, {3, 40});
      return std::pair(fit.rms, fit.camera);
    };
    const auto here = fit_rms(refined.sightings, false);
    auto best = here;
    if (!task_.measured) {
      const auto other = fit_rms(on_curves(refined.sightings, outer_, middle_), false);
      constexpr double kClearlyBetter = 0.8;
      if (other.first < kClearlyBetter * here.first) {
        report_.measured = LinesMeasured::kToMiddle;
        best = other;
      }
    }
    const auto sightings = on_curves(refined.sightings, curves(started_with()), curves());
    const auto two = fit_rms(sightings, true);
    constexpr double kWorthATerm = 0.9;
    const bool two_radial = two.first < kWorthATerm * best.first;
    if (report_.measured == started_with() && !two_radial) return;
    auto again = refine_again(picture_, two_radial ? two.second : best.second, curves(), prior_,
                              {0, two_radial}, stop_);
    if (again) refined = std::move(*again);
  }
  LinesMeasured started_with() const { return task_.measured.value_or(LinesMeasured::kToOuterEdge); }

  void fill_report(const Solution& solution) {
    const RefinedCamera& refined = solution.refined;
    const LensCamera& camera = refined.camera;
    report_.found = true;
    report_.camera = camera;
    const Published published = publish(camera);
    report_.calibration = published.calibration;
    if (task_.previous) keep_sign(*task_.previous, report_.calibration);
    report_.lens_rms_mm = published.rms_mm;
    report_.lens_worst_mm = published.worst_mm;
    report_.found_share = refined.found_share();
    report_.height_mm = camera.position_mm.z();
    add_line_figures(refined);
    add_click_figures(camera);
    add_errors(refined);
    add_held(refined);
    report_.unexplained_share = unexplained_share(camera);
    compare(camera);
    add_notes(solution);
  }

  /// q and -q are the same rotation: the one that looks like the old one.
  static void keep_sign(const CameraCalibration& old, CameraCalibration& now) {
    if (old.q0 * now.q0 + old.q1 * now.q1 + old.q2 * now.q2 + old.q3 * now.q3 >= 0) return;
    for (double* q : {&now.q0, &now.q1, &now.q2, &now.q3}) *q = -*q;
  }

  void add_line_figures(const RefinedCamera& refined) {
    const double scale_mm = mm_per_px(refined.camera);
    std::map<std::size_t, std::vector<double>> off_px;
    const std::vector<double> off = residuals(refined.camera, refined.sightings);
    double squares = 0;
    for (std::size_t i = 0; i < off.size(); ++i) {
      const double px = std::abs(off[i] * refined.sightings[i].sigma_px);
      off_px[refined.sightings[i].curve].push_back(px);
      squares += px * px;
      report_.worst_px = std::max(report_.worst_px, px);
    }
    report_.rms_px = std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, off.size())));
    report_.rms_mm = scale_mm * report_.rms_px;
    report_.worst_mm = scale_mm * report_.worst_px;

    std::map<std::size_t, int> expected;
    const double px_per_mm = 1 / scale_mm;
    for (const CurvePoint& point :
         points_along(curves(), kPatchPx / px_per_mm, (kPatchPx / 2 + 4) / px_per_mm + 10)) {
      const auto pixel = refined.camera.project(point.place_mm);
      if (pixel && refined.camera.is_in_picture(*pixel, kPatchPx)) ++expected[point.curve];
    }
    for (const auto& [curve, count] : expected) {
      LineFigure& line = report_.line_figures.emplace_back();
      line.name = curves()[curve].name;
      line.expected = count;
      double line_squares = 0;
      for (const double px : off_px[curve]) {
        ++line.patches;
        line_squares += px * px;
        line.worst_px = std::max(line.worst_px, px);
      }
      line.rms_px = line.patches > 0 ? std::sqrt(line_squares / line.patches) : 0;
      line.rms_mm = scale_mm * line.rms_px;
    }
    // Cells of the picture that show the field, and those of them with lines found.
    constexpr int kColumns = 6, kRows = 4;
    std::array<bool, static_cast<std::size_t>(kColumns * kRows)> covered{};
    const LensCamera& camera = refined.camera;
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
        if (!place || std::abs(place->x()) > task_.field.field_length / 2.0 ||
            std::abs(place->y()) > task_.field.field_width / 2.0)
          continue;
        ++with_field;
        with_lines += covered[cell_of(pixel)] ? 1 : 0;
      }
    }
    report_.coverage = with_field > 0 ? static_cast<double>(with_lines) / with_field : 0;
  }

  void add_click_figures(const LensCamera& camera) {
    std::string otherwise;
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      ClickFigure& figure = report_.click_figures.emplace_back();
      figure.pixel = pixels_[i];
      const auto [place, off_px] = nearest_place(camera, pixels_[i]);
      figure.off_px = off_px;
      if (place == nullptr) continue;
      figure.name = place->name;
      figure.place_mm = place->place_mm;
      const auto shown = camera.unproject(pixels_[i], 0);
      figure.off_mm = shown ? (*shown - figure.place_mm).norm() : 0;
      figure.suspect = is_far(off_px, camera);
      if (figure.suspect) {
        report_.problems.push_back(
            fmt::format("Point {} at pixel ({:.0f}, {:.0f}) shows none of the given points: the nearest, {}, "
                        "is {:.0f} px "
                        "away. It was not used; click it again.",
                        i + 1, pixels_[i].x(), pixels_[i].y(), label_of(figure), figure.off_px));
      } else if (names_known_ && figure.name != places_[i].name) {
        otherwise += fmt::format("{}point {} for {}", otherwise.empty() ? "" : ", ", i + 1, label_of(figure));
      }
    }
    for (const NamedPoint& point : points_) {
      const auto pixel = camera.project({point.place_mm.x(), point.place_mm.y(), 0});
      if (pixel && camera.is_in_picture(*pixel))
        report_.control_points.push_back({point.name, *pixel, point.place_mm, 0, 0, false});
    }
    if (!otherwise.empty()) {
      report_.notes.push_back(
          "Some points show others than were named, and were taken for those: " + otherwise + ".");
    }
  }

  static std::string label_of(const ClickFigure& figure) {
    return figure.name.empty() ? fmt::format("({:.0f}, {:.0f}) mm", figure.place_mm.x(), figure.place_mm.y())
                               : figure.name;
  }

  void add_errors(const RefinedCamera& refined) {
    constexpr int kAcross = 16;
    const FieldSize& field = task_.field;
    const double step_mm = static_cast<double>(field.field_length) / kAcross;
    double floor_squares = 0, robot_squares = 0;
    int count = 0;
    const int half_x = kAcross / 2, half_y = static_cast<int>(field.field_width / 2.0 / step_mm);
    for (int j = -half_y; j <= half_y; ++j) {
      for (int i = -half_x; i <= half_x; ++i) {
        const Eigen::Vector2d place(i * step_mm, j * step_mm);
        const auto floor_pixel = refined.camera.project({place.x(), place.y(), 0});
        const auto robot_pixel = refined.camera.project({place.x(), place.y(), kRobotsMm});
        if (!floor_pixel || !robot_pixel || !refined.camera.is_in_picture(*floor_pixel)) continue;
        const ExpectedError& error = report_.error_map.emplace_back(
            ExpectedError{place, expected_error_mm(refined, *floor_pixel, 0),
                          expected_error_mm(refined, *robot_pixel, kRobotsMm)});
        floor_squares += error.on_floor_mm * error.on_floor_mm;
        robot_squares += error.at_150_mm * error.at_150_mm;
        ++count;
      }
    }
    if (count == 0) return;
    report_.expected_on_floor_mm = std::sqrt(floor_squares / count);
    report_.expected_at_150_mm = std::sqrt(robot_squares / count);
  }

  /// What hardly became surer than it was before looking.
  void add_held(const RefinedCamera& refined) {
    const CameraInformation& covariance = refined.covariance;
    const LensCamera& camera = refined.camera;
    const auto sigma = [&](const CameraStep& by) {
      return std::sqrt(std::max(0.0, by.dot(covariance * by)));
    };
    const auto along = [](CameraParam param, double value = 1) {
      CameraStep out = CameraStep::Zero();
      out[param] = value;
      return out;
    };
    constexpr double kHeldShare = 0.5;
    const auto check = [&](const char* name, double after, double before) {
      if (after > kHeldShare * before) report_.held.push_back(name);
    };
    const CameraStep height_by = SteppedCamera(camera, CameraStep::Zero()).height_by_step();
    report_.height_sigma_mm = sigma(height_by);
    check("focal length", sigma(along(kZoom)), prior_.focal_share);
    if (prior_.height_mm) {
      check("height", report_.height_sigma_mm, prior_.height_sigma_mm);
    } else {
      check("height", report_.height_sigma_mm / camera.position_mm.z(), prior_.focal_share);
    }
    check("principal point", std::max(sigma(along(kCenterX)), sigma(along(kCenterY))),
          prior_.center_sigma_px);
    check("distortion", sigma(along(kK1) + along(kZoom, 2 * camera.k1)), prior_.k1_sigma);

    // In units in which each parameter alone is known to 1.
    const auto changes = residuals_by_step(camera, refined.sightings);
    CameraInformation information = changes.transpose() * changes;
    const CameraStep scale = (information.diagonal().array() + 1e-12).rsqrt();
    information = scale.asDiagonal() * information * scale.asDiagonal();
    const auto keep = [&](const std::vector<int>& params) {
      Eigen::MatrixXd out(params.size(), params.size());
      for (std::size_t a = 0; a < params.size(); ++a) {
        for (std::size_t b = 0; b < params.size(); ++b)
          out(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) = information(params[a], params[b]);
      }
      return out;
    };
    std::vector<int> params{kZoom, kCenterX, kCenterY, kK1, kTurnX, kTurnY, kTurnZ, kMoveX, kMoveY, kMoveZ};
    if (camera.k2 != 0) params.push_back(kK2);
    const Eigen::VectorXd eigen = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(keep(params)).eigenvalues();
    report_.condition = std::sqrt(eigen.maxCoeff() / std::max(1e-18, eigen.minCoeff()));
  }

  void compare(const LensCamera& camera) {
    if (!task_.previous) return;
    const LensCamera before = lens_camera(*task_.previous);
    const auto moved_by = [&](double height_mm) {
      double squares = 0;
      int count = 0;
      for (const ExpectedError& error : report_.error_map) {
        const auto pixel = camera.project({error.place_mm.x(), error.place_mm.y(), height_mm});
        const auto place = pixel ? before.unproject(*pixel, height_mm) : std::nullopt;
        if (!place) continue;
        squares += (*place - error.place_mm).squaredNorm();
        ++count;
      }
      return count > 0 ? std::optional(std::sqrt(squares / count)) : std::nullopt;
    };
    report_.moved_on_floor_mm = moved_by(0);
    report_.moved_at_150_mm = moved_by(kRobotsMm);
  }

  void add_notes(const Solution& solution) {
    const RefinedCamera& refined = solution.refined;
    const bool explains = is_acceptable(refined);
    report_.accepted = explains && is_clear_proposal_;
    if (!is_clear_proposal_) {
      report_.problems.push_back(
          "Other parts of the field fit the picture nearly as well: click at four corners or crossings.");
    }
    if (refined.found_share() - kUnexplainedWeight * report_.unexplained_share <= kLeastFoundShare) {
      report_.problems.push_back(fmt::format(
          "{:.0f} % of the lines that should be in view were found, and {:.0f} % of the white stripes on the "
          "field "
          "are none of its lines: do the field's sizes fit this field, and were the right points clicked?",
          100 * refined.found_share(), 100 * report_.unexplained_share));
    }
    if (refined.rms_px >= kMostRmsPx) {
      report_.problems.push_back(fmt::format(
          "The lines lie {:.2f} px off on average (expected less than {}): do the field's sizes fit "
          "this field?",
          refined.rms_px, kMostRmsPx));
    }
    const auto is_held = [&](const char* name) {
      return std::find(report_.held.begin(), report_.held.end(), name) != report_.held.end();
    };
    const bool tops_worse = report_.expected_at_150_mm > 5 * report_.expected_on_floor_mm + 1;
    if (explains && !prior_.height_mm && !task_.focal_px && (is_held("height") || is_held("focal length"))) {
      report_.notes.push_back(
          fmt::format("The camera's height and focal length are not observable from this view (height {:.0f} "
                      "+- {:.0f} mm): "
                      "give the height, measured to 50 mm, or the focal length. Places on the floor are "
                      "expected to be off by "
                      "{:.1f} mm, those of robots' tops by {:.1f} mm.",
                      report_.height_mm, report_.height_sigma_mm, report_.expected_on_floor_mm,
                      report_.expected_at_150_mm));
    } else if (explains && !prior_.height_mm && tops_worse) {
      report_.notes.push_back(
          fmt::format("The camera's height is known to {:.0f} mm only: measured and given, it would make "
                      "places of robots' tops, "
                      "now expected to be off by {:.1f} mm, more exact.",
                      report_.height_sigma_mm, report_.expected_at_150_mm));
    }
    if (is_held("distortion"))
      report_.notes.push_back(
          "The lens' distortion is not observable from this view and held at its usual value.");
    if (report_.lens_rms_mm > 0.5) {
      report_.notes.push_back(
          fmt::format("This lens bends lines in a way that the league's protocol cannot say: what is "
                      "published differs by "
                      "{:.1f} mm on average and {:.1f} mm at most.",
                      report_.lens_rms_mm, report_.lens_worst_mm));
    }
    if (report_.measured == LinesMeasured::kToMiddle && !task_.measured) {
      report_.notes.push_back(
          "The lines lie as if the field's sizes had been measured to their middle, not to their outer edge "
          "as "
          "the rules say.");
    }
    if (solution.either_way_round) {
      report_.notes.push_back(fmt::format(
          "Both ends of the field look alike: the +x half was taken to be at the {} of the picture. "
          "Name the points, or say where +x is.",
          word_of(plus_x_of(refined.camera))));
    }
  }

  static constexpr double kFirstWindowShare = 0.03;

  const CalibrationTask& task_;
  const std::stop_token& stop_;
  LinePicture picture_;
  CameraPrior prior_;
  std::vector<PaintedCurve> outer_, middle_;
  std::vector<NamedPoint> points_, places_;  // all of the field; those that clicks may mean
  bool names_known_ = false, is_clear_proposal_ = true;
  std::vector<Eigen::Vector2d> pixels_;
  CalibrationReport report_;
};

}  // namespace

CalibrationReport calibrate(const MeanPicture& picture, const CalibrationTask& task,
                            const std::stop_token& stop) {
  return Calibrator(picture, task, stop).run();
}

}  // namespace sslv
