// SPDX-License-Identifier: Apache-2.0
#include "net/heard_cameras.h"

#include "net/packets.h"

#include <gmock/gmock.h>

namespace sslv {
namespace {

class Heard : public testing::Test {
 protected:
  SSL_WrapperPacket geometry(std::uint32_t id) const {
    CameraCalibration calibration;
    calibration.q0 = 1;
    calibration.q3 = 0;
    calibration.tz = 4000;
    calibration.pixel_image_width = 640;
    calibration.pixel_image_height = 480;
    SSL_WrapperPacket packet;
    write_geometry({{}, {{id, CameraModel(calibration)}}}, packet);
    return packet;
  }
  SSL_WrapperPacket detection(std::uint32_t id, double x_mm = 100) const {
    RobotList robots;
    robots.robots.push_back({Team::kBlue, 7, x_mm, 200, 0.5, 150, 0, 0, 0.9});
    BallList balls;
    balls.balls.push_back({1, 2, 0, 0, 60, 0.8});
    SSL_WrapperPacket packet;
    write_detection({id, 5, {.t_capture_s = 1000}}, robots, balls, 1000.01, packet);
    return packet;
  }
  bool read(const SSL_WrapperPacket& packet, const char* address, double now_s) {
    return cameras_.read(packet, address, now_s, 1000.0103, out_);
  }

  HeardCameras cameras_;
  CameraSightings out_;
};

TEST_F(Heard, ACameraOfAnotherComputerIsOneOfOurs) {
  EXPECT_FALSE(read(detection(4), "a", 0)) << "where it hangs is not known yet";
  EXPECT_FALSE(read(geometry(4), "a", 0));
  ASSERT_TRUE(read(detection(4), "a", 0.1));
  EXPECT_EQ(out_.camera, 4);
  EXPECT_TRUE(out_.is_of_other_computer);
  EXPECT_EQ(out_.t_capture_s, 1000);
  EXPECT_NEAR(out_.camera_mm.z(), 4000, 1);
  ASSERT_EQ(out_.robots.size(), 1U);
  EXPECT_EQ(out_.robots[0].team, Team::kBlue);
  EXPECT_EQ(out_.robots[0].height_mm, 150);
  ASSERT_EQ(out_.balls.size(), 1U);
  EXPECT_THAT(cameras_.cameras(0.2),
              testing::ElementsAre(testing::Pair(4, testing::Field(&HeardCameras::Heard::address, "a"))));
  EXPECT_TRUE(cameras_.cameras(60).empty());
}

TEST_F(Heard, OurOwnCamerasAreNotThoseOfOthers) {
  cameras_.set_own({4});
  read(geometry(4), "a", 0);
  EXPECT_FALSE(read(detection(4), "a", 0));
  EXPECT_THAT(cameras_.conflicts(0.1), testing::ElementsAre(HeardCameras::Conflict{4, "a", ""}));
  EXPECT_TRUE(cameras_.conflicts(60).empty());
}

TEST_F(Heard, TheFirstOfTwoVisionsKeepsACameraUntilItIsSilent) {
  read(geometry(4), "a", 0);
  read(geometry(4), "b", 0);
  EXPECT_TRUE(read(detection(4), "a", 0));
  EXPECT_FALSE(read(detection(4), "b", 0.1));
  EXPECT_THAT(cameras_.conflicts(0.2), testing::ElementsAre(HeardCameras::Conflict{4, "b", "a"}));
  EXPECT_TRUE(read(detection(4), "b", 5)) << "the first one vanished";
}

TEST_F(Heard, NumbersOfCamerasHaveAnEnd) {
  for (std::uint32_t id = 0; id < 10'000; ++id) {
    read(geometry(id), "a", 0);
    read(detection(id), "a", 0);
  }
  EXPECT_LE(cameras_.cameras(0).size(), 64U);
}

TEST(OtherClock, OneThatIsRightIsLeftAlone) {
  OtherClock clock;
  EXPECT_EQ(clock.correction_s(), 0);
  for (int i = 0; i < 2000; ++i) clock.heard(1000 + 0.01 * i, 1000 + 0.01 * i + 0.0003 + 0.01 * (i % 7));
  EXPECT_EQ(clock.correction_s(), 0) << "late packets say nothing of the clock";
}

TEST(OtherClock, OneThatIsSecondsOffIsSetRight) {
  OtherClock clock;
  for (int i = 0; i < 2000; ++i) clock.heard(1000 + 0.01 * i, 1002.84 + 0.01 * i + 0.0003 + 0.001 * (i % 7));
  EXPECT_NEAR(clock.correction_s(), 2.84, 1e-3);
  // It is set meanwhile.
  for (int i = 0; i < 2000; ++i) clock.heard(1100 + 0.01 * i, 1100 + 0.01 * i + 0.0003);
  EXPECT_EQ(clock.correction_s(), 0);
}

}  // namespace
}  // namespace sslv
