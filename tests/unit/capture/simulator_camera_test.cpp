// SPDX-License-Identifier: Apache-2.0
#include "capture/simulator/simulator_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gmock/gmock.h>

namespace sslv::simulator_camera_test {
namespace {

using Picture = std::vector<std::uint8_t>;
constexpr double kTimeS = 1.79e9;

/// Without noise, blur and vignette: pixels depend on geometry only.
SimulatorOptions plain_options() {
  SimulatorOptions options;
  options.pixel_format = PixelFormat::kRgb24;
  options.noise_sigma = 0;
  options.blur_sigma_px = 0;
  options.vignette = 0;
  return options;
}

/// A camera 4 m above the right half of the field, tilted along x.
SourceContext context_of(const SimulatorOptions& options, double tilt_rad = 0, double distortion = 0) {
  CameraCalibration c;
  c.focal_length = 600 * options.width / 780.0;
  c.principal_point_x = (options.width - 1) / 2.0 + 5;
  c.principal_point_y = (options.height - 1) / 2.0 - 3;
  c.distortion = distortion;
  c.pixel_image_width = options.width;
  c.pixel_image_height = options.height;
  const Eigen::Vector3d position_mm(1500 - 4000 * std::tan(tilt_rad), 100, 4000);
  const Eigen::Quaterniond q(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()) *
                             Eigen::AngleAxisd(tilt_rad, Eigen::Vector3d::UnitY()));
  const Eigen::Vector3d t = -(q * position_mm);
  c.q0 = q.x();
  c.q1 = q.y();
  c.q2 = q.z();
  c.q3 = q.w();
  c.tx = t.x();
  c.ty = t.y();
  c.tz = t.z();
  SourceContext context;
  context.scene.camera.emplace(c);
  return context;
}

Picture draw(SimulatedCamera& camera, double t_s) {
  Picture picture(camera.picture_bytes());
  camera.draw(t_s, picture.data());
  return picture;
}

/// Centroid of the pixels within `reach_px` of `near`, weighted by `weight_at`.
template <class WeightAt>
Eigen::Vector2d centroid(const Eigen::Vector2d& near, double reach_px, const WeightAt& weight_at) {
  Eigen::Vector2d sum(0, 0);
  double total = 0;
  for (int y = static_cast<int>(near.y() - reach_px); y <= static_cast<int>(near.y() + reach_px) + 1; ++y) {
    for (int x = static_cast<int>(near.x() - reach_px); x <= static_cast<int>(near.x() + reach_px) + 1; ++x) {
      if (std::hypot(x - near.x(), y - near.y()) > reach_px) continue;
      const double weight = weight_at(x, y);
      sum += weight * Eigen::Vector2d(x, y);
      total += weight;
    }
  }
  return sum / total;
}

Eigen::Vector2d pixel_of(const Json& thing) {
  return {thing["pixel_x"].get<double>(), thing["pixel_y"].get<double>()};
}

/// Centroid of a disc's image. In perspective, it is not the image of the disc's centre.
Eigen::Vector2d centroid_of_disc(const CameraModel& camera, const Eigen::Vector3d& center_mm,
                                 double radius_mm) {
  constexpr int kSteps = 10;
  Eigen::Vector2d sum(0, 0);
  double total = 0;
  for (int i = -kSteps; i <= kSteps; ++i) {
    for (int j = -kSteps; j <= kSteps; ++j) {
      const Eigen::Vector2d offset_mm = radius_mm / kSteps * Eigen::Vector2d(i, j);
      if (offset_mm.norm() > radius_mm) continue;
      const Eigen::Vector2d pixel =
          *camera.project(center_mm + Eigen::Vector3d(offset_mm.x(), offset_mm.y(), 0));
      const double weight = 1 / camera.mm2_per_px(pixel, center_mm.z());
      sum += weight * pixel;
      total += weight;
    }
  }
  return sum / total;
}

/// The centre of a robot's top in mm.
Eigen::Vector3d place_of(const Json& robot) {
  return {robot["x"].get<double>(), robot["y"].get<double>(), robot["height"].get<double>()};
}

struct View {
  const char* name;
  double tilt_rad, distortion;
};
constexpr View kViews[] = {{"straight", 0, 0}, {"tilted and distorted", 0.35, 0.15}, {"cushion", 0.2, -0.1}};

TEST(SimulatedCamera, DrawsDotsWhereTheCameraModelSaysSo) {
  // A centre dot lies on uniform black, so the light above black is proportional to the share of each pixel
  // that the dot covers.
  constexpr double kBlackRed = 24, kBlackBlue = 27;
  for (const View& view : kViews) {
    SCOPED_TRACE(view.name);
    const SimulatorOptions options = plain_options();
    const SourceContext context = context_of(options, view.tilt_rad, view.distortion);
    SimulatedCamera camera(options, context, league_patterns());
    int checked = 0;
    double worst_px = 0;
    for (int i = 0; i < 20; ++i) {
      const double t_s = kTimeS + 1.7 * i;
      const Picture picture = draw(camera, t_s);
      const Json truth = camera.truth("", t_s);
      for (const Json& robot : truth["robots"]) {
        if (!robot["visible"].get<bool>()) continue;
        const bool blue = robot["team"] == "blue";
        const Eigen::Vector2d expected = centroid_of_disc(*context.scene.camera, place_of(robot), 25);
        EXPECT_LT((pixel_of(robot) - expected).norm(), 0.05);
        const double px_per_mm = 1 / std::sqrt(context.scene.camera->mm2_per_px(expected, robot["height"]));
        const Eigen::Vector2d seen = centroid(expected, 34 * px_per_mm, [&](int x, int y) {
          const int at = 3 * (y * options.width + x);
          return blue ? picture[at + 2] - kBlackBlue : picture[at] - kBlackRed;
        });
        worst_px = std::max(worst_px, (seen - expected).norm());
        ++checked;
      }
    }
    EXPECT_GT(checked, 20);
    EXPECT_LT(worst_px, 0.02);
  }
}

/// Pixel position of the centroid of a ball's light. A ball lit evenly from above is brightest where its
/// surface is level, which is off its centre when seen at an angle.
Eigen::Vector2d middle_of_light(const CameraModel& camera, const Json& ball, double paint, double carpet) {
  constexpr double kRadiusMm = 21.5, kStepMm = 0.25;
  const Eigen::Vector3d center(ball["x"], ball["y"], kRadiusMm);
  const Eigen::Vector3d sight = (center - camera.position_mm()).normalized();
  const Eigen::Vector3d side = sight.unitOrthogonal(), up = sight.cross(side);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double weights = 0;
  for (double a = -kRadiusMm; a < kRadiusMm; a += kStepMm) {
    for (double b = -kRadiusMm; b < kRadiusMm; b += kStepMm) {
      const double depth2 = kRadiusMm * kRadiusMm - a * a - b * b;
      if (depth2 <= 0) continue;
      const Eigen::Vector3d surface = a * side + b * up - std::sqrt(depth2) * sight;
      const double weight = paint * (0.7 + 0.35 * std::max(0.0, surface.z() / kRadiusMm)) - carpet;
      sum += weight * *camera.project(center + a * side + b * up);
      weights += weight;
    }
  }
  return sum / weights;
}

TEST(SimulatedCamera, BallsShowWhereTheTruthSaysInEveryFormat) {
  for (const PixelFormat format : {PixelFormat::kUyvy, PixelFormat::kRgb24, PixelFormat::kMono8,
                                   PixelFormat::kBayerRg8, PixelFormat::kBayerGb8}) {
    for (const View& view : {kViews[0], kViews[1]}) {
      SCOPED_TRACE(std::string(name_of(format)) + " " + view.name);
      SimulatorOptions options = plain_options();
      options.pixel_format = format;
      options.blur_sigma_px = 0.5;
      options.robots_yellow = options.robots_blue = 0;
      options.balls = 10;
      const SourceContext context = context_of(options, view.tilt_rad, view.distortion);
      SimulatedCamera camera(options, context, league_patterns());
      options.balls = 0;
      SimulatedCamera empty(options, context, league_patterns());
      const Picture background = draw(empty, 0);
      const int bytes = bytes_per_pixel(format), luma = format == PixelFormat::kUyvy ? 1 : 0;
      int checked = 0;
      double worst_px = 0;
      for (int i = 0; i < 8; ++i) {
        const double t_s = kTimeS + 3.1 * i;
        const Picture picture = draw(camera, t_s);
        // Change of a pixel's sample by the ball; in Bayer images, only of red samples.
        const auto changed = [&](int x, int y) {
          if (format == PixelFormat::kBayerRg8 && (x % 2 != 0 || y % 2 != 0)) return 0;
          if (format == PixelFormat::kBayerGb8 && (x % 2 != 0 || y % 2 != 1)) return 0;
          const int at = (y * options.width + x) * bytes + luma;
          return picture[at] - background[at];
        };
        const Json truth = camera.truth("", t_s);
        for (const Json& ball : truth["balls"]) {
          const Eigen::Vector2d expected = pixel_of(ball);
          if (!ball["visible"].get<bool>() || expected.minCoeff() < 12 || expected.x() > options.width - 12 ||
              expected.y() > options.height - 12) {
            continue;
          }
          const auto line_nearby = [&](int x, int y) {
            return background[(y * options.width + x) * bytes + luma] > 110 ? 1 : 0;
          };
          if (!centroid(expected, 10, line_nearby).hasNaN()) continue;  // its contrast varies there
          const bool red = is_bayer(format) || format == PixelFormat::kRgb24;
          const Eigen::Vector2d middle =
              middle_of_light(*context.scene.camera, ball, red ? 238 : 138, red ? 30 : 70);
          worst_px = std::max(worst_px, (centroid(expected, 9, changed) - middle).norm());
          ++checked;
        }
      }
      EXPECT_GT(checked, 10);
      // The carpet under the ball is uneven, and a Bayer image has a quarter of the samples on a ball of 6
      // pixels.
      EXPECT_LT(worst_px, is_bayer(format) ? 0.3 : 0.08);
    }
  }
}

TEST(SimulatedCamera, PaintsLinesAtTheirPublishedPlaces) {
  SimulatorOptions options = plain_options();
  options.robots_yellow = options.robots_blue = options.balls = 0;
  const SourceContext context = context_of(options, 0.2, 0.1);
  SimulatedCamera camera(options, context, league_patterns());
  const Picture picture = draw(camera, 0);
  for (const Eigen::Vector3d& on_line :
       {Eigen::Vector3d(0, 700, 0), Eigen::Vector3d(500 * std::cos(0.5), 500 * std::sin(0.5), 0)}) {
    const Eigen::Vector2d pixel = *context.scene.camera->project(on_line);
    // Centroid along the image row, since the lines here are nearly vertical.
    double sum = 0, weight = 0;
    const int y = static_cast<int>(std::lround(pixel.y()));
    for (int x = static_cast<int>(pixel.x()) - 6; x <= static_cast<int>(pixel.x()) + 7; ++x) {
      const int at = 3 * (y * options.width + x);
      const double white = picture[at] - 30.0;
      sum += white * x;
      weight += white;
    }
    const auto seen = context.scene.camera->unproject({sum / weight, static_cast<double>(y)}, 0);
    // The uneven carpet limits this simple measurement.
    const double off_mm = on_line.x() == 0 ? seen->x() : seen->norm() - 500;
    EXPECT_NEAR(off_mm, 0, 2);
  }
}

TEST(SimulatedCamera, PaintsLinesAsTheFieldWasMeasured) {
  SimulatorOptions options = plain_options();
  options.robots_yellow = options.robots_blue = options.balls = 0;
  SourceContext context = context_of(options, 0.2, 0.1);
  context.scene.field.line_thickness = 40;
  // Across the centre circle, whose radius is 500 mm.
  const auto paint_at = [&](double radius_mm) {
    SimulatedCamera camera(options, context, league_patterns());
    const Eigen::Vector2d pixel = *context.scene.camera->project(
        Eigen::Vector3d(radius_mm * std::cos(0.5), radius_mm * std::sin(0.5), 0));
    return draw(camera, 0)[3 * static_cast<std::size_t>(std::lround(pixel.y()) * options.width +
                                                        std::lround(pixel.x()))] > 120;
  };
  EXPECT_TRUE(paint_at(490) && paint_at(510));
  EXPECT_FALSE(paint_at(470) || paint_at(530));
  options.lines_measured_to = LinesMeasured::kToOuterEdge;
  EXPECT_TRUE(paint_at(470) && paint_at(490));
  EXPECT_FALSE(paint_at(450) || paint_at(510));
}

TEST(SimulatedCamera, PaintsTheFieldsOwnLinesInstead) {
  SimulatorOptions options = plain_options();
  options.robots_yellow = options.robots_blue = options.balls = 0;
  SourceContext context = context_of(options, 0.2, 0.1);
  const auto red_at = [&](const SourceContext& of, double x_mm, double y_mm) {
    SimulatedCamera camera(options, of, league_patterns());
    const Eigen::Vector2d pixel = *of.scene.camera->project(Eigen::Vector3d(x_mm, y_mm, 0));
    return int{draw(
        camera,
        0)[3 * static_cast<std::size_t>(std::lround(pixel.y()) * options.width + std::lround(pixel.x()))]};
  };
  const int carpet = red_at(context, 200, 700), line = red_at(context, 0, 700);
  ASSERT_GT(line, carpet + 50);
  context.scene.field.field_lines = {{"HalfwayLine", 200, -3000, 200, 3000},
                                     {"Wide", -400, 700, -200, 700, 100}};
  context.scene.field.field_arcs.emplace();
  EXPECT_NEAR(red_at(context, 200, 700), line, 40);
  EXPECT_NEAR(red_at(context, 0, 700), carpet, 25);
  EXPECT_GT(red_at(context, -300, 735), carpet + 50);  // within its 100 mm of paint
  EXPECT_NEAR(red_at(context, 0, 500), carpet, 25);    // no centre circle
}

TEST(SimulatedCamera, ShowsTheIdAndTheDirection) {
  SimulatorOptions options = plain_options();
  options.width = 1560;  // dots of 12 pixels
  options.height = 1160;
  options.robots_yellow = options.robots_blue = 16;
  const SourceContext context = context_of(options, 0.1, 0.1);
  SimulatedCamera camera(options, context, league_patterns());
  const Picture picture = draw(camera, kTimeS);
  const auto redder_than_green = [&](const Eigen::Vector2d& p) {
    const auto at = static_cast<std::size_t>(3 * (std::lround(p.y()) * options.width + std::lround(p.x())));
    return picture[at] > picture[at + 1];
  };
  int checked = 0;
  const Json truth = camera.truth("", kTimeS);
  for (const Json& robot : truth["robots"]) {
    if (!robot["visible"].get<bool>()) continue;
    const auto& code = league_patterns().codes[robot["id"].get<std::size_t>()];
    ASSERT_EQ(code.id, robot["id"].get<int>());
    for (std::size_t dot = 0; dot < 4; ++dot) {
      const auto& place = league_patterns().dots[dot];
      const Eigen::Vector2d turned =
          Eigen::Rotation2Dd(robot["orientation"].get<double>()) * Eigen::Vector2d(place.x_mm, place.y_mm);
      const auto pixel = context.scene.camera->project(
          {robot["x"].get<double>() + turned.x(), robot["y"].get<double>() + turned.y(), robot["height"]});
      EXPECT_EQ(redder_than_green(*pixel), code.colors[dot] == label::kPink) << robot << " dot " << dot;
      ++checked;
    }
  }
  EXPECT_GT(checked, 20);
}

TEST(SimulatedCamera, AFrameDoesNotDependOnThoseBefore) {
  SimulatorOptions options = plain_options();
  options.pixel_format = PixelFormat::kUyvy;
  options.blur_sigma_px = 1.2;
  options.exposure_ms = 30;
  options.robots_yellow = options.robots_blue = 16;
  options.balls = 5;
  const SourceContext context = context_of(options);
  SimulatedCamera used(options, context, league_patterns()), fresh(options, context, league_patterns());
  const Picture before = draw(used, kTimeS);
  const Picture after = draw(used, kTimeS + 0.4);
  EXPECT_EQ(after, draw(fresh, kTimeS + 0.4));
  EXPECT_NE(after, before);
}

TEST(SimulatedCamera, NoiseIsNewEachFrameAndTheSameEachRun) {
  SimulatorOptions options = plain_options();
  options.noise_sigma = 4;
  options.speed = 0;
  const SourceContext context = context_of(options);
  SimulatedCamera one(options, context, league_patterns()), same(options, context, league_patterns());
  options.noise_sigma = 0;
  SimulatedCamera clean_camera(options, context, league_patterns());
  const Picture a = draw(one, 0), b = draw(one, 0), clean = draw(clean_camera, 0);
  EXPECT_EQ(a, draw(same, 0));
  EXPECT_EQ(b, draw(same, 0));
  double sum = 0, squares = 0, between = 0;
  for (std::size_t i = 0; i < clean.size(); ++i) {
    const double da = a[i] - clean[i], db = b[i] - clean[i];
    sum += da;
    squares += da * da;
    between += da * db;
  }
  const auto n = static_cast<double>(clean.size());
  EXPECT_NEAR(sum / n, 0, 0.05);
  EXPECT_NEAR(std::sqrt(squares / n), 4, 0.1);
  EXPECT_NEAR(between / n, 0, 0.1);
}

TEST(SimulatedCamera, LightFallsOffAsAsked) {
  SimulatorOptions options = plain_options();
  options.robots_yellow = options.robots_blue = options.balls = 0;
  const SourceContext context = context_of(options);
  const auto mean_green = [&](const SimulatorOptions& with, int x0) {
    SimulatedCamera camera(with, context, league_patterns());
    const Picture picture = draw(camera, 0);
    double sum = 0;
    for (int y = 300; y < 340; ++y) {
      for (int x = x0; x < x0 + 40; ++x) {
        const int at = 3 * (y * 780 + x) + 1;
        sum += picture[at];
      }
    }
    return sum / 1600;
  };
  SimulatorOptions dim = options, one_sided = options;
  dim.light = 0.5;
  one_sided.gradient = 0.6;
  for (const int x : {100, 600}) {
    EXPECT_NEAR(mean_green(dim, x) / mean_green(options, x), 0.5, 0.01);
    EXPECT_NEAR(mean_green(one_sided, x) / mean_green(options, x), 1 - 0.6 * (x + 20) / 780, 0.01);
  }
}

TEST(SimulatedCamera, ExposureSmearsAlongTheWay) {
  SimulatorOptions options = plain_options();
  options.robots_yellow = options.robots_blue = 0;
  options.balls = 3;
  const SourceContext context = context_of(options);
  const auto brightest_red = [&](double exposure_ms) {
    options.exposure_ms = exposure_ms;
    SimulatedCamera camera(options, context, league_patterns());
    const Picture picture = draw(camera, kTimeS);
    const Json truth = camera.truth("", kTimeS);
    for (const Json& ball : truth["balls"]) {
      if (!ball["visible"].get<bool>()) continue;
      const Eigen::Vector2d pixel = pixel_of(ball);
      return static_cast<int>(picture[static_cast<std::size_t>(
          3 * (std::lround(pixel.y()) * options.width + std::lround(pixel.x())))]);
    }
    return -1;
  };
  EXPECT_GT(brightest_red(0), 200);
  EXPECT_LT(brightest_red(100), 150);
  EXPECT_GT(brightest_red(100), 30);
}

TEST(SimulatedCamera, CutAndHiddenThingsAreNotVisible) {
  SimulatorOptions options = plain_options();
  options.robots_yellow = options.robots_blue = 16;
  options.balls = 10;
  SourceContext context = context_of(options);
  context.scene.robot_height_mm = {150, 150};
  SimulatedCamera camera(options, context, league_patterns());
  int cut = 0, hidden = 0;
  for (int i = 0; i < 1000; ++i) {
    const Json truth = camera.truth("f", kTimeS + i);
    for (const Json& robot : truth["robots"]) {
      const Eigen::Vector2d p = pixel_of(robot);
      const double inside = std::min({p.x(), p.y(), 779 - p.x(), 579 - p.y()});
      // The top's radius is 14 pixels.
      if (inside < 11 || inside > 18) {
        EXPECT_EQ(robot["visible"].get<bool>(), inside > 18) << robot;
      }
      cut += inside > -10 && inside < 10;
    }
    for (const Json& ball : truth["balls"]) {
      const Eigen::Vector2d p = pixel_of(ball);
      const double inside = std::min({p.x(), p.y(), 779 - p.x(), 579 - p.y()});
      hidden += inside > 10 && !ball["visible"].get<bool>();
    }
  }
  EXPECT_GT(cut, 10);
  EXPECT_GT(hidden, 3);  // some are behind robots
}

TEST(SimulatedCamera, VisibleShareIsWhatThePictureHolds) {
  SimulatorOptions options = plain_options();
  options.robots_yellow = options.robots_blue = 0;
  options.balls = 10;
  const SourceContext context = context_of(options);
  SimulatedCamera camera(options, context, league_patterns());
  constexpr double kRadiusPx = 21.5 * 600 / (4000 - 21.5);
  int cut = 0;
  for (int i = 0; i < 400; ++i) {
    const Json truth = camera.truth("f", kTimeS + i);
    for (const Json& ball : truth["balls"]) {
      const double share = ball["visible_share"];
      EXPECT_EQ(share == 1, ball["visible"].get<bool>());
      const Eigen::Vector2d p = pixel_of(ball);
      std::array<double, 4> inside{p.x() + 0.5, p.y() + 0.5, 779.5 - p.x(), 579.5 - p.y()};
      std::sort(inside.begin(), inside.end());
      if (inside[1] < kRadiusPx) continue;  // cut by a corner
      const double d = std::clamp(inside[0] / kRadiusPx, -1.0, 1.0);
      EXPECT_NEAR(share, 1 - (std::acos(d) - d * std::sqrt(1 - d * d)) / std::numbers::pi, 0.03);
      cut += share > 0 && share < 0.9;
    }
  }
  EXPECT_GT(cut, 5);
}

SimulatorOptions scattered_options() {
  SimulatorOptions options = plain_options();
  options.placement = SimulatorPlacement::kScatter;
  return options;
}

/// A tilted camera in which a ball is 20 pixels wide.
SourceContext close_up_of(const SimulatorOptions& options) {
  SourceContext context = context_of(options, 0.35);
  CameraCalibration calibration = context.scene.camera->calibration();
  calibration.focal_length = 2000;
  context.scene.camera.emplace(calibration);
  return context;
}

std::array<int, 3> color_at(const Picture& picture, int width, const Eigen::Vector2d& pixel) {
  const auto at = static_cast<std::size_t>(3 * (std::lround(pixel.y()) * width + std::lround(pixel.x())));
  return {picture[at], picture[at + 1], picture[at + 2]};
}

TEST(SimulatedCamera, HidesBallsByTheWantedShare) {
  for (const double hidden : {0.3, 0.5, 0.8}) {
    SCOPED_TRACE(hidden);
    SimulatorOptions options = scattered_options();
    options.hidden_balls = options.balls = 2;
    options.hidden_share = hidden;
    const SourceContext context = close_up_of(options);
    const CameraModel& model = *context.scene.camera;
    SimulatedCamera camera(options, context, league_patterns());
    int checked = 0;
    for (int slot = 0; slot < 8; ++slot) {
      const double t_s = slot / 60.0;
      const Picture picture = draw(camera, t_s);
      const Json truth = camera.truth("", t_s);
      ASSERT_EQ(truth["balls"].size(), 2U);
      for (const Json& ball : truth["balls"]) {
        EXPECT_NEAR(ball["visible_share"], 1 - hidden, 0.05);
        EXPECT_FALSE(ball["visible"]);
        // Counts the ball's orange pixels.
        const Eigen::Vector2d middle = pixel_of(ball), place(ball["x"], ball["y"]);
        int pixels = 0, orange = 0;
        for (int y = static_cast<int>(middle.y()) - 20; y <= middle.y() + 20; ++y) {
          for (int x = static_cast<int>(middle.x()) - 20; x <= middle.x() + 20; ++x) {
            const auto at = model.unproject(Eigen::Vector2d(x, y), 21.5);
            if ((*at - place).norm() > 21) continue;
            const auto [r, g, b] = color_at(picture, options.width, Eigen::Vector2d(x, y));
            ++pixels;
            orange += r > 90 && r > 2 * b;
          }
        }
        EXPECT_GT(pixels, 200);
        EXPECT_NEAR(static_cast<double>(orange) / pixels, 1 - hidden, 0.06);
        ++checked;
      }
    }
    EXPECT_EQ(checked, 16);
  }
}

TEST(SimulatedCamera, DrawsTheSidesOfRobots) {
  SimulatorOptions options = plain_options();
  const SourceContext context = context_of(options, 0.2);
  const CameraModel& model = *context.scene.camera;
  const Eigen::Vector2d foot = model.position_mm().head<2>();
  SimulatedCamera camera(options, context, league_patterns());
  int checked = 0;
  for (int i = 0; i < 10; ++i) {
    const Picture picture = draw(camera, kTimeS + i);
    const Json truth = camera.truth("", kTimeS + i);
    for (const Json& robot : truth["robots"]) {
      if (!robot["visible"].get<bool>()) continue;
      // The floor under the robot, towards the camera, is hidden by the robot's side, not by its top.
      const Eigen::Vector2d center = place_of(robot).head<2>(), to_foot = foot - center;
      if (to_foot.norm() < 1900) continue;
      const Eigen::Vector2d under = center + 40 * to_foot.normalized();
      const auto pixel = model.project({under.x(), under.y(), 0});
      if (pixel->minCoeff() < 1 || pixel->x() > 778 || pixel->y() > 578) continue;
      EXPECT_EQ(color_at(picture, options.width, *pixel), (std::array<int, 3>{34, 34, 38}));
      ++checked;
    }
  }
  EXPECT_GT(checked, 5);
}

TEST(SimulatedCamera, SaysWhenNothingCanHideBalls) {
  SimulatorOptions options = scattered_options();
  options.hidden_balls = 1;
  options.hidden_share = 0.9;
  SourceContext context = context_of(options);
  CameraCalibration straight_down = context.scene.camera->calibration();
  straight_down.focal_length = 4000;
  context.scene.camera.emplace(straight_down);
  std::string problem;
  try {
    const SimulatedCamera camera(options, context, league_patterns());
  } catch (const CaptureError& error) {
    problem = error.what();
  }
  EXPECT_EQ(problem,
            "camera 0: hidden_balls: 1, each hidden by 90 % from this camera, are not allowed on a field of "
            "9000 x 6000 mm; expected fewer, or a smaller hidden_share");
}

TEST(SimulatedCamera, ACoveredDotIsBlack) {
  SimulatorOptions options = scattered_options();
  options.width = 1560;
  options.height = 1160;
  options.covered_dots = 6;
  const SourceContext context = context_of(options, 0.1, 0.1);
  SimulatedCamera camera(options, context, league_patterns());
  int covered = 0, shown = 0;
  for (int slot = 0; slot < 4; ++slot) {
    const Picture picture = draw(camera, slot / 60.0);
    const Json truth = camera.truth("", slot / 60.0);
    for (const Json& robot : truth["robots"]) {
      if (!robot["visible"].get<bool>()) continue;
      for (std::size_t dot = 0; dot < 4; ++dot) {
        const auto& place = league_patterns().dots[dot];
        const Eigen::Vector2d turned =
            Eigen::Rotation2Dd(robot["orientation"].get<double>()) * Eigen::Vector2d(place.x_mm, place.y_mm);
        const auto pixel =
            context.scene.camera->project(place_of(robot) + Eigen::Vector3d(turned.x(), turned.y(), 0));
        const auto color = color_at(picture, options.width, *pixel);
        if (robot["covered_dot"] == dot) {
          EXPECT_EQ(color, (std::array<int, 3>{24, 24, 27}));
          ++covered;
        } else {
          EXPECT_GT(std::max(color[0], color[1]), 150);
          ++shown;
        }
      }
    }
  }
  EXPECT_GT(covered, 4);
  EXPECT_GT(shown, 40);
}

TEST(SimulatedCamera, DrawsDistractorsInTheirSizes) {
  for (const auto placement : {SimulatorPlacement::kPaths, SimulatorPlacement::kScatter}) {
    SimulatorOptions options = plain_options();
    options.placement = placement;
    options.robots_yellow = options.robots_blue = options.balls = 0;
    options.seed = 5;
    const SourceContext context = context_of(options, 0.2);
    const CameraModel& model = *context.scene.camera;
    SimulatedCamera empty(options, context, league_patterns());
    options.distractors = 20;
    SimulatedCamera camera(options, context, league_patterns());
    const Picture background = draw(empty, 0);
    int checked = 0;
    for (int slot = 0; slot < 5; ++slot) {
      const Picture picture = draw(camera, slot / 60.0);
      const SimulatedScene scene = camera.scene_at(slot / 60.0);
      for (const SimulatedDistractor& thing : scene.distractors) {
        const double reach_mm = std::hypot(thing.length_mm, thing.width_mm) / 2 + 20;
        const auto middle = model.project({thing.x_mm, thing.y_mm, 0});
        const bool alone = std::all_of(
            scene.distractors.begin(), scene.distractors.end(), [&](const SimulatedDistractor& other) {
              const double apart_mm = std::hypot(other.x_mm - thing.x_mm, other.y_mm - thing.y_mm);
              return &other == &thing || apart_mm > 2 * reach_mm + 180;
            });
        if (!alone || std::min(thing.length_mm, thing.width_mm) < 30 || !middle || middle->minCoeff() < 40 ||
            middle->x() > options.width - 40 || middle->y() > options.height - 40) {
          continue;
        }
        const auto inside = color_at(picture, options.width, *middle);
        double area_mm2 = 0;
        for (int y = static_cast<int>(middle->y()) - 40; y < middle->y() + 39; ++y) {
          for (int x = static_cast<int>(middle->x()) - 40; x < middle->x() + 39; ++x) {
            const Eigen::Vector2d pixel(x, y);
            const auto place = model.unproject(pixel, 0);
            if ((*place - Eigen::Vector2d(thing.x_mm, thing.y_mm)).norm() > reach_mm) continue;
            const auto now = color_at(picture, options.width, pixel);
            const auto before = color_at(background, options.width, pixel);
            double changed = 0, most = 0;
            for (std::size_t c = 0; c < 3; ++c) {
              changed += std::abs(now[c] - before[c]);
              most += std::abs(inside[c] - before[c]);
            }
            area_mm2 += changed / most * model.mm2_per_px(pixel, 0);
          }
        }
        const double box_mm2 = thing.length_mm * thing.width_mm;
        const double expected_mm2 = thing.shape == SimulatedDistractor::Shape::kRectangle ? box_mm2
                                    : thing.shape == SimulatedDistractor::Shape::kTriangle
                                        ? box_mm2 / 2
                                        : box_mm2 * std::numbers::pi / 4;
        EXPECT_NEAR(area_mm2 / expected_mm2, 1, 0.1)
            << thing.length_mm << " x " << thing.width_mm << " shape " << static_cast<int>(thing.shape);
        ++checked;
      }
    }
    EXPECT_GT(checked, 3);
  }
}

TEST(SimulatedCamera, SmearsScatteredThingsAboutTheTruth) {
  SimulatorOptions options = scattered_options();
  options.robots_yellow = options.robots_blue = 0;
  options.balls = 3;
  const SourceContext context = context_of(options);
  const double kCarpetRed = 40;
  for (const double exposure_ms : {0.0, 40.0}) {
    options.exposure_ms = exposure_ms;
    SimulatedCamera camera(options, context, league_patterns());
    int checked = 0;
    double red = 0;
    for (int slot = 0; slot < 10; ++slot) {
      const Picture picture = draw(camera, slot / 60.0);
      const Json truth = camera.truth("", slot / 60.0);
      for (const Json& ball : truth["balls"]) {
        const Eigen::Vector2d pixel = pixel_of(ball);
        if (pixel.minCoeff() < 20 || pixel.x() > 760 || pixel.y() > 560) continue;
        const auto redness = [&](int x, int y) {
          const auto color = color_at(picture, options.width, Eigen::Vector2d(x, y));
          return color[0] > 1.3 * color[2] ? std::max(0.0, color[0] - kCarpetRed) : 0;  // skips white lines
        };
        EXPECT_LT((centroid(pixel, 14, redness) - pixel).norm(), 1);
        red += color_at(picture, options.width, pixel)[0];
        ++checked;
      }
    }
    EXPECT_GT(checked, 5);
    // During the exposure, the ball moves by twice its width.
    EXPECT_NEAR(red / checked, exposure_ms > 0 ? 145 : 238, 25);
  }
}

std::string error_of(const SimulatorOptions& options, const SourceContext& context,
                     const PatternTable& patterns) {
  try {
    const SimulatedCamera camera(options, context, patterns);
  } catch (const CaptureError& error) {
    return error.what();
  }
  return "no error";
}

TEST(SimulatedCamera, SaysWhatItCannotDraw) {
  using testing::HasSubstr;
  SimulatorOptions options = plain_options();
  SourceContext uncalibrated;
  uncalibrated.camera_id = 3;
  EXPECT_THAT(error_of(options, uncalibrated, league_patterns()), HasSubstr("camera 3: the simulator draws"));

  const SourceContext context = context_of(options);
  SimulatorOptions other_size = options;
  other_size.width = 1280;
  EXPECT_THAT(
      error_of(other_size, context, league_patterns()),
      HasSubstr("is for images of 780 x 580 (pixel_image_width, pixel_image_height), but the simulator's "
                "width and height say 1280 x 580"));

  PatternTable few = league_patterns();
  few.codes.resize(3);
  EXPECT_THAT(error_of(options, context, few), HasSubstr("has no such id"));

  options.robots_yellow = options.robots_blue = 16;
  SourceContext tiny = context;
  tiny.scene.field.field_length = tiny.scene.field.field_width = 1000;
  EXPECT_THAT(error_of(options, tiny, league_patterns()), HasSubstr("32 robots and 1 balls are not allowed"));
}

TEST(SimulatedCamera, LightAndItsColourSwingWithTheTime) {
  SimulatorOptions options = plain_options();
  options.speed = 0;
  options.light = 0.5;
  SimulatedCamera still(options, context_of(options), league_patterns());
  options.light_swing = {{0, 1}, {10, 0.4}, {30, 1.2}, {40, 1}};
  options.cast_swing = {{0, 1}, {20, 1.25}, {40, 1}};
  SimulatedCamera swinging(options, context_of(options), league_patterns());
  const Picture steady = draw(still, 0);
  for (const auto& [t_s, light, cast] :
       {std::array{0.0, 1.0, 1.0}, std::array{5.0, 0.7, 1.0625}, std::array{10.0, 0.4, 1.125},
        std::array{30.0, 1.2, 1.125}, std::array{35.0, 1.1, 1.0625}, std::array{4000.0, 1.0, 1.0}}) {
    const Picture picture = draw(swinging, t_s);
    const std::array gains{light * cast, light, light / cast};
    for (std::size_t i = 0; i < picture.size(); ++i) {
      if (steady[i] * gains[i % 3] > 250) continue;
      ASSERT_NEAR(picture[i], steady[i] * gains[i % 3], 1.5) << t_s << " s, byte " << i;
    }
  }
}

}  // namespace
}  // namespace sslv::simulator_camera_test
