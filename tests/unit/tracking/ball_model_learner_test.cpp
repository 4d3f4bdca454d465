// SPDX-License-Identifier: Apache-2.0
#include "tracking/ball_model_learner.h"

#include "ours.h"
#include "world.h"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

namespace sslv::ball_model_learner_test {
namespace {

/// The shot as two cameras see it alternately, 75 times a second each, with small noise that is the same in
/// every run.
WatchedKick watched(const BallShot& shot, const BallModel& truth, double seconds) {
  WatchedKick out;
  out.kick.number = 1;
  out.kick.t_s = shot.t_s + 0.001;
  out.kick.place_mm = shot.place_mm + Eigen::Vector2d(2, -1);
  out.kick.velocity_mm_s = shot.velocity_mm_s * 1.02;
  out.kick.is_chip = shot.is_chip();
  unsigned random = 1;
  const auto noise = [&random] {
    random = random * 1664525U + 1013904223U;
    return 0.6 * (static_cast<double>(random >> 8) / (1U << 24) - 0.5);
  };
  const std::array<Eigen::Vector3d, 2> cameras{Eigen::Vector3d(-2000, 0, 4500),
                                               Eigen::Vector3d(2000, 500, 5000)};
  int i = 0;
  for (double t_s = shot.t_s + 0.012; t_s < shot.t_s + seconds; t_s += 1.0 / 150, ++i) {
    const Eigen::Vector3d place = shot.at(t_s, truth).place_mm,
                          camera = cameras[static_cast<std::size_t>(i % 2)];
    const double share = (camera.z() - truth.radius_mm) / (camera.z() - place.z());
    const double x = noise(), y = noise();
    const Eigen::Vector2d seen =
        camera.head<2>() + (place.head<2>() - camera.head<2>()) * share + Eigen::Vector2d(x, y);
    out.points.push_back({t_s, camera, seen});
  }
  return out;
}

BallModel other_model() {
  BallModel out;
  out.slides_mm_s2 = 4300;
  out.rolls_mm_s2 = 250;
  out.rolls_from_share = 0.66;
  out.first_hop_xy = 0.62;
  out.later_hops_xy = 0.9;
  out.hops_z = 0.5;
  return out;
}

TEST(BallModelLearner, LearnsHowABallSlidesAndRolls) {
  BallModelLearner learner;
  for (int i = 0; i < 6; ++i) {
    const double angle = i;
    learner.learn(
        watched({.t_s = 100.0 + i,
                 .place_mm = {-1000, 200.0 * i},
                 .velocity_mm_s = Eigen::Vector3d(std::cos(angle), std::sin(angle), 0) * (2500 + 500 * i)},
                other_model(), 2.5),
        BallModel{});
  }
  const LearntBallModel& learnt = learner.learnt();
  EXPECT_EQ(learnt.kicks, 6);
  EXPECT_EQ(learnt.chips, 0);
  EXPECT_NEAR(learnt.slides_mm_s2.value, 4300, 0.03 * 4300);
  EXPECT_NEAR(learnt.rolls_mm_s2.value, 250, 0.03 * 250);
  EXPECT_NEAR(learnt.rolls_from_share.value, 0.66, 0.03 * 0.66);
  EXPECT_GT(learnt.slides_mm_s2.sigma, 0);
  EXPECT_FALSE(learnt.hops_z.is_known());
}

TEST(BallModelLearner, LearnsHowABallHops) {
  BallModelLearner learner;
  for (int i = 0; i < 6; ++i) {
    const double angle = i;
    learner.learn(
        watched({.t_s = 100.0 + i,
                 .place_mm = {0, 100.0 * i},
                 .velocity_mm_s = {2500 * std::cos(angle), 2500 * std::sin(angle), 3000 + 200.0 * i}},
                other_model(), 2),
        BallModel{});
  }
  const LearntBallModel& learnt = learner.learnt();
  EXPECT_EQ(learnt.chips, 6);
  EXPECT_NEAR(learnt.first_hop_xy.value, 0.62, 0.03 * 0.62);
  EXPECT_NEAR(learnt.later_hops_xy.value, 0.9, 0.03 * 0.9);
  EXPECT_NEAR(learnt.hops_z.value, 0.5, 0.03 * 0.5);
}

TEST(BallModelLearner, IsNotMisledByABallThatMetSomething) {
  BallModelLearner learner;
  for (int i = 0; i < 9; ++i) {
    WatchedKick kick = watched(
        {.t_s = 100.0 + i, .place_mm = {-1000, 200.0 * i}, .velocity_mm_s = {3000.0 + 200 * i, 300, 0}},
        other_model(), 2.5);
    if (i % 3 == 0) {  // deflected on its way
      for (std::size_t p = kick.points.size() / 2; p < kick.points.size(); ++p)
        kick.points[p].place_mm.y() += 3.0 * static_cast<double>(p - kick.points.size() / 2);
    }
    learner.learn(kick, BallModel{});
  }
  EXPECT_NEAR(learner.learnt().rolls_mm_s2.value, 250, 0.03 * 250);
  EXPECT_NEAR(learner.learnt().slides_mm_s2.value, 4300, 0.03 * 4300);
}

TEST(BallModelLearner, ReportsNoUnobservedParameters) {
  BallModelLearner learner;
  for (int i = 0; i < 5; ++i) {  // no longer seen, long before it rolls
    learner.learn(
        watched({.t_s = 100.0 + i, .place_mm = {0, 0}, .velocity_mm_s = {6000, 0, 0}}, other_model(), 0.3),
        BallModel{});
  }
  EXPECT_FALSE(learner.learnt().rolls_mm_s2.is_known());
  EXPECT_EQ(learner.learnt().kicks, 0);
}

TEST(KickWatch, DeliversTheObservedKicks) {
  worlds::WorldOptions options;
  options.seed = 31;
  options.duration_s = 20;
  const worlds::World world(options);
  worlds::Ours ours;
  KickWatch watch;
  TrackedField tracked;
  int count = 0;
  for (const worlds::WorldImage& image : world.images()) {
    ours.add(image);
    ours.tracker().at(image.arrival_s, tracked);
    const WatchedKick* kick = watch.add(ours.observations(), tracked);
    if (!kick) continue;
    ++count;
    EXPECT_LE(kick->points.size(), WatchedKick::kMaxPoints);
    for (std::size_t i = 1; i < kick->points.size(); ++i)
      EXPECT_GT(kick->points[i].t_s, kick->points[i - 1].t_s);
  }
  EXPECT_GT(count, 0);
}

}  // namespace
}  // namespace sslv::ball_model_learner_test
