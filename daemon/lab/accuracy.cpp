// SPDX-License-Identifier: Apache-2.0
#include "lab/accuracy.h"

#include "capture/simulator/simulator_camera.h"
#include "lab/accuracy_bound.h"
#include "lab/accuracy_colors.h"
#include "lab/accuracy_trial.h"
#include "lab/no_sink.h"
#include "pipeline/camera_pipeline.h"
#include "vision/detections_json.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <sstream>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr double kMatchMm = 100;  // as in score()
/// Time at which a film and the swings of the light start; interval between calls of
/// LightFollower::observe().
constexpr double kFilmBeginS = 1200, kLookS = 0.2;

// ---- reliability

void add(std::array<Reliability::Bin, Reliability::kBins>& bins, double confidence, bool right) {
  const auto bin = static_cast<std::size_t>(
      std::clamp(confidence * Reliability::kBins, 0.0, static_cast<double>(Reliability::kBins - 1)));
  ++bins[bin].count;
  if (right) ++bins[bin].right;
}

/// Matches a detection with the nearest true thing that no more confident detection was matched with.
class Matcher {
 public:
  explicit Matcher(const Json& truth) : truth_(truth), taken_(truth.size()) {}

  template <class IsLike>
  const Json* match(double x_mm, double y_mm, const IsLike& is_like) {
    double least = kMatchMm;
    std::size_t best = truth_.size();
    for (std::size_t i = 0; i < truth_.size(); ++i) {
      const double away =
          std::hypot(truth_[i].at("x").get<double>() - x_mm, truth_[i].at("y").get<double>() - y_mm);
      if (taken_[i] || away > least || !is_like(truth_[i])) continue;
      least = away;
      best = i;
    }
    if (best == truth_.size()) return nullptr;
    taken_[best] = true;
    return &truth_[best];
  }

 private:
  const Json& truth_;
  std::vector<bool> taken_;
};

void add_frame(Reliability& reliability, const Frame& frame, const Json& truth) {
  Matcher robots(truth.at("robots")), balls(truth.at("balls"));
  for (const Robot& robot : frame.robots.robots) {
    const char* team = name_of(robot.team);
    const Json* found =
        robots.match(robot.x_mm, robot.y_mm, [&](const Json& other) { return other.at("team") == team; });
    add(reliability.robots, robot.confidence, found != nullptr && found->at("id") == robot.id);
  }
  for (const Ball& ball : frame.balls.balls) {
    const bool right = balls.match(ball.x_mm, ball.y_mm, [](const Json&) { return true; }) != nullptr;
    add(reliability.balls, ball.confidence, right);
  }
}

// ---- bounds

/// Sums the bounds of robots that are fully visible.
class BoundSum {
 public:
  void add(const SimulatedCamera& camera, const SimulatorOptions& source, const BoundPicture& picture,
           const Json& truth, double t_s) {
    if (source.noise_sigma == 0 || source.rolling_shutter_ms > 0) return;
    constexpr int kMoments = 8;  // number of moments in an exposure
    const int moments = source.exposure_ms > 0 ? kMoments : 1;
    std::vector<SimulatedScene> scenes;
    for (int i = 0; i < moments; ++i)
      scenes.push_back(camera.scene_at(t_s + ((i + 0.5) / moments - 0.5) * source.exposure_ms * 1e-3));
    std::vector<BoundPose> poses;
    for (const Json& robot : truth.at("robots")) {
      if (!robot.at("visible").get<bool>()) continue;
      poses.clear();
      for (const SimulatedScene& scene : scenes) {
        for (const SimulatedRobot& there : scene.robots) {
          if (there.id != robot.at("id") || (there.team == Team::kBlue) != (robot.at("team") == "blue"))
            continue;
          poses.push_back({there.x_mm, there.y_mm, there.orientation_rad, there.height_mm});
        }
      }
      const auto bound = robot_bound(picture, poses);
      if (!bound) continue;
      ++robots_;
      position_mm2_ += bound->position_mm * bound->position_mm;
      orientation_rad2_ += bound->orientation_rad * bound->orientation_rad;
    }
  }
  AccuracyBound bound() const {
    if (robots_ == 0) return {};
    const auto n = static_cast<double>(robots_);
    return {robots_, std::sqrt(position_mm2_ / n), std::sqrt(orientation_rad2_ / n) * 180 / std::numbers::pi};
  }

 private:
  std::size_t robots_ = 0;
  double position_mm2_ = 0, orientation_rad2_ = 0;
};

// ---- one trial

/// Detections and truth of all halls, in the format that score() reads.
struct TrialResult {
  std::string detections, truth;
  std::vector<AccuracyRow::Stretch> film;
  std::vector<std::string> problems;  // why no colours were learnt
  BoundSum bounds;
};

/// Returns a table from clicks or a learnt table. If nothing was learnt, adds a problem; the table is empty.
std::shared_ptr<const Lut> table_of(const Trial& trial, const CameraContext& context,
                                    std::vector<std::string>& problems) {
  if (trial.colors == AccuracyColors::kClicked)
    return std::make_shared<const Lut>(lut_from_samples(click(trial, context)));
  LearntColors learnt = learn(trial, context);
  if (!learnt.problem.empty()) {
    const bool one_hall = trial.halls.empty();
    problems.push_back(
        (one_hall ? "not learnt: " : fmt::format("not learnt in hall {}: ", trial.source.hall.seed)) +
        learnt.problem);
  }
  return learnt.lut ? std::move(learnt.lut) : std::make_shared<const Lut>();
}

/// Runs a trial with one hall, and adds its counts to the result.
void run_hall(const Trial& trial, const AccuracyCondition& condition, int frames, TrialResult& result,
              Reliability& reliability) {
  const CameraSettings& settings = trial.config.cameras.front();
  CameraSetup setup;
  setup.pipeline = std::make_shared<Pipeline>(stage_table(), settings.stack, "/stack");
  setup.parameters = setup.pipeline->make_parameters(settings.stages, "/stages");
  setup.context = make_context(trial.config, 0, std::make_shared<Lut>());
  setup.context.adapted_lut = table_of(trial, setup.context, result.problems);

  SimulatedCamera camera(trial.source, {0, *setup.context.scene}, *setup.context.patterns);
  std::vector<std::uint8_t> picture(camera.picture_bytes());
  ImageView view = camera.layout();
  view.data = picture.data();
  if (condition.cut_to_8_bits) view.to_low_bits = 0;
  NoSink sink;
  CameraPipeline pipeline(0, sink, setup);
  LightFollower follower(setup.context.adapted_lut);
  ScoreOptions scoring;
  scoring.min_ball_share = condition.min_ball_share;

  struct {
    std::string detections, truth;
  } stretch;
  const bool is_film = condition.film_hz.has_value();
  const double step_s = is_film ? 1 / *condition.film_hz : kStepS, begin_s = is_film ? kFilmBeginS : kFirstS;
  const int stretch_frames =
      std::max(1, static_cast<int>(std::lround(AccuracyRow::Stretch::kSeconds / step_s)));
  const int look_frames = std::max(1, static_cast<int>(std::lround(kLookS / step_s)));
  for (int i = 0; i < frames; ++i) {
    const double t_s = begin_s + step_s * i;
    const std::string name = fmt::format("{}.{}", trial.source.hall.seed, i);
    camera.draw(t_s, picture.data());
    const Frame& frame = pipeline.process(Image(view, nullptr, nullptr, nullptr), {t_s});
    Json found{{"frame", name}};
    found.update(detections_json(frame.robots, frame.balls));
    const Json expected = camera.truth(name, t_s);
    add_frame(reliability, frame, expected);
    const SimulatorOptions& source = trial.source;
    result.bounds.add(camera, source,
                      {view, *setup.context.scene->camera, *setup.context.patterns, source.blur_sigma_px,
                       source.noise_sigma},
                      expected, t_s);
    stretch.detections += json_text(found) + '\n';
    stretch.truth += json_text(expected) + '\n';
    if (is_film && i % look_frames == 0) {
      follower.observe(condition.follow_light,
                       {t_s, view, *setup.context.scene, *setup.context.patterns, frame.robots.robots});
      if (auto table = follower.new_table()) {
        setup.context.adapted_lut = std::move(table);
        pipeline.change(setup);
      }
    }
    if (i + 1 < frames && (i + 1) % stretch_frames != 0) continue;
    if (is_film) {
      std::istringstream detected(stretch.detections), expected_there(stretch.truth);
      const Score part = score(detected, expected_there, scoring);
      const auto& steps = follower.steps();
      const int first = i / stretch_frames * stretch_frames;
      result.film.push_back(
          {step_s * first, part.robots, part.balls, steps.empty() ? LightChange{} : steps.back().change});
    }
    result.detections += std::exchange(stretch.detections, {});
    result.truth += std::exchange(stretch.truth, {});
  }
}

std::vector<std::string> failures_of(const AccuracyRow& row, const AccuracyLimits& limits) {
  const Score& score = row.score;
  std::vector<std::string> out;
  const auto at_least = [&](std::string_view what, double value, const std::optional<double>& least,
                            std::size_t expected) {
    if (!least) return;
    if (expected == 0) {
      out.push_back(fmt::format("{}: nothing was in sight", what));
    } else if (value < *least) {
      out.push_back(fmt::format("{} {:.4f} is below {}", what, value, *least));
    }
  };
  const auto at_most = [&](std::string_view what, auto value, const auto& most) {
    if (most && value > static_cast<decltype(value)>(*most)) {
      out.push_back(fmt::format("{} {:.4g} is above {}", what, static_cast<double>(value), *most));
    }
  };
  at_least("recall", score.robots.recall(), limits.recall, score.robots.expected);
  at_most("wrong_id", score.robots.wrong_id, limits.wrong_id);
  at_most("invented", score.robots.invented, limits.invented);
  at_most("position_rms_mm", score.robot_position_mm.rms, limits.position_rms_mm);
  at_most("orientation_rms_deg", score.robot_orientation_deg.rms, limits.orientation_rms_deg);
  at_least("ball_recall", score.balls.recall(), limits.ball_recall, score.balls.expected);
  at_least("ball_precision", score.balls.precision(), limits.ball_precision, score.balls.expected);
  at_most("ball_rms_mm", score.ball_position_mm.rms, limits.ball_rms_mm);
  at_most("false_balls_in_100", false_balls_in_100(score), limits.false_balls_in_100);
  if (const auto ratio = row.position_over_bound())
    at_most("position_over_bound", *ratio, limits.position_over_bound);
  if (const auto ratio = row.orientation_over_bound())
    at_most("orientation_over_bound", *ratio, limits.orientation_over_bound);
  for (const AccuracyRow::Stretch& part : row.film) {
    const auto from = fmt::format("from second {:g} on: ", part.begin_s);
    at_least(from + "recall", part.robots.recall(), limits.worst_recall, part.robots.expected);
    at_least(from + "ball_recall", part.balls.recall(), limits.worst_ball_recall, part.balls.expected);
  }
  return out;
}

/// Runs all halls, which share the frames.
AccuracyRow run_trial(const Trial& trial, const AccuracyCondition& condition, int frames,
                      const std::string& format, Reliability& reliability) {
  TrialResult result;
  if (trial.halls.empty()) {
    run_hall(trial, condition, frames, result, reliability);
  } else {
    const int halls = static_cast<int>(trial.halls.size());
    for (const int hall : trial.halls) {
      Trial there = trial;
      for (SimulatorOptions* source : {&there.source, &there.learn_source}) {
        source->hall.seed = hall;
        source->seed = (source->seed + hall) % 1'000'000;  // moves robots and balls
      }
      run_hall(there, condition, (frames + halls - 1) / halls, result, reliability);
    }
  }
  ScoreOptions scoring;
  scoring.min_ball_share = condition.min_ball_share;
  std::istringstream detected(result.detections), expected(result.truth);
  AccuracyRow row{condition.name,
                  format,
                  trial.colors,
                  trial.px_per_mm,
                  score(detected, expected, scoring),
                  std::move(result.problems),
                  std::move(result.film),
                  result.bounds.bound()};
  const auto worse = failures_of(row, trial.limits);
  row.failures.insert(row.failures.end(), worse.begin(), worse.end());
  return row;
}

}  // namespace

double false_balls_in_100(const Score& score) {
  return 100 * static_cast<double>(score.balls.invented) /
         static_cast<double>(std::max<std::size_t>(1, score.frames_compared));
}

std::optional<double> AccuracyRow::position_over_bound() const {
  if (bound.robots == 0 || score.robot_position_mm.count == 0) return std::nullopt;
  return score.robot_position_mm.rms / bound.position_mm;
}

std::optional<double> AccuracyRow::orientation_over_bound() const {
  if (bound.robots == 0 || score.robot_orientation_deg.count == 0) return std::nullopt;
  return score.robot_orientation_deg.rms / bound.orientation_deg;
}

bool AccuracyReport::passed() const {
  return std::all_of(rows.begin(), rows.end(), [](const AccuracyRow& row) { return row.failures.empty(); });
}

AccuracyReport run_accuracy_suite(const AccuracySuite& suite, const AccuracyOptions& options) {
  const auto is_named = [](const std::string& name) {
    return [&](const AccuracyCondition& condition) { return condition.name == name; };
  };
  for (const std::string& name : options.only) {
    if (std::none_of(suite.conditions.begin(), suite.conditions.end(), is_named(name))) {
      std::vector<std::string> known;
      for (const AccuracyCondition& condition : suite.conditions) known.push_back(condition.name);
      throw SettingsError(
          fmt::format("--only: the suite has no condition \"{}\"; known: {}", name, fmt::join(known, ", ")));
    }
  }
  AccuracyReport report;
  for (std::size_t i = 0; i < suite.conditions.size(); ++i) {
    const AccuracyCondition& condition = suite.conditions[i];
    const auto& only = options.only;
    if (!only.empty() && std::find(only.begin(), only.end(), condition.name) == only.end()) continue;
    for (const std::string& format : condition.pixel_formats) {
      Trial trial = trial_of(suite, i, format);
      if (options.colors) trial.colors = *options.colors;
      const int frames = options.frames.value_or(trial.frames);
      report.rows.push_back(run_trial(trial, condition, frames, format, report.reliability));
      options.done(report.rows.back());
    }
  }
  return report;
}

}  // namespace sslv
