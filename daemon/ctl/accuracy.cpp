// SPDX-License-Identifier: Apache-2.0
#include "ctl/accuracy.h"

#include "base/params_json.h"
#include "capture/simulator/simulator.h"
#include "capture/simulator/simulator_camera.h"
#include "capture/simulator/simulator_random.h"
#include "colors/learn_colors.h"
#include "config.h"
#include "ctl/no_sink.h"
#include "detections_json.h"
#include "image/pixel_format_names.h"
#include "pipeline/camera_pipeline.h"
#include "settings/store.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <sstream>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr double kMatchMm = 100;                    // as score()
constexpr double kFirstS = 1000, kStepS = 7.3;      // so far apart that pictures have little in common
constexpr double kFilmBeginS = 1200, kLookS = 0.2;  // swings begin; the light is looked at

// ---- conditions

/// A condition in one pixel format, with all that its names stand for.
struct Trial {
  Config config;  // of one camera
  SimulatorOptions source;
  double px_per_mm;
  int frames;
  AccuracyLimits limits;
};

/// On the floor in the middle of the picture.
double px_per_mm_of(const CameraCalibration& c) {
  const Eigen::Vector2d middle(c.pixel_image_width / 2.0, c.pixel_image_height / 2.0);
  return 1 / std::sqrt(CameraModel(c).mm2_per_px(middle, 0));
}

/// The same camera with a sensor of other pixels.
CameraCalibration scaled(CameraCalibration c, double scale) {
  const auto even = [&](int size) { return 2 * static_cast<int>(std::lround(size * scale / 2)); };
  c.focal_length *= scale;
  c.principal_point_x = (c.principal_point_x + 0.5) * scale - 0.5;
  c.principal_point_y = (c.principal_point_y + 0.5) * scale - 0.5;
  c.pixel_image_width = even(c.pixel_image_width);
  c.pixel_image_height = even(c.pixel_image_height);
  return c;
}

AccuracyField field_named(const AccuracySuite& suite, const std::string& name, const std::string& path) {
  std::string known;
  for (const auto& [key, value] : suite.named_fields.items()) {
    if (key == name) {
      const std::string field_path = "/fields/" + key;
      auto field = params_from_json<AccuracyField>(value, field_path);
      CameraModel(field.calibration, field_path + "/calibration");
      for (const auto size : {field.calibration.pixel_image_width, field.calibration.pixel_image_height}) {
        if (size == 0) {
          throw SettingsError(field_path +
                              "/calibration: pixel_image_width and pixel_image_height are missing; they are "
                              "the size of the pictures");
        }
      }
      return field;
    }
    known += (known.empty() ? "" : ", ") + key;
  }
  throw SettingsError(fmt::format("{}: no field \"{}\"; known: {}", path, name, known));
}

Json merged(Json below, const Json& above) {
  below.merge_patch(above);
  return below;
}

Trial trial_of(const AccuracySuite& suite, std::size_t index, const std::string& pixel_format) {
  const AccuracyCondition& condition = suite.conditions[index];
  const std::string path = "/conditions/" + std::to_string(index);
  AccuracyField field = field_named(suite, condition.field, path + "/field");
  if (condition.px_per_mm) {
    field.calibration = scaled(field.calibration, *condition.px_per_mm / px_per_mm_of(field.calibration));
  }
  Trial out;
  out.px_per_mm = px_per_mm_of(field.calibration);
  out.frames = condition.frames.value_or(field.frames);
  out.limits = params_from_json<AccuracyLimits>(merged(suite.must, condition.must), path + "/must");
  out.source = simulator_options(
      merged(merged(suite.source, condition.source), Json{{"width", field.calibration.pixel_image_width},
                                                          {"height", field.calibration.pixel_image_height},
                                                          {"pixel_format", pixel_format}}),
      path + "/source");

  out.config.field = field.size;
  out.config.teams.yellow.robot_height = out.config.teams.blue.robot_height = condition.robot_height;
  read_params(out.config.teams, condition.teams, path + "/teams");
  CameraSettings& camera = out.config.cameras.emplace_back();
  camera.calibration = field.calibration;
  camera.stages =
      complete_stage_settings(stage_table(), merged(suite.stages, condition.stages), path + "/stages");
  return out;
}

void check_pixel_formats(const AccuracyCondition& condition, const std::string& path) {
  for (std::size_t i = 0; i < condition.pixel_formats.size(); ++i) {
    const auto format = pixel_format_named(condition.pixel_formats[i]);
    if (format && *format != PixelFormat::kMono8) continue;
    refuse(fmt::format("{}/pixel_formats/{}", path, i), condition.pixel_formats[i],
           "a pixel format with colours, such as \"uyvy\", \"rgb24\" or \"bayer_rg8\"");
  }
}

// ---- the admin who shows the colours

/// A place in a training picture where somebody may click to show a colour.
struct Place {
  std::size_t picture;
  Label label;
  Eigen::Vector2d pixel;
  double radius_px;  // of what is clicked at
};

struct TrainingPicture {
  std::vector<std::uint8_t> bytes;
  ImageView view;
  Json truth;
};

/// Mean colour of the 3 x 3 pixels, or the 2 x 2 Bayer quads, around a place.
Rgb color_around(const ImageView& view, const Eigen::Vector2d& pixel) {
  double r = 0, g = 0, b = 0;
  int count = 0;
  const auto add = [&](double red, double green, double blue) {
    r += red;
    g += green;
    b += blue;
    ++count;
  };
  if (is_bayer(view.format)) {
    const bool red_below = view.format == PixelFormat::kBayerGb8 || view.format == PixelFormat::kBayerBg8;
    const bool red_right = view.format == PixelFormat::kBayerGr8 || view.format == PixelFormat::kBayerBg8;
    // The corner between four quads that is nearest.
    const int x = std::clamp(2 * static_cast<int>(std::lround((pixel.x() + 0.5) / 2)), 2, view.width - 2);
    const int y = std::clamp(2 * static_cast<int>(std::lround((pixel.y() + 0.5) / 2)), 2, view.height - 2);
    for (int qy = y - 2; qy <= y; qy += 2) {
      for (int qx = x - 2; qx <= x; qx += 2) {
        const auto sample = [&](bool below, bool right) {
          return static_cast<double>(view.row(qy + (below ? 1 : 0))[qx + (right ? 1 : 0)]);
        };
        add(sample(red_below, red_right), (sample(red_below, !red_right) + sample(!red_below, red_right)) / 2,
            sample(!red_below, !red_right));
      }
    }
  } else {
    const int x = std::clamp(static_cast<int>(std::lround(pixel.x())), 1, view.width - 2);
    const int y = std::clamp(static_cast<int>(std::lround(pixel.y())), 1, view.height - 2);
    for (int py = y - 1; py <= y + 1; ++py) {
      for (int px = x - 1; px <= x + 1; ++px) {
        if (is_yuv422(view.format)) {
          const int luma = view.format == PixelFormat::kUyvy ? 1 : 0, chroma = 1 - luma;
          const std::uint8_t* pair = view.row(py) + px / 2 * 4;
          const double bright = pair[luma + px % 2 * 2], u = pair[chroma] - 128.0,
                       v = pair[chroma + 2] - 128.0;
          add(bright + 1.402 * v, bright - 0.344136 * u - 0.714136 * v, bright + 1.772 * u);
        } else {
          const std::uint8_t* p = view.row(py) + 3 * px;
          const int red = view.format == PixelFormat::kRgb24 ? 0 : 2;
          add(p[red], p[1], p[2 - red]);
        }
      }
    }
  }
  const auto byte = [&](double sum) {
    return static_cast<std::uint8_t>(std::clamp(std::lround(sum / count), 0L, 255L));
  };
  return {byte(r), byte(g), byte(b)};
}

/// Where an admin sees things to click at in one picture.
class PlaceFinder {
 public:
  PlaceFinder(const Scene& scene, const PatternTable& patterns, std::size_t picture, const Json& truth,
              SimulatorRandom& random)
      : scene_(scene), patterns_(patterns), picture_(picture), truth_(truth), random_(random) {}

  std::vector<Place> find() {
    for (const Json& robot : truth_.at("robots")) {
      if (robot.at("visible")) add_robot(robot);
    }
    for (const Json& ball : truth_.at("balls")) {
      if (!ball.at("visible")) continue;
      const double radius_mm = scene_.field.ball_radius;
      add(label::kOrange, {ball.at("x"), ball.at("y"), radius_mm}, radius_mm);
    }
    add_lines();
    add_carpet();
    return std::move(places_);
  }

 private:
  void add(Label label, const Eigen::Vector3d& point_mm, double radius_mm) {
    constexpr double kMarginPx = 4;
    const CameraCalibration& c = scene_.camera->calibration();
    const auto pixel = scene_.camera->project(point_mm);
    if (!pixel || pixel->x() < kMarginPx || pixel->y() < kMarginPx ||
        pixel->x() > c.pixel_image_width - kMarginPx || pixel->y() > c.pixel_image_height - kMarginPx) {
      return;
    }
    const double mm_per_px = std::sqrt(scene_.camera->mm2_per_px(*pixel, point_mm.z()));
    places_.push_back({picture_, label, *pixel, radius_mm / mm_per_px});
  }

  void add_robot(const Json& robot) {
    const int id = robot.at("id");
    const auto code = std::find_if(patterns_.codes.begin(), patterns_.codes.end(),
                                   [&](const PatternTable::Code& known) { return known.id == id; });
    const double turn_rad = robot.at("orientation");
    const auto on_top = [&](double x_mm, double y_mm) {
      return Eigen::Vector3d(
          robot.at("x").get<double>() + std::cos(turn_rad) * x_mm - std::sin(turn_rad) * y_mm,
          robot.at("y").get<double>() + std::sin(turn_rad) * x_mm + std::cos(turn_rad) * y_mm,
          robot.at("height"));
    };
    add(robot.at("team") == "blue" ? label::kBlue : label::kYellow, on_top(0, 0),
        patterns_.center_diameter_mm / 2);
    for (std::size_t i = 0; i < patterns_.dots.size(); ++i) {
      const PatternDot& dot = patterns_.dots[i];
      add(code->colors[i], on_top(dot.x_mm, dot.y_mm), dot.diameter_mm / 2);
    }
    // Where the league's pattern leaves most room.
    for (const double y_mm : {-45.0, 45.0}) add(label::kBlack, on_top(0, y_mm), patterns_.gap_mm);
  }

  void add_lines() {
    constexpr double kStepMm = 150;
    for (const FieldLine& line : field_lines(scene_.field)) {
      const auto add_if_free = [&](double x_mm, double y_mm) {
        if (is_free({x_mm, y_mm})) add(label::kWhite, {x_mm, y_mm, 0}, line.thickness / 2);
      };
      const double steps = std::ceil(std::hypot(line.x2 - line.x1, line.y2 - line.y1) / kStepMm);
      for (double i = 0; i <= steps; ++i) {
        add_if_free(line.x1 + (line.x2 - line.x1) * i / steps, line.y1 + (line.y2 - line.y1) * i / steps);
      }
    }
  }

  /// In the corners, at the sides and in the middle.
  void add_carpet() {
    constexpr int kAttempts = 100;
    constexpr double kReach = 0.06;  // of the picture's size
    const CameraCalibration& c = scene_.camera->calibration();
    const double lines_mm = 30 + scene_.field.line_thickness / 2.0;
    for (const double across : {0.08, 0.5, 0.92}) {
      for (const double down : {0.08, 0.5, 0.92}) {
        for (int i = 0; i < kAttempts; ++i) {
          const auto point =
              scene_.camera->unproject({(across + random_.uniform(-kReach, kReach)) * c.pixel_image_width,
                                        (down + random_.uniform(-kReach, kReach)) * c.pixel_image_height},
                                       0);
          if (!point || !on_carpet(*point) || !is_free(*point) || to_line_mm(*point) < lines_mm) continue;
          add(label::kField, {point->x(), point->y(), 0}, 0);
          break;
        }
      }
    }
  }

  bool on_carpet(const Eigen::Vector2d& p) const {
    const FieldSize& f = scene_.field;
    return std::abs(p.x()) < f.field_length / 2.0 + f.boundary_width_goal_line - 30 &&
           std::abs(p.y()) < f.field_width / 2.0 + f.boundary_width - 30;
  }

  /// Nothing stands on the floor there, or between there and the camera.
  bool is_free(const Eigen::Vector2d& p) const {
    const Eigen::Vector3d floor(p.x(), p.y(), 0), eye = scene_.camera->position_mm();
    for (const Json& robot : truth_.at("robots")) {
      const Eigen::Vector3d seen_through = floor + robot.at("height").get<double>() / eye.z() * (eye - floor);
      const double away = std::hypot(seen_through.x() - robot.at("x").get<double>(),
                                     seen_through.y() - robot.at("y").get<double>());
      if (away < scene_.field.max_robot_radius + 40) return false;
    }
    return std::none_of(truth_.at("balls").begin(), truth_.at("balls").end(), [&](const Json& ball) {
      return std::hypot(p.x() - ball.at("x").get<double>(), p.y() - ball.at("y").get<double>()) < 80;
    });
  }

  double to_line_mm(const Eigen::Vector2d& p) const {
    double least = std::numeric_limits<double>::infinity();
    for (const FieldLine& line : field_lines(scene_.field)) {
      const Eigen::Vector2d from(line.x1, line.y1), step(line.x2 - line.x1, line.y2 - line.y1);
      const double along = std::clamp((p - from).dot(step) / step.squaredNorm(), 0.0, 1.0);
      least = std::min(least, (p - from - along * step).norm());
    }
    for (const FieldArc& arc : field_arcs(scene_.field)) {
      least = std::min(least, std::abs(std::hypot(p.x() - arc.x, p.y() - arc.y) - arc.radius));
    }
    return least;
  }

  const Scene& scene_;
  const PatternTable& patterns_;
  std::size_t picture_;
  const Json& truth_;
  SimulatorRandom& random_;
  std::vector<Place> places_;
};

/// `count` of the places, each as far from those before as can be; all of them again when there are fewer.
std::vector<Place> spread(const std::vector<Place>& places, std::size_t count) {
  std::vector<Place> out;
  std::vector<double> away_px(places.size(), std::numeric_limits<double>::infinity());
  while (!places.empty() && out.size() < count) {
    const auto farthest = std::max_element(away_px.begin(), away_px.end());
    if (*farthest == 0) std::fill(away_px.begin(), away_px.end(), std::numeric_limits<double>::infinity());
    out.push_back(places[static_cast<std::size_t>(farthest - away_px.begin())]);
    for (std::size_t i = 0; i < places.size(); ++i) {
      away_px[i] = std::min(away_px[i], (places[i].pixel - out.back().pixel).norm());
    }
  }
  return out;
}

/// The same conditions with other pictures.
SimulatorOptions other_pictures(SimulatorOptions options) {
  constexpr int kOtherSeed = 500'000;
  options.seed = (options.seed + kOtherSeed) % 1'000'000;
  return options;
}

void take(SimulatedCamera& camera, int number, TrainingPicture& picture) {
  const double t_s = kFirstS + kStepS * number;
  picture.bytes.resize(camera.picture_bytes());
  camera.draw(t_s, picture.bytes.data());
  picture.view = camera.layout();
  picture.view.data = picture.bytes.data();
  picture.truth = camera.truth("", t_s);
}

/// A table without a click; with a problem when nothing was learnt.
LearntColors learn(const Trial& trial, const World& world) {
  constexpr int kPictures = 3;
  SimulatedCamera camera(other_pictures(trial.source), {0, *world.scene}, *world.patterns);
  std::array<TrainingPicture, kPictures> pictures;
  LearnTask task{{}, *world.scene, *world.patterns};
  for (int i = 0; i < kPictures; ++i) {
    TrainingPicture& picture = pictures[static_cast<std::size_t>(i)];
    take(camera, i, picture);
    task.frames.push_back(picture.view);
  }
  return learn_colors(task);
}

std::vector<ColorSample> click(const Trial& trial, const World& world) {
  constexpr std::size_t kPictures = 2, kClicks = 8;
  SimulatorOptions options = other_pictures(trial.source);
  options.balls = std::max(options.balls, 6);                             // an admin has more than one
  options.hidden_balls = options.covered_dots = options.distractors = 0;  // knows what to click at
  options.light_swing.clear(), options.cast_swing.clear();
  SimulatedCamera camera(options, {0, *world.scene}, *world.patterns);
  SimulatorRandom random(static_cast<std::uint64_t>(options.seed));

  std::array<TrainingPicture, kPictures> pictures;
  std::vector<Place> places;
  for (std::size_t i = 0; i < kPictures; ++i) {
    TrainingPicture& picture = pictures[i];
    take(camera, static_cast<int>(i), picture);
    const auto more = PlaceFinder(*world.scene, *world.patterns, i, picture.truth, random).find();
    places.insert(places.end(), more.begin(), more.end());
  }

  std::vector<ColorSample> samples;
  for (std::size_t i = 0; i < label::kCount; ++i) {
    std::vector<Place> same;
    std::copy_if(places.begin(), places.end(), std::back_inserter(same),
                 [&](const Place& place) { return place.label == i; });
    for (const Place& place : spread(same, kClicks)) {
      const double angle = random.angle(), off_px = place.radius_px / 4 * std::sqrt(random.uniform(0, 1));
      samples.push_back({place.label, color_around(pictures[place.picture].view,
                                                   place.pixel + off_px * Eigen::Vector2d(std::cos(angle),
                                                                                          std::sin(angle)))});
    }
  }
  return samples;
}

// ---- reliability

void add(std::array<Reliability::Bin, Reliability::kBins>& bins, double confidence, bool right) {
  const auto bin = static_cast<std::size_t>(
      std::clamp(confidence * Reliability::kBins, 0.0, static_cast<double>(Reliability::kBins - 1)));
  ++bins[bin].count;
  if (right) ++bins[bin].right;
}

/// Finds what a detection stands for: the nearest true thing that no surer detection stood for.
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
    const char* team = robot.team == Team::kBlue ? "blue" : "yellow";
    const Json* found =
        robots.match(robot.x_mm, robot.y_mm, [&](const Json& other) { return other.at("team") == team; });
    add(reliability.robots, robot.confidence, found != nullptr && found->at("id") == robot.id);
  }
  for (const Ball& ball : frame.balls.balls) {
    const bool right = balls.match(ball.x_mm, ball.y_mm, [](const Json&) { return true; }) != nullptr;
    add(reliability.balls, ball.confidence, right);
  }
}

// ---- one trial

struct TrialResult {
  Score score;
  std::vector<AccuracyRow::Stretch> film;
  std::string problem;  // why no colours were learnt
};

TrialResult run_trial(const Trial& trial, const AccuracyCondition& condition, int frames,
                      AccuracyColors colors, Reliability& reliability) {
  TrialResult out;
  const CameraSettings& settings = trial.config.cameras.front();
  CameraSetup setup;
  setup.pipeline = std::make_shared<Pipeline>(stage_table(), settings.stack, "/stack");
  setup.parameters = setup.pipeline->make_parameters(settings.stages, "/stages");
  setup.world = make_world(trial.config, 0, std::make_shared<Lut>());
  if (colors == AccuracyColors::kClicked) {
    setup.world.lut = std::make_shared<const Lut>(lut_from_samples(click(trial, setup.world)));
  } else {
    LearntColors learnt = learn(trial, setup.world);
    out.problem = learnt.problem;
    if (learnt.lut) setup.world.lut = std::move(learnt.lut);
  }

  SimulatedCamera camera(trial.source, {0, *setup.world.scene}, *setup.world.patterns);
  std::vector<std::uint8_t> picture(camera.picture_bytes());
  ImageView view = camera.layout();
  view.data = picture.data();
  NoSink sink;
  CameraPipeline pipeline(0, sink, setup);
  LightFollower follower(setup.world.lut);
  ScoreOptions scoring;
  scoring.min_ball_share = condition.min_ball_share;

  std::string detections, truth;
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
    camera.draw(t_s, picture.data());
    const Frame& frame = pipeline.process(Image(view, nullptr, nullptr, nullptr), {t_s});
    Json found{{"frame", std::to_string(i)}};
    found.update(detections_json(frame.robots, frame.balls));
    const Json expected = camera.truth(std::to_string(i), t_s);
    add_frame(reliability, frame, expected);
    stretch.detections += found.dump() + '\n';
    stretch.truth += expected.dump() + '\n';
    if (is_film && i % look_frames == 0) {
      follower.observe(condition.follow_light,
                       {t_s, view, *setup.world.scene, *setup.world.patterns, frame.robots.robots});
      if (auto table = follower.new_table()) {
        setup.world.lut = std::move(table);
        pipeline.change(setup);
      }
    }
    if (i + 1 < frames && (i + 1) % stretch_frames != 0) continue;
    if (is_film) {
      std::istringstream detected(stretch.detections), expected_there(stretch.truth);
      const Score part = score(detected, expected_there, scoring);
      const auto& steps = follower.steps();
      out.film.push_back({step_s * (i / stretch_frames * stretch_frames), part.robots, part.balls,
                          steps.empty() ? LightChange{} : steps.back().change});
    }
    detections += std::exchange(stretch.detections, {});
    truth += std::exchange(stretch.truth, {});
  }
  std::istringstream detected(detections), expected(truth);
  out.score = score(detected, expected, scoring);
  return out;
}

std::vector<std::string> failures_of(const Score& score, const std::vector<AccuracyRow::Stretch>& film,
                                     const AccuracyLimits& limits) {
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
  for (const AccuracyRow::Stretch& part : film) {
    const auto from = fmt::format("from second {:g} on: ", part.begin_s);
    at_least(from + "recall", part.robots.recall(), limits.worst_recall, part.robots.expected);
    at_least(from + "ball_recall", part.balls.recall(), limits.worst_ball_recall, part.balls.expected);
  }
  return out;
}

// ---- text

using Table = std::vector<std::vector<std::string>>;  // the first row is the head

/// Columns before `numbers_from` hold text.
std::string table_text(const Table& table, std::size_t numbers_from, bool markdown) {
  std::vector<std::size_t> widths(table.front().size());
  for (const auto& row : table) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string out;
  for (const auto& row : table) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      const bool is_number = i >= numbers_from;
      if (markdown) {
        out += (i == 0 ? "| " : " | ") + row[i];
      } else {
        if (i > 0) out += "  ";
        out +=
            is_number ? fmt::format("{:>{}}", row[i], widths[i]) : fmt::format("{:<{}}", row[i], widths[i]);
      }
    }
    if (!markdown) out.erase(out.find_last_not_of(' ') + 1);
    out += markdown ? " |\n" : "\n";
    if (markdown && &row == &table.front()) {
      for (std::size_t i = 0; i < row.size(); ++i) out += i >= numbers_from ? "|---:" : "|---";
      out += "|\n";
    }
  }
  return out;
}

std::string number_or_dash(std::size_t count, double value, int digits) {
  return count == 0 ? "-" : fmt::format("{:.{}f}", value, digits);
}

Json json_of(const std::array<Reliability::Bin, Reliability::kBins>& bins) {
  Json out = Json::array();
  for (const Reliability::Bin& bin : bins) out.push_back({{"count", bin.count}, {"right", bin.right}});
  return out;
}

/// How it went on in films.
Table film_table(const AccuracyReport& report) {
  Table table{{"condition", "format", "second", "robots", "recall", "wrong id", "false", "balls",
               "ball recall", "red", "green", "blue", "darkest", "brightest"}};
  for (const AccuracyRow& row : report.rows) {
    for (const AccuracyRow::Stretch& part : row.film) {
      const auto [r, g, b] = part.change.gain;
      table.push_back({row.condition, row.pixel_format, fmt::format("{:g}", part.begin_s),
                       std::to_string(part.robots.expected),
                       number_or_dash(part.robots.expected, part.robots.recall(), 4),
                       std::to_string(part.robots.wrong_id), std::to_string(part.robots.invented),
                       std::to_string(part.balls.expected),
                       number_or_dash(part.balls.expected, part.balls.recall(), 4), fmt::format("{:.2f}", r),
                       fmt::format("{:.2f}", g), fmt::format("{:.2f}", b),
                       fmt::format("{:.2f}", part.change.darkest_area),
                       fmt::format("{:.2f}", part.change.brightest_area)});
    }
  }
  return table;
}

}  // namespace

AccuracySuite read_accuracy_suite(const std::string& file) {
  const Json json = read_json_file(file);
  try {
    auto suite = params_from_json<AccuracySuite>(json, "");
    for (std::size_t i = 0; i < suite.conditions.size(); ++i) {
      const AccuracyCondition& condition = suite.conditions[i];
      const std::string path = "/conditions/" + std::to_string(i);
      if (condition.name.empty()) refuse(path + "/name", condition.name, "a name");
      check_pixel_formats(condition, path);
      for (const std::string& format : condition.pixel_formats) trial_of(suite, i, format);
    }
    return suite;
  } catch (const SettingsError& error) {
    throw SettingsError(file + ": " + error.what());
  }
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
      const Trial trial = trial_of(suite, i, format);
      TrialResult result = run_trial(trial, condition, options.frames.value_or(trial.frames),
                                     options.colors.value_or(suite.colors), report.reliability);
      auto failures = failures_of(result.score, result.film, trial.limits);
      if (!result.problem.empty()) failures.insert(failures.begin(), "not learnt: " + result.problem);
      report.rows.push_back({condition.name, format, trial.px_per_mm, std::move(result.score),
                             std::move(failures), std::move(result.film)});
      options.done(report.rows.back());
    }
  }
  return report;
}

std::string accuracy_text(const AccuracyReport& report, bool markdown) {
  Table table{{"condition", "format", "px/mm", "robots", "recall", "wrong id", "false", "robot mm", "degrees",
               "ball recall", "precision", "ball mm", ""}};
  std::string failures;
  for (const AccuracyRow& row : report.rows) {
    const Score& s = row.score;
    table.push_back(
        {row.condition, row.pixel_format, fmt::format("{:.3f}", row.px_per_mm),
         std::to_string(s.robots.expected), number_or_dash(s.robots.expected, s.robots.recall(), 4),
         std::to_string(s.robots.wrong_id), std::to_string(s.robots.invented),
         number_or_dash(s.robot_position_mm.count, s.robot_position_mm.rms, 3),
         number_or_dash(s.robot_orientation_deg.count, s.robot_orientation_deg.rms, 3),
         number_or_dash(s.balls.expected, s.balls.recall(), 4),
         number_or_dash(s.balls.found + s.balls.wrong_id + s.balls.invented, s.balls.precision(), 4),
         number_or_dash(s.ball_position_mm.count, s.ball_position_mm.rms, 3),
         row.failures.empty() ? "" : "FAILED"});
    for (const std::string& failure : row.failures) {
      failures +=
          fmt::format("{}{}, {}: {}\n", markdown ? "- " : "", row.condition, row.pixel_format, failure);
    }
  }
  std::string out = table_text(table, 2, markdown);
  if (!failures.empty()) out += "\n" + failures;

  const auto film = film_table(report);
  if (film.size() > 1) out += "\n" + table_text(film, 2, markdown);

  Table reliability{{"confidence", "robots", "right", "balls", "right"}};
  for (std::size_t i = 0; i < Reliability::kBins; ++i) {
    const auto& robots = report.reliability.robots[i];
    const auto& balls = report.reliability.balls[i];
    const auto share = [](const Reliability::Bin& bin) {
      return number_or_dash(bin.count, static_cast<double>(bin.right) / static_cast<double>(bin.count), 3);
    };
    reliability.push_back({fmt::format("{:.1f} - {:.1f}", static_cast<double>(i) / Reliability::kBins,
                                       static_cast<double>(i + 1) / Reliability::kBins),
                           std::to_string(robots.count), share(robots), std::to_string(balls.count),
                           share(balls)});
  }
  return out + "\n" + table_text(reliability, 1, markdown);
}

Json accuracy_json(const AccuracyReport& report) {
  Json rows = Json::array();
  for (const AccuracyRow& row : report.rows) {
    Json one{{"condition", row.condition},
             {"pixel_format", row.pixel_format},
             {"px_per_mm", row.px_per_mm},
             {"failures", row.failures}};
    one.update(score_json(row.score));
    rows.push_back(std::move(one));
  }
  return {{"passed", report.passed()},
          {"rows", rows},
          {"reliability",
           {{"robots", json_of(report.reliability.robots)}, {"balls", json_of(report.reliability.balls)}}}};
}

}  // namespace sslv
