// SPDX-License-Identifier: Apache-2.0
// Detectors on regions made from known places, so without pixels between truth and result.
#include "vision/detect_balls.h"
#include "vision/detect_robots.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>

namespace sslv {
namespace {

CameraCalibration overhead_camera() {
  CameraCalibration c;
  c.focal_length = 600;
  c.principal_point_x = 389.5, c.principal_point_y = 289.5;
  c.distortion = 0.1;
  c.q0 = std::numbers::sqrt2 / 2, c.q1 = -std::numbers::sqrt2 / 2, c.q2 = 0, c.q3 = 0;
  c.tx = 0, c.ty = 1250, c.tz = 3500;  // above (1250, 0)
  c.pixel_image_width = 780, c.pixel_image_height = 580;
  return c;
}

class Detect : public ::testing::Test {
 protected:
  Detect() { scene_.camera.emplace(overhead_camera()); }

  /// A blob of exactly the area a disc at this place and height has.
  void add_disc(Label label, double x_mm, double y_mm, double z_mm, double diameter_mm,
                double area_factor = 1) {
    const auto pixel = scene_.camera->project({x_mm, y_mm, z_mm});
    ASSERT_TRUE(pixel);
    const double area_mm2 = std::numbers::pi * diameter_mm * diameter_mm / 4;
    const auto area = static_cast<std::uint32_t>(
        std::max(1.0, area_factor * area_mm2 / scene_.camera->mm2_per_px(*pixel, z_mm)));
    const auto half = static_cast<int>(std::lround(std::sqrt(area / std::numbers::pi)));
    const auto edge = [](double center, int by) {
      return static_cast<std::uint16_t>(std::lround(center) + by);
    };
    regions_.push_back({label, area, edge(pixel->x(), -half), edge(pixel->y(), -half), edge(pixel->x(), half),
                        edge(pixel->y(), half), static_cast<float>(pixel->x()),
                        static_cast<float>(pixel->y()), 0});
  }

  void add_robot(Team team, int id, double x_mm, double y_mm, double angle_rad,
                 std::size_t without_dot = 99) {
    const double z_mm = scene_.height_of(team);
    add_disc(team == Team::kBlue ? label::kBlue : label::kYellow, x_mm, y_mm, z_mm, 50);
    const PatternTable& table = league_patterns();
    for (std::size_t i = 0; i < table.dots.size(); ++i) {
      if (i == without_dot) continue;
      const PatternDot& dot = table.dots[i];
      add_disc(table.codes[static_cast<std::size_t>(id)].colors[i],
               x_mm + std::cos(angle_rad) * dot.x_mm - std::sin(angle_rad) * dot.y_mm,
               y_mm + std::sin(angle_rad) * dot.x_mm + std::cos(angle_rad) * dot.y_mm, z_mm, 40);
    }
  }

  RegionList sorted() {
    RegionList list;
    list.regions = regions_;
    std::stable_sort(list.regions.begin(), list.regions.end(), [](const Region& a, const Region& b) {
      return a.label != b.label ? a.label < b.label : a.area_px > b.area_px;
    });
    for (const Region& region : list.regions) ++list.begin[region.label + 1U];
    for (std::size_t l = 1; l < list.begin.size(); ++l) list.begin[l] += list.begin[l - 1];
    return list;
  }
  std::vector<Robot> robots() {
    RobotList out;
    DetectRobots().process({}, scene_, league_patterns(), sorted(), out);
    return out.robots;
  }
  std::vector<Ball> balls(const RobotList& robots = {}) {
    BallList out;
    DetectBalls().process({}, scene_, sorted(), robots, out);
    return out.balls;
  }

  Scene scene_;
  std::vector<Region> regions_;
};

TEST_F(Detect, EveryIdOfBothTeamsAtAnyHeading) {
  scene_.robot_height_mm = {120, 150};
  for (const Team team : {Team::kYellow, Team::kBlue}) {
    for (int id = 0; id < 16; ++id) {
      for (const double angle : {-3.0, -1.2, 0.0, 0.7, 2.5, 3.14}) {
        regions_.clear();
        add_robot(team, id, 1800, -700, angle);
        const auto found = robots();
        ASSERT_EQ(found.size(), 1u) << id << " at " << angle;
        EXPECT_EQ(found[0].team, team);
        EXPECT_EQ(found[0].id, id);
        EXPECT_NEAR(found[0].x_mm, 1800, 0.01);
        EXPECT_NEAR(found[0].y_mm, -700, 0.01);
        EXPECT_NEAR(std::remainder(found[0].orientation_rad - angle, 2 * std::numbers::pi), 0, 1e-4);
        EXPECT_EQ(found[0].height_mm, scene_.height_of(team));
        EXPECT_GT(found[0].confidence, 0.95);
        EXPECT_LE(found[0].confidence, 1.0);
      }
    }
  }
}

TEST_F(Detect, NeighboursKeepTheirDots) {
  add_robot(Team::kYellow, 3, 1000, 0, 0.3);
  add_robot(Team::kBlue, 7, 1000, 182, -2.0);
  add_robot(Team::kYellow, 11, 1182, 0, 1.5);
  const auto found = robots();
  ASSERT_EQ(found.size(), 3u);
  for (const Robot& robot : found) {
    const double y = robot.team == Team::kBlue ? 182 : 0, x = robot.id == 11 ? 1182 : 1000;
    EXPECT_NEAR(std::hypot(robot.x_mm - x, robot.y_mm - y), 0, 0.01) << robot.id;
    EXPECT_TRUE(robot.id == 3 || robot.id == 7 || robot.id == 11);
  }
}

TEST_F(Detect, NoRobotWithoutAllFourDots) {
  for (std::size_t dot = 0; dot < 4; ++dot) {
    regions_.clear();
    add_robot(Team::kBlue, 5, 1500, 500, 1.0, dot);
    EXPECT_TRUE(robots().empty()) << "without dot " << dot;
  }
}

TEST_F(Detect, AnIdIsReportedOncePerTeam) {
  add_robot(Team::kBlue, 5, 500, 500, 1.0);
  add_robot(Team::kBlue, 5, 1500, 500, 1.0);
  add_robot(Team::kYellow, 5, 1500, -500, 1.0);
  EXPECT_EQ(robots().size(), 2u);
}

TEST_F(Detect, SpecksAroundARobotDoNotHarm) {
  add_robot(Team::kBlue, 9, 1500, 500, 1.0);
  add_disc(label::kPink, 1530, 520, 140, 12);
  add_disc(label::kGreen, 1470, 560, 140, 15);
  const auto found = robots();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].id, 9);
}

TEST_F(Detect, NothingWithoutACalibration) {
  add_robot(Team::kBlue, 9, 1500, 500, 1.0);
  add_disc(label::kOrange, 1000, 0, 21.5, 43);
  scene_.camera.reset();
  EXPECT_TRUE(robots().empty());
  EXPECT_TRUE(balls().empty());
}

TEST_F(Detect, BallLiesOnThePlaneOfItsCentre) {
  add_disc(label::kOrange, 2000, -1500, 21.5, 43);
  const auto found = balls();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].x_mm, 2000, 0.01);
  EXPECT_NEAR(found[0].y_mm, -1500, 0.01);
}

TEST_F(Detect, NoBallOfTheWrongSizePlaceOrOnARobot) {
  add_disc(label::kOrange, 1000, 0, 21.5, 43, 0.2);
  add_disc(label::kOrange, 1200, 0, 21.5, 43, 4);
  scene_.field.field_width = 2000;
  add_disc(label::kOrange, 1400, 1500, 21.5, 43);
  add_disc(label::kOrange, 1600, 0, 140, 43);
  Robot robot{};
  robot.x_mm = 1600;
  robot.height_mm = 140;
  EXPECT_TRUE(balls({{robot}}).empty());
  EXPECT_EQ(balls().size(), 1u) << "the one at 1600 is a ball when no robot is there";
}

}  // namespace
}  // namespace sslv
