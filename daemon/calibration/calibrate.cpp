// SPDX-License-Identifier: Apache-2.0
#include "calibration/calibrate.h"

#include "calibration/choose_model.h"
#include "calibration/describe.h"
#include "calibration/find_pose.h"
#include "calibration/judge.h"
#include "calibration/propose.h"
#include "calibration/way_round.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sslv {
namespace {

struct Solution {
  RefinedCamera refined;
  bool either_way_round = false;  // also fits when rotated by 180 deg; unknown which is right
  bool only_one = true;           // no other part of the field fits the image
};

CameraPrior prior_of(const CalibrationTask& task, const MeanPicture& picture) {
  CameraPrior out = camera_prior(picture.width(), picture.height(), picture.whole);
  if (task.height_mm) {
    out.height_mm = task.height_mm;
    out.height_sigma_mm = task.height_sigma_mm;
  }
  if (task.focal_px) {
    out.focal_px = *task.focal_px;
    out.focal_share = task.focal_share;
  }
  return out;
}

class Calibrator {
 public:
  Calibrator(const MeanPicture& picture, const CalibrationTask& task, const std::stop_token& stop)
      : task_(task),
        stop_(stop),
        field_curves_(task.field),
        curves_(field_curves_.measured(task.measured.value_or(LinesMeasured::kToMiddle))),
        clicks_(read_clicks(task.clicks, named_points(curves_))),
        // The scale is still unknown: assumes that the image's width shows about 0.7 field lengths.
        picture_(find_line_pixels(picture, 1.4 * picture.width() * task.field.line_thickness /
                                               std::max(1000, task.field.field_length))),
        prior_(prior_of(task, picture)) {}

  CalibrationReport run() {
    std::optional<Solution> best = clicks_.pixels.empty() ? propose() : solve_clicks();
    if (best && !stop_.stop_requested()) return finish(std::move(*best));
    CalibrationReport none;
    none.problems = std::move(problems_);
    if (none.problems.empty() && !stop_.stop_requested()) {
      none.problems.emplace_back(
          "The field's lines were not found from these points: click at least four corners or crossings, "
          "well apart, and check the field's sizes.");
    }
    return none;
  }

 private:
  bool all_fits(const std::optional<Solution>& solution) const {
    return solution && verdict(solution->refined).is_acceptable() &&
           !clicks_.has_far_one(solution->refined.camera);
  }

  /// Tries in turn: the clicks as they are; with names that may be swapped; the camera found without clicks,
  /// if all confirm it; all clicks but one. Returns the first that fits, or the best.
  std::optional<Solution> solve_clicks() {
    std::optional<Solution> best = solve(clicks_, prior_, clicks_.names_known);
    const auto keep = [&](std::optional<Solution> other) {
      if (other && !(best && best->refined.score() >= other->refined.score())) best = std::move(other);
    };
    if (!all_fits(best) && clicks_.names_known) keep(solve(clicks_, prior_, false));
    if (all_fits(best)) return best;
    if (auto found = propose(); all_fits(found) && (!clicks_.names_known || turn_to_names(*found))) {
      found->only_one = found->only_one || clicks_.names_known;
      if (found->only_one) return found;
      keep(std::move(found));
    }
    // Four clicks fit many cameras. If one fits more, but not the lines, no click is to blame.
    constexpr std::size_t kFewClicks = 4;
    const bool all_are_near = best && !clicks_.has_far_one(best->refined.camera);
    if (!all_are_near || clicks_.pixels.size() <= kFewClicks) keep(solve_without_one());
    return best;
  }

  /// Number of clicks that the guess assigns to the points named by the user.
  static std::size_t agreeing(const PoseGuess& guess) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < guess.place_of_pixel.size(); ++i)
      count += guess.place_of_pixel[i] == i ? 1 : 0;
    return count;
  }

  /// `by_names`: each click shows the point of its name; otherwise any of `clicks.places`.
  std::optional<Solution> solve(const Clicks& clicks, const CameraPrior& prior, bool by_names) {
    std::vector<Eigen::Vector2d> places;
    for (const NamedPoint& place : clicks.places) places.push_back(place.place_mm);
    auto guesses =
        guess_poses(clicks.pixels, places, by_names, task_.click_sigma_px, picture_, curves_, prior, stop_);
    // Keep the best guess of each orientation: most of a field's lines fit equally well when rotated by 180
    // deg.
    constexpr double kMaxBehind = 0.45;
    constexpr std::size_t kMax = 3;
    std::vector<PoseGuess> chosen;
    for (PoseGuess& guess : guesses) {
      if (chosen.size() >= kMax ||
          guesses.front().evidence - guess.evidence > kMaxBehind * guesses.front().evidence)
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
      auto refined = refine_camera(picture_, guess.camera, curves_, prior,
                                   {kFirstWindowShare * picture_.width(), false}, stop_);
      if (!refined) continue;
      const int score = refined->score();
      tries.push_back({{std::move(*refined)}, clicks.names_known ? agreeing(guess) : 0, score});
    }
    if (tries.empty()) return std::nullopt;
    auto best = std::max_element(tries.begin(), tries.end(),
                                 [](const Try& a, const Try& b) { return a.score < b.score; });
    for (auto other = tries.begin(); other != tries.end(); ++other) {
      constexpr double kAlike = 0.04;
      if (other == best || best->score - other->score > kAlike * best->solution.refined.expected) continue;
      // Both ends of the field look alike: the clicks' names or knowledge about the camera must decide.
      const bool decided = other->agreeing != best->agreeing && task_.plus_x == PlusX::kUnknown;
      const bool other_is_better = decided ? other->agreeing > best->agreeing
                                           : is_right_way_round(other->solution.refined.camera, task_);
      if (other_is_better) best = other;
      best->solution.either_way_round = !decided && task_.plus_x == PlusX::kUnknown && !task_.previous;
    }
    const bool names_decide = clicks.names_known && task_.plus_x == PlusX::kUnknown;
    RefinedCamera& refined = best->solution.refined;
    if (!names_decide && same_turned(curves_)) {
      best->solution.either_way_round = task_.plus_x == PlusX::kUnknown && !task_.previous;
      if (!is_right_way_round(refined.camera, task_)) turn_round(refined);
    }
    return std::move(best->solution);
  }

  /// Without clicks: the best of the cameras that the straight lines suggest.
  std::optional<Solution> propose() {
    const Proposal proposal = propose_cameras(picture_, curves_, prior_, stop_);
    if (!proposal.problem.empty() && clicks_.pixels.empty())
      problems_.push_back(proposal.problem + " Click at four corners or crossings instead.");
    struct Found {
      RefinedCamera refined;
      Verdict verdict;
    };
    std::vector<Found> all;
    const double window_px = std::max(8.0, kFarClickShare * picture_.width());
    for (const LensCamera& camera : proposal.cameras) {
      auto refined = refine_camera(picture_, camera, curves_, prior_, {window_px, false}, stop_);
      if (!refined) continue;
      const Verdict verdict_on_it = verdict(*refined);
      all.push_back({std::move(*refined), verdict_on_it});
    }
    if (all.empty()) return std::nullopt;
    const auto first = std::max_element(all.begin(), all.end(), [](const Found& a, const Found& b) {
      return a.verdict.credit() < b.verdict.credit();
    });
    Solution best;
    best.only_one = std::none_of(all.begin(), all.end(), [&](const Found& other) {
      return other.verdict.is_acceptable() && !shows_the_same(other.refined.camera, first->refined.camera);
    });
    best.refined = std::move(first->refined);
    if (same_turned(curves_)) {
      best.either_way_round = task_.plus_x == PlusX::kUnknown && !task_.previous;
      if (!is_right_way_round(best.refined.camera, task_)) turn_round(best.refined);
    }
    return best;
  }

  /// Turns the field round if the clicks' names demand it. Returns whether the camera then fits and shows
  /// them.
  bool turn_to_names(Solution& found) const {
    if (!shows_names(found.refined.camera)) {
      if (task_.plus_x != PlusX::kUnknown || !same_turned(curves_)) return false;
      turn_round(found.refined);
    }
    found.either_way_round = false;
    return all_fits(found) && shows_names(found.refined.camera);
  }

  bool shows_names(const LensCamera& camera) const {
    for (std::size_t i = 0; i < clicks_.pixels.size(); ++i) {
      const Eigen::Vector2d& place = clicks_.places[i].place_mm;
      const auto seen = camera.project({place.x(), place.y(), 0});
      if (!seen || (*seen - clicks_.pixels[i]).norm() > clicks_.far_px(camera)) return false;
    }
    return true;
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
    return same(1) || (same_turned(curves_) && same(-1));
  }

  /// Refits the camera to the field rotated by 180 deg, which looks the same.
  void turn_round(RefinedCamera& refined) const {
    auto again = refine_again(picture_, turned_round(refined.camera), curves_, prior_, {}, stop_);
    if (again) refined = std::move(*again);
  }

  Verdict verdict(const RefinedCamera& refined) const {
    return judge(refined, picture_, curves_, task_.field);
  }

  /// Leaves out each click in turn, because one wrong click spoils the initial guess. Returns the best
  /// acceptable fit: with the clicks' names, or else in any order, because names may be swapped as well.
  std::optional<Solution> solve_without_one() {
    CameraPrior prior = prior_;
    prior.focal_share = std::min(prior.focal_share, 0.12);
    std::optional<Solution> best;
    for (const bool by_names : {true, false}) {
      if (by_names && !clicks_.names_known) continue;
      for (std::size_t left_out = 0; left_out < clicks_.pixels.size(); ++left_out) {
        if (stop_.stop_requested()) return std::nullopt;
        Clicks others = clicks_;
        const auto at = static_cast<std::ptrdiff_t>(left_out);
        others.pixels.erase(others.pixels.begin() + at);
        if (others.names_known) {
          std::rotate(others.places.begin() + at, others.places.begin() + at + 1, others.places.end());
          if (by_names) others.places.pop_back();
        }
        auto found = solve(others, prior, by_names);
        if (!found || !verdict(found->refined).is_acceptable()) continue;
        if (!by_names && others.has_far_one(found->refined.camera)) continue;
        if (best && best->refined.score() >= found->refined.score()) continue;
        best = std::move(found);
      }
      if (best) break;
    }
    return best;
  }

  /// Another usual field that the image may show as well, at another scale: the defence areas of both
  /// divisions have the same shape. Null: none, or the height decides, or the fit is poor.
  const FieldPreset* find_other_scale(const RefinedCamera& refined) const {
    if (prior_.height_mm || !verdict(refined).is_acceptable()) return nullptr;
    const FieldSize& ours = task_.field;
    for (const FieldPreset& preset : field_presets()) {
      const FieldSize& theirs = preset.size;
      const double scale =
          static_cast<double>(theirs.penalty_area_depth) / std::max(1, ours.penalty_area_depth);
      const double by_width =
          static_cast<double>(theirs.penalty_area_width) / std::max(1, ours.penalty_area_width);
      constexpr double kSameScale = 0.02;
      if (std::abs(scale - 1) < kSameScale || std::abs(by_width / scale - 1) > kSameScale) continue;
      const FieldCurves curves(theirs);
      for (const int side : {-1, 1}) {
        const Eigen::Vector3d our_goal(side * ours.field_length / 2.0, 0, 0),
            their_goal(side * theirs.field_length / 2.0, 0, 0);
        LensCamera camera = refined.camera;
        camera.position_mm = their_goal + scale * (camera.position_mm - our_goal);
        const auto other = refine_again(picture_, camera, curves.to_middle, prior_, {}, stop_);
        if (other && judge(*other, picture_, curves.to_middle, theirs).is_acceptable()) return &preset;
      }
    }
    return nullptr;
  }

  CalibrationReport finish(Solution solution) {
    const CalibrationModel model = choose_model({&solution.refined, 1}, field_curves_, task_.measured);
    const CalibrationModel::Lens& lens = model.lenses.front();
    const auto curves = field_curves_.measured(model.measured);
    if (curves.data() != curves_.data() || lens.two_radial) {
      auto again = refine_again(picture_, lens.camera, curves, prior_, {0, lens.two_radial}, stop_);
      if (again) solution.refined = std::move(*again);
    }
    curves_ = curves;
    clicks_ = read_clicks(task_.clicks, named_points(curves_));
    CalibrationReport out = describe({task_, clicks_, prior_, curves_, model.measured, solution.refined,
                                      verdict(solution.refined), solution.either_way_round, solution.only_one,
                                      find_other_scale(solution.refined)});
    out.problems.insert(out.problems.begin(), problems_.begin(), problems_.end());
    return out;
  }

  static constexpr double kFirstWindowShare = 0.03;

  const CalibrationTask& task_;
  const std::stop_token& stop_;
  FieldCurves field_curves_;
  std::span<const PaintedCurve> curves_;  // the curves of field_curves_ in use
  Clicks clicks_;
  LinePicture picture_;
  CameraPrior prior_;
  std::vector<std::string> problems_;
};

}  // namespace

CalibrationReport calibrate(const MeanPicture& picture, const CalibrationTask& task,
                            const std::stop_token& stop) {
  return Calibrator(picture, task, stop).run();
}

}  // namespace sslv
