// SPDX-License-Identifier: Apache-2.0
#include "net/packets.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>

#include <gmock/gmock.h>

namespace sslv::packets_test {
namespace {

using testing::ElementsAre;

/// "0a ff" as bytes. The expected bytes below are encoded by hand: a tag is (field << 3 | wire type), with
/// wire type 0 varint, 1 eight bytes, 2 length and content, 5 four bytes.
std::string bytes(const std::string& hex) {
  std::istringstream in(hex);
  std::string out, byte;
  while (in >> byte) out += static_cast<char>(std::stoi(byte, nullptr, 16));
  return out;
}

std::string text(std::span<const std::byte> data) {
  return {reinterpret_cast<const char*>(data.data()), data.size()};
}

Robot robot(Team team, double confidence) {
  return {.team = team,
          .id = 7,
          .x_mm = 1000,
          .y_mm = -500,
          .orientation_rad = 1.5,
          .height_mm = 140,
          .pixel_x = 390,
          .pixel_y = 290.5,
          .confidence = confidence};
}

Ball ball(double confidence) {
  return {.x_mm = -1500.5, .y_mm = 0, .pixel_x = 10, .pixel_y = 20, .area_px = 40, .confidence = confidence};
}

/// Mounted upside down at (1000, 1250, 3500) mm, looking straight down.
CameraModel camera() {
  CameraCalibration c;
  c.focal_length = 600;
  c.principal_point_x = 390;
  c.principal_point_y = 290;
  c.distortion = 0.125;
  c.q0 = 1;
  c.q3 = 0;
  c.tx = -1000;
  c.ty = 1250;
  c.tz = 3500;
  c.pixel_image_width = 780;
  c.pixel_image_height = 580;
  return CameraModel(c);
}

TEST(Packets, DetectionBytes) {
  const FrameInfo info{.camera_id = 3, .number = 300, .times = {1000.5, 2.25}};
  Robot blue{};
  blue.team = Team::kBlue;
  blue.height_mm = 150;
  blue.confidence = 1;
  SSL_WrapperPacket packet;
  std::vector<std::byte> buffer;
  write_detection(info, {{robot(Team::kYellow, 0.75), blue}}, {{ball(1)}}, 1000.75, packet);
  EXPECT_EQ(text(serialize(packet, buffer)),
            bytes("0a 8b 01"                      // wrapper: detection, 139 bytes
                  "  08 ac 02"                    // frame_number 300
                  "  11 00 00 00 00 00 44 8f 40"  // t_capture 1000.5
                  "  19 00 00 00 00 00 46 8f 40"  // t_sent 1000.75
                  "  20 03"                       // camera_id 3
                  "  2a 1b"                       // balls, 27 bytes
                  "    0d 00 00 80 3f"            // confidence 1
                  "    10 28"                     // area 40
                  "    1d 00 90 bb c4"            // x -1500.5
                  "    25 00 00 00 00"            // y 0
                  "    35 00 00 20 41"            // pixel_x 10
                  "    3d 00 00 a0 41"            // pixel_y 20
                  "  32 25"                       // robots_yellow, 37 bytes
                  "    0d 00 00 40 3f"            // confidence 0.75
                  "    10 07"                     // robot_id 7
                  "    1d 00 00 7a 44"            // x 1000
                  "    25 00 00 fa c3"            // y -500
                  "    2d 00 00 c0 3f"            // orientation 1.5
                  "    35 00 00 c3 43"            // pixel_x 390
                  "    3d 00 40 91 43"            // pixel_y 290.5
                  "    45 00 00 0c 43"            // height 140
                  "  3a 25"                       // robots_blue, 37 bytes
                  "    0d 00 00 80 3f"            // confidence 1
                  "    10 00"                     // robot_id 0, sent although it is 0
                  "    1d 00 00 00 00"            // x
                  "    25 00 00 00 00"            // y
                  "    2d 00 00 00 00"            // orientation
                  "    35 00 00 00 00"            // pixel_x
                  "    3d 00 00 00 00"            // pixel_y
                  "    45 00 00 16 43"            // height 150
                  "  41 00 00 00 00 00 00 02 40"  // t_capture_camera 2.25
                  " 18 01"));                     // wrapper: source OTHER
}

TEST(Packets, EmptyDetectionBytes) {
  SSL_WrapperPacket packet;
  std::vector<std::byte> buffer;
  write_detection({.camera_id = 0, .number = 1, .times = {0}}, {}, {}, 2, packet);
  EXPECT_EQ(text(serialize(packet, buffer)), bytes("0a 16"
                                                   "  08 01"                       // frame_number 1
                                                   "  11 00 00 00 00 00 00 00 00"  // t_capture 0
                                                   "  19 00 00 00 00 00 00 00 40"  // t_sent 2
                                                   "  20 00"                       // camera_id 0
                                                   " 18 01"));
}

TEST(Packets, GeometryBytes) {
  Geometry geometry;
  geometry.field.boundary_width_goal_line = 250;
  geometry.cameras.push_back({2, camera()});
  geometry.ball_models = BallModels{-3.5, -0.5, 0.625, 0.5, 0.875, 0.5625};
  SSL_WrapperPacket packet;
  write_geometry(geometry, packet);

  SSL_GeometryFieldSize& field = *packet.mutable_geometry()->mutable_field();
  ASSERT_GE(field.field_lines_size(), 1);
  EXPECT_EQ(field.field_lines(0).SerializeAsString(),
            bytes("0a 0c 54 6f 70 54 6f 75 63 68 4c 69 6e 65"  // name TopTouchLine
                  " 12 0a 0d 00 a0 8c c5 15 00 80 3b 45"       // p1 -4500, 3000
                  " 1a 0a 0d 00 a0 8c 45 15 00 80 3b 45"       // p2 4500, 3000
                  " 25 00 00 20 41"                            // thickness 10
                  " 28 02"));                                  // type TopTouchLine
  ASSERT_EQ(field.field_arcs_size(), 1);
  EXPECT_EQ(field.field_arcs(0).SerializeAsString(),
            bytes("0a 0c 43 65 6e 74 65 72 43 69 72 63 6c 65"  // name CenterCircle
                  " 12 0a 0d 00 00 00 00 15 00 00 00 00"       // center 0, 0
                  " 1d 00 00 fa 43"                            // radius 500
                  " 25 00 00 00 00"                            // a1 0
                  " 2d db 0f c9 40"                            // a2 2 pi
                  " 35 00 00 20 41"                            // thickness 10
                  " 38 01"));                                  // type CenterCircle

  field.clear_field_lines();
  field.clear_field_arcs();
  EXPECT_EQ(packet.SerializeAsString(),
            bytes("12 c2 01"                          // wrapper: geometry, 194 bytes
                  "  0a 32"                           // field, 50 bytes
                  "    08 a8 46"                      // field_length 9000
                  "    10 f0 2e"                      // field_width 6000
                  "    18 e8 07"                      // goal_width 1000
                  "    20 b4 01"                      // goal_depth 180
                  "    28 ac 02"                      // boundary_width 300
                  "    40 e8 07"                      // penalty_area_depth 1000
                  "    48 d0 0f"                      // penalty_area_width 2000
                  "    50 f4 03"                      // center_circle_radius 500
                  "    58 0a"                         // line_thickness 10
                  "    60 f0 2e"                      // goal_center_to_penalty_mark 6000
                  "    68 a0 01"                      // goal_height 160
                  "    75 00 00 ac 41"                // ball_radius 21.5
                  "    7d 00 00 b4 42"                // max_robot_radius 90
                  "    80 01 fa 01"                   // boundary_width_goal_line 250
                  "    88 01 ac 02"                   // goal_substitution_area_width 300
                  "  12 50"                           // calib, 80 bytes
                  "    08 02"                         // camera_id 2
                  "    15 00 00 16 44"                // focal_length 600
                  "    1d 00 00 c3 43"                // principal_point_x 390
                  "    25 00 00 91 43"                // principal_point_y 290
                  "    2d 00 00 00 3e"                // distortion 0.125
                  "    35 00 00 80 3f"                // q0 1
                  "    3d 00 00 00 00"                // q1
                  "    45 00 00 00 00"                // q2
                  "    4d 00 00 00 00"                // q3
                  "    55 00 00 7a c4"                // tx -1000
                  "    5d 00 40 9c 44"                // ty 1250
                  "    65 00 c0 5a 45"                // tz 3500
                  "    6d 00 00 7a 44"                // derived_camera_world_tx 1000
                  "    75 00 40 9c 44"                // derived_camera_world_ty 1250
                  "    7d 00 c0 5a 45"                // derived_camera_world_tz 3500
                  "    80 01 8c 06"                   // pixel_image_width 780
                  "    88 01 c4 04"                   // pixel_image_height 580
                  "  1a 3a"                           // models, 58 bytes
                  "    0a 1b"                         // straight_two_phase, 27 bytes
                  "      09 00 00 00 00 00 00 0c c0"  // acc_slide -3.5
                  "      11 00 00 00 00 00 00 e0 bf"  // acc_roll -0.5
                  "      19 00 00 00 00 00 00 e4 3f"  // k_switch 0.625
                  "    12 1b"                         // chip_fixed_loss, 27 bytes
                  "      09 00 00 00 00 00 00 e0 3f"  // damping_xy_first_hop 0.5
                  "      11 00 00 00 00 00 00 ec 3f"  // damping_xy_other_hops 0.875
                  "      19 00 00 00 00 00 00 e2 3f"  // damping_z 0.5625
                  " 18 01"));                         // wrapper: source OTHER
}

TEST(Packets, GeometryHasEveryLineOfTheLeagueWithItsType) {
  SSL_WrapperPacket packet;
  write_geometry({}, packet);
  std::vector<int> types;
  for (const auto& line : packet.geometry().field().field_lines()) {
    EXPECT_EQ(SSL_FieldShapeType_Name(line.type()), line.name());
    types.push_back(line.type());
  }
  EXPECT_THAT(types, testing::UnorderedElementsAre(2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13));
}

TEST(Packets, GivenLinesAreSentAsTheyAreTypedByTheirNames) {
  Geometry geometry;
  geometry.field.field_lines = {{"LeftGoalLine", -4400, -2900, -4410, 2905}, {"Tape", 1, 2, 3, 4, 25}};
  geometry.field.field_arcs = {{"CenterCircle", 1, 2, 490, -1, 1}, {"Corner", 4500, 3000, 100, 3, 4.5}};
  SSL_WrapperPacket packet;
  write_geometry(geometry, packet);
  const SSL_GeometryFieldSize& field = packet.geometry().field();
  ASSERT_EQ(field.field_lines_size(), 2);
  EXPECT_EQ(field.field_lines(0).type(), LeftGoalLine);
  EXPECT_EQ(field.field_lines(0).p1().x(), -4400);
  EXPECT_EQ(field.field_lines(0).thickness(), 10);
  EXPECT_EQ(field.field_lines(1).name(), "Tape");
  EXPECT_TRUE(field.field_lines(1).has_type());
  EXPECT_EQ(field.field_lines(1).type(), Undefined);
  EXPECT_EQ(field.field_lines(1).thickness(), 25);
  ASSERT_EQ(field.field_arcs_size(), 2);
  EXPECT_EQ(field.field_arcs(0).type(), CenterCircle);
  EXPECT_EQ(field.field_arcs(0).radius(), 490);
  EXPECT_EQ(field.field_arcs(1).type(), Undefined);
}

/// Paths of all unset fields, such as "geometry.field.goal_height".
std::vector<std::string> absent_fields(const google::protobuf::Message& message, const std::string& path) {
  std::vector<std::string> absent;
  const auto* reflection = message.GetReflection();
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const auto* field = message.GetDescriptor()->field(i);
    const std::string here = path + "." + field->name();
    if (field->is_repeated() ? reflection->FieldSize(message, field) == 0
                             : !reflection->HasField(message, field)) {
      absent.push_back(here);
      continue;
    }
    if (field->message_type() == nullptr) continue;
    std::vector<const google::protobuf::Message*> parts;
    if (field->is_repeated()) {
      for (int k = 0; k < reflection->FieldSize(message, field); ++k)
        parts.push_back(&reflection->GetRepeatedMessage(message, field, k));
    } else {
      parts.push_back(&reflection->GetMessage(message, field));
    }
    for (const auto* part : parts) {
      for (std::string& one : absent_fields(*part, here)) absent.push_back(std::move(one));
    }
  }
  return absent;
}

TEST(Packets, AReceiverReadsEveryFieldOfTheGeometryAsItWasWritten) {
  FieldSize f;  // all numbers differ
  f.field_length = 9001;
  f.field_width = 6002;
  f.goal_width = 1003;
  f.goal_depth = 184;
  f.goal_height = 165;
  f.boundary_width = 306;
  f.boundary_width_goal_line = 307;
  f.goal_substitution_area_width = 408;
  f.penalty_area_depth = 1009;
  f.penalty_area_width = 2010;
  f.center_circle_radius = 511;
  f.line_thickness = 12;
  f.goal_center_to_penalty_mark = 6013;
  f.ball_radius = 21.25;
  f.max_robot_radius = 89.5;
  const BallModels models{-3.5, -0.5, 0.625, 0.5, 0.875, 0.5625};
  SSL_WrapperPacket written, read;
  std::vector<std::byte> buffer;
  write_geometry({.field = f, .cameras = {{7, camera()}}, .ball_models = models}, written);
  const auto wire = serialize(written, buffer);
  ASSERT_TRUE(read.ParseFromArray(wire.data(), static_cast<int>(wire.size())));

  EXPECT_THAT(absent_fields(read.geometry(), "geometry"), testing::IsEmpty());
  const SSL_GeometryFieldSize& field = read.geometry().field();
  EXPECT_EQ(field.field_length(), 9001);
  EXPECT_EQ(field.field_width(), 6002);
  EXPECT_EQ(field.goal_width(), 1003);
  EXPECT_EQ(field.goal_depth(), 184);
  EXPECT_EQ(field.goal_height(), 165);
  EXPECT_EQ(field.boundary_width(), 306);
  EXPECT_EQ(field.boundary_width_goal_line(), 307);
  EXPECT_EQ(field.goal_substitution_area_width(), 408);
  EXPECT_EQ(field.penalty_area_depth(), 1009);
  EXPECT_EQ(field.penalty_area_width(), 2010);
  EXPECT_EQ(field.center_circle_radius(), 511);
  EXPECT_EQ(field.line_thickness(), 12);
  EXPECT_EQ(field.goal_center_to_penalty_mark(), 6013);
  EXPECT_EQ(field.ball_radius(), 21.25F);
  EXPECT_EQ(field.max_robot_radius(), 89.5F);
  const auto lines = field_lines(f);
  ASSERT_EQ(field.field_lines_size(), static_cast<int>(lines.size()));
  for (int i = 0; i < field.field_lines_size(); ++i) {
    const FieldLine& line = lines[static_cast<std::size_t>(i)];
    const SSL_FieldLineSegment& segment = field.field_lines(i);
    EXPECT_EQ(segment.name(), line.name);
    EXPECT_EQ(SSL_FieldShapeType_Name(segment.type()), line.name);
    EXPECT_THAT((std::array<double, 5>{segment.p1().x(), segment.p1().y(), segment.p2().x(), segment.p2().y(),
                                       segment.thickness()}),
                ElementsAre(line.x1, line.y1, line.x2, line.y2, 12));
  }
  ASSERT_EQ(field.field_arcs_size(), 1);
  const SSL_FieldCircularArc& arc = field.field_arcs(0);
  EXPECT_EQ(arc.name(), "CenterCircle");
  EXPECT_EQ(arc.type(), CenterCircle);
  EXPECT_THAT((std::array<float, 6>{arc.center().x(), arc.center().y(), arc.radius(), arc.a1(), arc.a2(),
                                    arc.thickness()}),
              ElementsAre(0, 0, 511, 0, static_cast<float>(2 * std::numbers::pi), 12));

  ASSERT_EQ(read.geometry().calib_size(), 1);
  const SSL_GeometryCameraCalibration& calib = read.geometry().calib(0);
  EXPECT_EQ(calib.camera_id(), 7U);
  EXPECT_EQ(calib.focal_length(), 600);
  EXPECT_EQ(calib.principal_point_x(), 390);
  EXPECT_EQ(calib.principal_point_y(), 290);
  EXPECT_EQ(calib.distortion(), 0.125F);
  EXPECT_THAT((std::array<float, 4>{calib.q0(), calib.q1(), calib.q2(), calib.q3()}),
              ElementsAre(1, 0, 0, 0));
  EXPECT_THAT((std::array<float, 3>{calib.tx(), calib.ty(), calib.tz()}), ElementsAre(-1000, 1250, 3500));
  EXPECT_EQ(calib.derived_camera_world_tx(), 1000);
  EXPECT_EQ(calib.derived_camera_world_ty(), 1250);
  EXPECT_EQ(calib.derived_camera_world_tz(), 3500);
  EXPECT_EQ(calib.pixel_image_width(), 780U);
  EXPECT_EQ(calib.pixel_image_height(), 580U);

  const SSL_BallModelStraightTwoPhase& straight = read.geometry().models().straight_two_phase();
  EXPECT_THAT((std::array{straight.acc_slide(), straight.acc_roll(), straight.k_switch()}),
              ElementsAre(-3.5, -0.5, 0.625));
  const SSL_BallModelChipFixedLoss& chip = read.geometry().models().chip_fixed_loss();
  EXPECT_THAT((std::array{chip.damping_xy_first_hop(), chip.damping_xy_other_hops(), chip.damping_z()}),
              ElementsAre(0.5, 0.875, 0.5625));
}

TEST(Packets, GeometryWithSeveralCamerasAndWithoutWhatIsUnknown) {
  CameraCalibration unknown_size;
  unknown_size.q0 = std::numbers::sqrt2 / 2;  // the protocol's numeric check
  unknown_size.q1 = -std::numbers::sqrt2 / 2;
  unknown_size.q3 = 0;
  unknown_size.ty = 1250;
  unknown_size.tz = 3500;
  SSL_WrapperPacket packet;
  write_geometry({.field = {}, .cameras = {{4, camera()}, {9, CameraModel(unknown_size)}}}, packet);
  EXPECT_FALSE(packet.geometry().has_models());
  ASSERT_EQ(packet.geometry().calib_size(), 2);
  EXPECT_EQ(packet.geometry().calib(0).camera_id(), 4U);
  const SSL_GeometryCameraCalibration& second = packet.geometry().calib(1);
  EXPECT_EQ(second.camera_id(), 9U);
  EXPECT_FALSE(second.has_pixel_image_width());
  EXPECT_FALSE(second.has_pixel_image_height());
  EXPECT_NEAR(second.derived_camera_world_tx(), 1250, 1e-3);
  EXPECT_NEAR(second.derived_camera_world_ty(), 0, 1e-3);
  EXPECT_NEAR(second.derived_camera_world_tz(), 3500, 1e-3);
}

TEST(Packets, PublishesTheNormalisedQuaternion) {
  CameraCalibration rounded;
  rounded.q3 = 0.9995;
  SSL_WrapperPacket packet;
  write_geometry({.field = {}, .cameras = {{0, CameraModel(rounded)}}}, packet);
  EXPECT_EQ(packet.geometry().calib(0).q3(), 1.0F);
}

TEST(Packets, BallModelsOfRoboCup2026AreTheDefaults) {
  SSL_WrapperPacket packet;
  write_geometry({.field = {}, .cameras = {}, .ball_models = BallModels{}}, packet);
  const SSL_GeometryModels& models = packet.geometry().models();
  EXPECT_EQ(models.straight_two_phase().acc_slide(), -3.40);
  EXPECT_EQ(models.straight_two_phase().acc_roll(), -0.45);
  EXPECT_EQ(models.straight_two_phase().k_switch(), 0.64);
  EXPECT_EQ(models.chip_fixed_loss().damping_xy_first_hop(), 0.55);
  EXPECT_EQ(models.chip_fixed_loss().damping_xy_other_hops(), 0.88);
  EXPECT_EQ(models.chip_fixed_loss().damping_z(), 0.54);
}

template <class Messages>
std::vector<float> confidences(const Messages& messages) {
  std::vector<float> out;
  for (const auto& message : messages) out.push_back(message.confidence());
  return out;
}

TEST(Packets, SortsByConfidenceAndClampsIt) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  RobotList robots;
  for (const double confidence : {0.25, kNan, 7.0, -1.0, 0.5}) {
    robots.robots.push_back(robot(Team::kYellow, confidence));
    robots.robots.push_back(robot(Team::kBlue, confidence / 2));
  }
  SSL_WrapperPacket packet;
  write_detection({}, robots, {{ball(kNan), ball(-kInfinity), ball(0.5), ball(kInfinity)}}, 0, packet);
  EXPECT_THAT(confidences(packet.detection().robots_yellow()), ElementsAre(1.0F, 0.5F, 0.25F, 0.0F, 0.0F));
  EXPECT_THAT(confidences(packet.detection().robots_blue()), ElementsAre(1.0F, 0.25F, 0.125F, 0.0F, 0.0F));
  EXPECT_THAT(confidences(packet.detection().balls()), ElementsAre(1.0F, 0.5F, 0.0F, 0.0F));
}

TEST(Packets, EqualConfidencesKeepTheirOrder) {
  RobotList robots;
  for (int id = 0; id < 40; ++id) {
    robots.robots.push_back(robot(Team::kYellow, id % 2));
    robots.robots.back().id = id;
  }
  SSL_WrapperPacket packet;
  write_detection({}, robots, {}, 0, packet);
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(packet.detection().robots_yellow(i).robot_id(), static_cast<unsigned>(2 * i + 1));
    EXPECT_EQ(packet.detection().robots_yellow(20 + i).robot_id(), static_cast<unsigned>(2 * i));
  }
}

TEST(Packets, OrientationIsAboveMinusPiAndAtMostPi) {
  constexpr double kPi = std::numbers::pi;
  const auto published = [](double angle_rad) {
    Robot turned = robot(Team::kBlue, 1);
    turned.orientation_rad = angle_rad;
    SSL_WrapperPacket packet;
    write_detection({}, {{turned}}, {}, 0, packet);
    return static_cast<double>(packet.detection().robots_blue(0).orientation());
  };
  EXPECT_NEAR(published(1.5 * kPi), -0.5 * kPi, 1e-6);
  EXPECT_NEAR(published(-7 * kPi + 0.5), -kPi + 0.5, 1e-6);
  for (const double angle_rad :
       {kPi, -kPi, std::nextafter(kPi, 4), std::nextafter(-kPi, 0), 3 * kPi, -3.1415926}) {
    EXPECT_GT(published(angle_rad), -kPi) << angle_rad;
    EXPECT_LE(published(angle_rad), kPi) << angle_rad;
    EXPECT_NEAR(std::abs(published(angle_rad)), kPi, 1e-6) << angle_rad;
  }
  EXPECT_GT(published(-kPi), 0);
}

TEST(Packets, AUsedMessageKeepsNothingOfTheLastFrame) {
  SSL_WrapperPacket packet;
  write_geometry({.field = {}, .cameras = {{4, camera()}}}, packet);
  write_detection({.camera_id = 1, .number = 2, .times = {3, 4}}, {{robot(Team::kBlue, 1)}}, {{ball(1)}}, 5,
                  packet);
  write_detection({.camera_id = 1, .number = 3, .times = {4}}, {}, {}, 6, packet);
  EXPECT_FALSE(packet.has_geometry());
  EXPECT_FALSE(packet.detection().has_t_capture_camera());
  EXPECT_EQ(packet.detection().robots_blue_size(), 0);
  EXPECT_EQ(packet.detection().balls_size(), 0);
}

}  // namespace
}  // namespace sslv::packets_test
