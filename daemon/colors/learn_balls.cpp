// SPDX-License-Identifier: Apache-2.0
#include "colors/learn_balls.h"

#include "colors/find_spots.h"
#include "colors/name_dots.h"
#include "vision/ball_fit.h"

#include <algorithm>
#include <cmath>

namespace sslv {
namespace {

constexpr std::size_t kMaxBallSpots = 600;
// Limits on a ball's chromaticity. Printed orange has 0.64 red, 0.29 green and 0.07 blue, but balls have
// highlights, and cameras record them paler.
constexpr double kMinRed = 0.38, kMaxBlue = 0.27, kMinGreenPerRed = 0.15;
constexpr double kMaxGreenPerRed = 0.75, kOfYellows = 0.9;
// A clipped red channel, for example of a ball under a lamp, was brighter in reality, so more green per red
// is allowed.
constexpr double kClippedRed = 250, kMaxGreenPerClippedRed = 0.9;
constexpr double kWornCarpetAlike = 0.1;  // distance of chromaticities
/// Largest shift of worn or shiny carpet from its chromaticity (0) towards white (1).
constexpr double kMaxWorn = 0.8;
constexpr double kMinBallR2 = 0.6, kMaxRadiusOff = 0.25, kMinClear = 0.4, kMinVisible = 0.9;
/// Largest ratio of an outline's harmonics to the root sum of squares of 3.5 % of the radius and the
/// harmonics' standard deviation. Cones and hands exceed it; balls in difficult halls reach up to 1.9.
constexpr double kMaxOutOfRound = 2, kRoundShare = 0.035;
/// Upper limit of BallFitter::rectangle_gain(), which is negative for balls and larger for tape.
constexpr double kMaxLikeTape = -0.05;
constexpr double kOneColor = 0.06;      // distance of chromaticities
constexpr double kOutsideMm = 0;        // maximum distance outside the lines
constexpr double kRobotRadiusMm = 100;  // objects nearer to a robot's centre are not balls

bool is_warm(const Color3& color, double max_green_per_red) {
  const Color3 s = chromaticity_of(color);
  return s[0] > s[1] && s[1] > s[2] && s[0] > kMinRed && s[2] < kMaxBlue && s[1] > kMinGreenPerRed * s[0] &&
         s[1] < max_green_per_red * s[0];
}

/// Distance from grey towards orange.
double depth_of(const Color3& color) {
  return (color[0] - color[2]) / std::max(1.0, color.sum());
}

/// Whether the surroundings are carpet, which may be worn, shiny or crossed by a line: wear, shine and lines
/// shift its colour towards white by up to `max_worn`. All colours are chromaticities.
bool is_carpet(const Color3& around, const Color3& carpet, const Color3& white, double max_worn) {
  const Color3 to_white = white - carpet;
  const double worn = (around - carpet).dot(to_white) / std::max(1e-6, to_white.squaredNorm());
  return (around - carpet - std::clamp(worn, 0.0, max_worn) * to_white).norm() < kWornCarpetAlike;
}

/// Colours well inside a ball, highest depth_of() first.
std::vector<Color3> colors_within(const SmallPicture& picture, const Eigen::Vector2d& pixel,
                                  double radius_px) {
  const Eigen::Vector2d middle = picture.cell_of(pixel);
  const double reach = std::max(0.75, 0.75 * radius_px / picture.cell_px() - 0.5);
  std::vector<Color3> colors;
  for (int y = static_cast<int>(middle.y() - reach); y <= middle.y() + reach; ++y) {
    for (int x = static_cast<int>(middle.x() - reach); x <= middle.x() + reach; ++x) {
      if (x < 0 || y < 0 || x >= picture.width() || y >= picture.height()) continue;
      if (std::hypot(x - middle.x(), y - middle.y()) <= reach) colors.push_back(picture.at(x, y));
    }
  }
  std::sort(colors.begin(), colors.end(),
            [](const Color3& a, const Color3& b) { return depth_of(a) > depth_of(b); });
  return colors;
}

Color3 mean_of(std::span<const Color3> colors) {
  Color3 sum = Color3::Zero();
  for (const Color3& color : colors) sum += color;
  return sum / std::max(1.0, static_cast<double>(colors.size()));
}

/// A ball's colour outside its highlight: the mean of the half with the highest depth_of().
Color3 body_of(std::span<const Color3> within) {
  return mean_of(within.first((within.size() + 1) / 2));
}

/// Best fit from several starts, because a spot's position is only accurate to a cell.
BallFit best_fit(BallFitter& fitter, const BallFitter::Frame& frame, const Eigen::Vector2d& place_mm,
                 double cell_mm) {
  BallFit best;
  for (const Eigen::Vector2d& step :
       {Eigen::Vector2d(0, 0), {cell_mm, 0}, {-cell_mm, 0}, {0, cell_mm}, {0, -cell_mm}}) {
    const Eigen::Vector2d start = place_mm + step;
    BallFit fit = fitter.fit(frame, start.x(), start.y());
    if (!fit.ok || (best.ok && fit.r2 <= best.r2)) continue;
    fitter.judge(fit);
    best = fit;
  }
  return best;
}

}  // namespace

std::vector<SeenBall> find_balls(const BallSearch& b) {
  const double radius_mm = b.field.ball_radius;
  const auto in_white_light = [&](const Color3& color) {
    return Color3(color.cwiseQuotient(b.white_chromaticity));
  };
  // Tests both the measured colour and the colour corrected to white light, because the white chromaticity is
  // not exact.
  const auto is_ball_colored = [&](const Color3& color) {
    const double most = color[0] < kClippedRed ? kMaxGreenPerRed : kMaxGreenPerClippedRed;
    const auto limit = [&](const Color3& yellow) {
      return b.yellow ? std::min(most, kOfYellows * yellow[1] / std::max(yellow[0], 1e-6)) : most;
    };
    const Color3 yellow = b.yellow.value_or(Color3::Zero());
    return is_warm(color, limit(yellow)) || is_warm(in_white_light(color), limit(in_white_light(yellow)));
  };
  std::vector<SeenBall> out;
  BallFitter fitter;
  for (std::size_t frame = 0; frame < b.search.frames.size(); ++frame) {
    if (b.search.stop.stop_requested()) return out;
    const ImageView& image = b.search.frames[frame];
    const double area = b.camera.mm2_per_px({image.width / 2.0, image.height / 2.0}, radius_mm);
    if (!(area > 0)) continue;
    const double radius_px = radius_mm / std::sqrt(area);
    const SmallPicture& picture = b.search.pictures[frame].of(cell_px_for(image.format, radius_px));
    const SmallPicture& fine = b.search.pictures[frame].of(cell_px_for(image.format, radius_px / 2));
    std::vector<Robot> robots;
    for (const SeenRobot& robot : b.robots) {
      if (robot.frame != frame) continue;
      robots.push_back({Team::kYellow, 0, robot.pose.x_mm, robot.pose.y_mm, robot.pose.angle_rad,
                        robot.height_mm, robot.pixel_x, robot.pixel_y, 1});
    }
    const BallFitter::Frame to_fit{image,
                                   b.camera,
                                   radius_mm,
                                   robots,
                                   b.search.patterns.top_radius_mm,
                                   b.search.patterns.top_front_mm,
                                   kUsualBlurPx};
    for (const Spot& spot :
         find_spots(picture, radius_px, b.search.noise_grey[frame], SpotsOf::kAnyColor, kMaxBallSpots)) {
      if (b.search.stop.stop_requested()) return out;
      if (!is_ball_colored(body_of(colors_within(fine, spot.pixel, radius_px)))) continue;
      // Off the field, grey may be a floor instead of worn carpet.
      if (!is_carpet(chromaticity_of(spot.around), b.carpet_chromaticity, b.white_chromaticity,
                     b.on_field_only ? kMaxWorn : 0))
        continue;
      const bool on_robot = std::any_of(b.robots.begin(), b.robots.end(), [&](const SeenRobot& robot) {
        return robot.frame == frame &&
               std::hypot(robot.pixel_x - spot.pixel.x(), robot.pixel_y - spot.pixel.y()) <
                   kRobotRadiusMm * robot.px_per_mm;
      });
      if (on_robot) continue;
      const auto place = b.camera.unproject(spot.pixel, radius_mm);
      if (!place) continue;
      if (b.on_field_only && (std::abs(place->x()) > b.field.field_length / 2.0 + kOutsideMm ||
                              std::abs(place->y()) > b.field.field_width / 2.0 + kOutsideMm))
        continue;
      const BallFit fit = best_fit(fitter, to_fit, *place, picture.cell_px() * std::sqrt(area));
      if (!fit.ok || fit.r2 < kMinBallR2 || fit.clear_share < kMinClear || fit.visible_share < kMinVisible)
        continue;
      if (std::abs(fit.radius_mm - radius_mm) > std::max(kMaxRadiusOff * radius_mm, 2 * fit.radius_sigma_mm))
        continue;
      if (fit.out_of_round_mm >
          kMaxOutOfRound * std::hypot(kRoundShare * radius_mm, fit.out_of_round_sigma_mm))
        continue;
      const double like_tape = fitter.rectangle_gain(to_fit, fit);
      if (like_tape > kMaxLikeTape) continue;
      const auto pixel = b.camera.project({fit.x_mm, fit.y_mm, radius_mm});
      if (!pixel) continue;
      const std::vector<Color3> within = colors_within(fine, *pixel, radius_px);
      const Color3 body = body_of(within);
      if (!is_ball_colored(body)) continue;
      if (b.ball_chromaticity && (chromaticity_of(body) - *b.ball_chromaticity).norm() > kOneColor) continue;
      std::vector<Color3> shades{mean_of(within)};
      constexpr std::size_t kManyColors = 24;
      if (within.size() >= kManyColors) {
        const auto all = std::span(std::as_const(within));
        const std::size_t third = within.size() / 3;
        shades = {mean_of(all.first(third)), mean_of(all.subspan(third, third)), mean_of(all.last(third))};
      }
      out.push_back({frame, pixel->x(), pixel->y(), radius_px, body, std::move(shades), fit.r2});
    }
  }
  if (out.empty()) return out;
  // One ball may cause two spots.
  std::sort(out.begin(), out.end(),
            [](const SeenBall& one, const SeenBall& other) { return one.r2 > other.r2; });
  std::vector<SeenBall> kept;
  for (const SeenBall& ball : out) {
    const bool is_duplicate = std::any_of(kept.begin(), kept.end(), [&](const SeenBall& other) {
      return other.frame == ball.frame &&
             std::hypot(other.pixel_x - ball.pixel_x, other.pixel_y - ball.pixel_y) < ball.radius_px;
    });
    if (!is_duplicate) kept.push_back(ball);
  }
  // Brown, beige and skin are paler than a ball's orange. Depth beyond kDeep does not count. Red objects are
  // less likely to be balls: their green is closer to their blue.
  const auto likely = [&](const SeenBall& ball) {
    constexpr double kDeep = 0.4, kMinGreen = 0.2;
    const Color3 white = in_white_light(ball.body);
    const double green = (white[1] - white[2]) / std::max(1e-6, white[0] - white[2]);
    return ball.r2 + 2 * std::min(depth_of(ball.body), kDeep) - 2 * std::max(0.0, kMinGreen - green);
  };
  const auto best = std::max_element(
      kept.begin(), kept.end(),
      [&](const SeenBall& one, const SeenBall& other) { return likely(one) < likely(other); });
  const Color3 likeliest = chromaticity_of(best->body);
  std::erase_if(kept, [&](const SeenBall& ball) {
    return (chromaticity_of(ball.body) - likeliest).norm() > kOneColor;
  });
  return kept;
}

}  // namespace sslv
