// SPDX-License-Identifier: Apache-2.0
#include "lab/accuracy_colors.h"

#include "capture/simulator/simulator_camera.h"
#include "capture/simulator/simulator_random.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace sslv {
namespace {

/// A place in a training image where an admin may click to show a colour.
struct ClickTarget {
  std::size_t picture;
  Label label;
  Eigen::Vector2d pixel;
  double radius_px;  // radius of the clicked thing
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
    // The nearest corner between four quads.
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

/// Finds the places in one image that an admin may click at.
class PlaceFinder {
 public:
  PlaceFinder(const Scene& scene, const PatternTable& patterns, std::size_t picture, const Json& truth,
              SimulatorRandom& random)
      : scene_(scene), patterns_(patterns), picture_(picture), truth_(truth), random_(random) {}

  std::vector<ClickTarget> find() {
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
    add(robot.at("team") == "blue" ? label::kBlue : label::kYellow,
        on_top(patterns_.center_x_mm, patterns_.center_y_mm), patterns_.center_diameter_mm / 2);
    for (std::size_t i = 0; i < patterns_.dots.size(); ++i) {
      const PatternDot& dot = patterns_.dots[i];
      add(code->colors[i], on_top(dot.x_mm, dot.y_mm), dot.diameter_mm / 2);
    }
    // The places on top with most space between the dots of the league's pattern.
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

  /// Places in the corners, at the sides and in the middle.
  void add_carpet() {
    constexpr int kAttempts = 100;
    constexpr double kReach = 0.06;  // as a share of the image's size
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

  /// Whether nothing is on the floor there, or between there and the camera.
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
  std::vector<ClickTarget> places_;
};

/// Selects `count` of the places, each as far from the previous ones as possible; repeats places if there are
/// fewer.
std::vector<ClickTarget> spread(const std::vector<ClickTarget>& places, std::size_t count) {
  std::vector<ClickTarget> out;
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

/// Options for other images under the same conditions.
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

}  // namespace

LearntColors learn(const Trial& trial, const CameraContext& context) {
  constexpr int kPictures = 3;
  SimulatedCamera camera(other_pictures(trial.learn_source), {0, *context.scene}, *context.patterns);
  std::vector<TrainingPicture> pictures(static_cast<std::size_t>(trial.learn_frames.value_or(kPictures)));
  LearnTask task{{}, *context.scene, *context.patterns};
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    take(camera, static_cast<int>(i), pictures[i]);
    task.frames.push_back(pictures[i].view);
  }
  return learn_colors(task);
}

std::vector<ColorSample> click(const Trial& trial, const CameraContext& context) {
  constexpr std::size_t kClicks = 8;
  constexpr int kPictures = 2;
  SimulatorOptions options = other_pictures(trial.learn_source);
  options.balls = std::max(options.balls, 6);                             // an admin has several balls
  options.hidden_balls = options.covered_dots = options.distractors = 0;  // and clicks at visible things only
  options.light_swing.clear(), options.cast_swing.clear();
  SimulatedCamera camera(options, {0, *context.scene}, *context.patterns);
  SimulatorRandom random(static_cast<std::uint64_t>(options.seed));

  std::vector<TrainingPicture> pictures(static_cast<std::size_t>(trial.learn_frames.value_or(kPictures)));
  std::vector<ClickTarget> places;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    TrainingPicture& picture = pictures[i];
    take(camera, static_cast<int>(i), picture);
    const auto more = PlaceFinder(*context.scene, *context.patterns, i, picture.truth, random).find();
    places.insert(places.end(), more.begin(), more.end());
  }

  std::vector<ColorSample> samples;
  for (std::size_t i = 0; i < label::kCount; ++i) {
    std::vector<ClickTarget> same;
    std::copy_if(places.begin(), places.end(), std::back_inserter(same),
                 [&](const ClickTarget& place) { return place.label == i; });
    for (const ClickTarget& place : spread(same, kClicks)) {
      const double angle = random.angle(), off_px = place.radius_px / 4 * std::sqrt(random.uniform(0, 1));
      samples.push_back({place.label, color_around(pictures[place.picture].view,
                                                   place.pixel + off_px * Eigen::Vector2d(std::cos(angle),
                                                                                          std::sin(angle)))});
    }
  }
  return samples;
}

}  // namespace sslv
