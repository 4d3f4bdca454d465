// SPDX-License-Identifier: Apache-2.0
#include "replay/compare_clip.h"

#include <gmock/gmock.h>

namespace sslv::compare_clip_test {
namespace {

Robot robot_at(Team team, int id, double x_mm, double y_mm, double angle_rad = 0) {
  return {team, id, x_mm, y_mm, angle_rad, 140, 0, 0, 1};
}

Ball ball_at(double x_mm, double y_mm) {
  return {x_mm, y_mm, 0, 0, 20, 1};
}

std::vector<std::byte> packet_of(const std::vector<Robot>& robots, const std::vector<Ball>& balls = {}) {
  SSL_WrapperPacket packet;
  write_detection({.camera_id = 0, .number = 17, .times = {.t_capture_s = 5}}, {robots}, {balls}, 6, packet);
  std::vector<std::byte> bytes;
  serialize(packet, bytes);
  return bytes;
}

Json only_difference(const std::vector<std::byte>& before, const std::vector<std::byte>& after,
                     const CompareLimits& limits = {}) {
  ClipComparison comparison(limits);
  comparison.add(before, after);
  const Json json = comparison_json(comparison);
  if (json["differences"].empty() || json["differences"][0]["what"].size() != 1) return json;
  EXPECT_EQ(json["differences"][0]["frame"], 17);
  return json["differences"][0]["what"][0];
}

TEST(ClipComparisons, AreEmptyForEqualPackets) {
  const auto packet = packet_of({robot_at(Team::kBlue, 3, 10, 20)}, {ball_at(1, 2)});
  ClipComparison comparison;
  comparison.add(packet, packet);
  EXPECT_EQ(comparison.frames(), 1u);
  EXPECT_EQ(comparison.frames_with_other_bytes(), 0u);
  EXPECT_EQ(comparison.frames_that_differ(), 0u);
  EXPECT_TRUE(comparison.different_frames().empty());
  EXPECT_EQ(comparison.robots().before, 1u);
}

TEST(ClipComparisons, TellWhatIsFoundAndLost) {
  const auto none = packet_of({}), robot = packet_of({robot_at(Team::kYellow, 3, 10, 20)});
  EXPECT_EQ(only_difference(none, robot),
            Json::parse(R"({"kind": "found", "team": "yellow", "id": 3, "x": 10.0, "y": 20.0})"));
  EXPECT_EQ(only_difference(robot, none),
            Json::parse(R"({"kind": "lost", "team": "yellow", "id": 3, "x": 10.0, "y": 20.0})"));
  EXPECT_EQ(only_difference({}, packet_of({}, {ball_at(1, 2)})),
            Json::parse(R"({"kind": "found", "x": 1.0, "y": 2.0})"));
}

TEST(ClipComparisons, TellWhatMovedByMoreThanTheLimits) {
  const auto before = packet_of({robot_at(Team::kBlue, 3, 0, 0, 3.14)});
  const auto near = packet_of({robot_at(Team::kBlue, 3, 0.75, 0, -3.14)});
  const Json below = only_difference(before, near);
  EXPECT_EQ(below["frames_that_differ"], 0);
  EXPECT_EQ(below["frames_with_other_bytes"], 1);
  EXPECT_EQ(below["robots"]["max_moved_mm"], 0.75);
  EXPECT_NEAR(below["robots"]["max_turned_deg"].get<double>(), 0.18, 0.01);
  EXPECT_EQ(only_difference(before, near, {.moved_mm = 0.5})["kind"], "moved");
  EXPECT_EQ(only_difference(before, near, {.moved_mm = 1, .turned_deg = 0.1})["kind"], "moved");
  const auto ball = packet_of({}, {ball_at(0, 0)});
  EXPECT_EQ(only_difference(ball, packet_of({}, {ball_at(60, 80)}))["moved_mm"], 100);
  EXPECT_EQ(only_difference(ball, packet_of({}, {ball_at(60, 81)}))["balls"]["lost"], 1);
}

TEST(ClipComparisons, TellAnotherId) {
  const Json json = only_difference(packet_of({robot_at(Team::kBlue, 3, 0, 0)}),
                                    packet_of({robot_at(Team::kBlue, 5, 0.25, 0)}));
  EXPECT_EQ(json["kind"], "id_changed");
  EXPECT_EQ(json["id"], 5);
  EXPECT_EQ(json["id_before"], 3);
  // A robot of the other team is a different robot.
  EXPECT_EQ(only_difference(packet_of({robot_at(Team::kBlue, 3, 0, 0)}),
                            packet_of({robot_at(Team::kYellow, 3, 0, 0)}))["robots"]["lost"],
            1);
}

TEST(ClipComparisons, MatchByIdBeforePlace) {
  const auto before = packet_of({robot_at(Team::kBlue, 1, 0, 0), robot_at(Team::kBlue, 2, 95, 0)});
  const auto after = packet_of({robot_at(Team::kBlue, 1, 50, 0), robot_at(Team::kBlue, 2, 1, 0)});
  ClipComparison comparison;
  comparison.add(before, after);
  EXPECT_EQ(comparison.robots().moved, 2u);
  EXPECT_EQ(comparison.robots().id_changed, 0u);
}

TEST(ClipComparisons, TreatInvalidPacketsAsEmpty) {
  const std::vector<std::byte> damaged(30, std::byte{0xFF});
  EXPECT_EQ(only_difference(damaged, packet_of({robot_at(Team::kBlue, 3, 0, 0)}))["kind"], "found");
}

}  // namespace
}  // namespace sslv::compare_clip_test
