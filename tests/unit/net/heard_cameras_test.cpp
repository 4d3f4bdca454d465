// SPDX-License-Identifier: Apache-2.0
#include "net/heard_cameras.h"

#include "net/packets.h"

#include <span>
#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::heard_cameras_test {
namespace {

using testing::ElementsAre;
using testing::Field;
using testing::IsEmpty;
using testing::Pair;

class Heard : public testing::Test {
 protected:
  static CameraModel camera_above(double z_mm) {
    CameraCalibration calibration;
    calibration.q0 = 1;
    calibration.q3 = 0;
    calibration.tz = z_mm;
    calibration.pixel_image_width = 640;
    calibration.pixel_image_height = 480;
    return CameraModel(calibration);
  }
  static SSL_WrapperPacket geometry(std::uint32_t first, std::uint32_t count = 1, double z_mm = 4000) {
    Geometry all;
    for (std::uint32_t id = first; id < first + count; ++id) all.cameras.push_back({id, camera_above(z_mm)});
    SSL_WrapperPacket packet;
    write_geometry(all, packet);
    return packet;
  }
  static SSL_WrapperPacket detection(std::uint32_t id, double height_mm = 150) {
    RobotList robots;
    robots.robots.push_back({Team::kBlue, 7, 100, 200, 0.5, height_mm, 0, 0, 0.9});
    BallList balls;
    balls.balls.push_back({1, 2, 0, 0, 60, 0.8});
    SSL_WrapperPacket packet;
    write_detection({id, 5, {.t_capture_s = 1000}}, robots, balls, 1000.01, packet);
    return packet;
  }
  bool hear(const SSL_WrapperPacket& packet, const std::string& address, double now_s) {
    const std::string bytes = packet.SerializeAsString();
    const auto message = VisionMessage::read(std::as_bytes(std::span(bytes)));
    if (!message) return false;
    return cameras_.hear(*message, address, address.starts_with("named"), now_s, 1000.0103, out_);
  }

  HeardCameras cameras_;
  ArrivedSightings out_;
};

TEST_F(Heard, ACameraOfANamedComputerIsOneOfOurs) {
  EXPECT_FALSE(hear(detection(4), "named", 0)) << "where it hangs is not known yet";
  EXPECT_FALSE(hear(geometry(4), "named", 0));
  ASSERT_TRUE(hear(detection(4), "named", 0.1));
  const CameraSightings& image = out_.image;
  EXPECT_EQ(image.camera, 4);
  EXPECT_TRUE(image.is_of_other_computer);
  EXPECT_EQ(image.t_capture_s, 1000);
  EXPECT_NEAR(image.camera_mm.z(), 4000, 1);
  ASSERT_EQ(image.robots.size(), 1U);
  EXPECT_EQ(image.robots[0].team, Team::kBlue);
  EXPECT_EQ(image.robots[0].height_mm, 150);
  ASSERT_EQ(image.balls.size(), 1U);
  EXPECT_THAT(cameras_.cameras(0.2), ElementsAre(Pair(4, Field(&HeardCameras::Heard::address, "named"))));
  EXPECT_TRUE(cameras_.cameras(0.2).at(4).is_used);
  EXPECT_THAT(cameras_.cameras(60), IsEmpty());
}

TEST_F(Heard, ACameraOfAStrangerIsShownAndNotUsed) {
  hear(geometry(4), "stranger", 0);
  EXPECT_FALSE(hear(detection(4), "stranger", 0.1));
  const auto shown = cameras_.cameras(0.2);
  ASSERT_EQ(shown.size(), 1U);
  EXPECT_EQ(shown.at(4).address, "stranger");
  EXPECT_FALSE(shown.at(4).is_used);
  EXPECT_EQ(shown.at(4).robots, 1U);
  EXPECT_EQ(shown.at(4).balls, 1U);
}

TEST_F(Heard, CamerasWithOurIdsAreIgnored) {
  cameras_.set_own({4});
  for (const char* address : {"named", "stranger"}) {
    hear(geometry(4), address, 0);
    EXPECT_FALSE(hear(detection(4), address, 0));
  }
  EXPECT_THAT(cameras_.conflicts(0.1), IsEmpty()) << "the network service says so";
  EXPECT_THAT(cameras_.cameras(0.1), IsEmpty());
}

TEST_F(Heard, TheFirstOfTwoVisionsKeepsACameraUntilItIsSilent) {
  hear(geometry(4), "named a", 0);
  hear(geometry(4), "named b", 0);
  EXPECT_TRUE(hear(detection(4), "named a", 0));
  EXPECT_FALSE(hear(detection(4), "named b", 0.1));
  EXPECT_THAT(cameras_.conflicts(0.2), ElementsAre(HeardCameras::Conflict{4, "named b", "named a"}));
  EXPECT_TRUE(hear(detection(4), "named b", 5)) << "the first one vanished";
}

TEST_F(Heard, ANamedComputerTakesACamerasIdFromAStranger) {
  hear(geometry(4), "stranger", 0);
  hear(detection(4), "stranger", 0);
  hear(geometry(4), "named", 0);
  EXPECT_TRUE(hear(detection(4), "named", 0.1));
  EXPECT_FALSE(hear(detection(4), "stranger", 0.2));
  EXPECT_TRUE(hear(detection(4), "named", 0.3));
  EXPECT_EQ(cameras_.cameras(0.3).at(4).address, "named");
}

TEST_F(Heard, AGeometryFloodDoesNotExcludeOthers) {
  for (const char* address : {"flood 1", "flood 2", "flood 3"}) hear(geometry(0, 64), address, 0);
  hear(geometry(4), "named", 0.1);
  EXPECT_TRUE(hear(detection(4), "named", 0.2));
  // Other senders are accepted when the flood is over.
  hear(geometry(9), "stranger", 0.1);
  hear(detection(9), "stranger", 0.2);
  EXPECT_FALSE(cameras_.cameras(0.2).contains(9));
  hear(geometry(9), "stranger", 62);
  hear(detection(9), "stranger", 62.1);
  EXPECT_TRUE(cameras_.cameras(62.2).contains(9));
}

TEST_F(Heard, ACameraWhoseGeometryComesOnceAMinuteStays) {
  for (int minute = 0; minute < 3; ++minute) {
    hear(geometry(4), "named", 60 * minute);
    for (int i = 0; i < 60; ++i) EXPECT_TRUE(hear(detection(4), "named", 60 * minute + i + 0.1));
  }
}

TEST_F(Heard, ACameraOfANamedComputerWithoutCalibrationIsReported) {
  hear(detection(4), "named", 0);
  hear(detection(4), "stranger", 0);
  EXPECT_THAT(cameras_.uncalibrated(1), IsEmpty()) << "its geometry may still come";
  hear(geometry(5), "another named", 1);
  hear(detection(4), "named", 1);
  EXPECT_THAT(cameras_.uncalibrated(1), IsEmpty());
  hear(geometry(5), "named", 2);
  EXPECT_THAT(cameras_.uncalibrated(2), ElementsAre(HeardCameras::Uncalibrated{4, "named"}));
  EXPECT_THAT(cameras_.uncalibrated(20), IsEmpty()) << "it is silent";
  hear(geometry(4), "named", 2);
  hear(detection(4), "named", 2);
  EXPECT_THAT(cameras_.uncalibrated(2), IsEmpty());
  for (int second = 2; second < 70; ++second) hear(detection(6), "named", second);
  EXPECT_THAT(cameras_.uncalibrated(69), ElementsAre(HeardCameras::Uncalibrated{6, "named"}))
      << "no geometry comes at all";
  cameras_.set_own({7});
  hear(detection(7), "named", 69);
  hear(geometry(5), "named", 69);
  EXPECT_THAT(cameras_.uncalibrated(69), ElementsAre(HeardCameras::Uncalibrated{6, "named"}))
      << "another alert names our id";
}

TEST_F(Heard, ConflictsAreLimitedAndExpire) {
  hear(geometry(4), "named", 0);
  hear(detection(4), "named", 0);
  for (int i = 0; i < 200; ++i) {
    const std::string address = "stranger " + std::to_string(i);
    hear(geometry(4), address, 0.001 * i);
    hear(detection(4), address, 0.001 * i);
  }
  EXPECT_EQ(cameras_.conflicts(1).size(), 64U);
  for (const char* address : {"named", "named last"}) {
    hear(geometry(4), address, 70);
    hear(detection(4), address, 70);
  }
  EXPECT_THAT(cameras_.conflicts(70), ElementsAre(HeardCameras::Conflict{4, "named last", "named"}));
}

TEST_F(Heard, StrangersHideNoConflictOfNamedComputers) {
  hear(geometry(4), "named a", 0);
  hear(detection(4), "named a", 0);
  for (int i = 0; i < 100; ++i) {
    const std::string address = "a stranger " + std::to_string(i);
    hear(geometry(4), address, 0);
    hear(detection(4), address, 0);
  }
  hear(geometry(4), "named b", 0);
  hear(detection(4), "named b", 0);
  const auto conflicts = cameras_.conflicts(0);
  ASSERT_EQ(conflicts.size(), 65U);
  EXPECT_EQ(conflicts[0], (HeardCameras::Conflict{4, "named b", "named a"})) << "which the alert's title has";
}

TEST_F(Heard, StrangersWithTheSameIdAreNoConflict) {
  for (const char* address : {"stranger a", "stranger b"}) {
    hear(geometry(4), address, 0);
    hear(detection(4), address, 0);
  }
  EXPECT_THAT(cameras_.conflicts(0), IsEmpty());
}

TEST_F(Heard, DropsRobotsAsHighAsTheirCamera) {
  hear(geometry(4, 1, 500), "named", 0);
  EXPECT_TRUE(hear(detection(4, 300), "named", 0));
  EXPECT_EQ(out_.image.robots.size(), 1U);
  EXPECT_TRUE(hear(detection(4, 500), "named", 0));
  EXPECT_EQ(out_.image.robots.size(), 0U);
  EXPECT_EQ(out_.left_out, 1U);
}

TEST_F(Heard, TheNumberOfCamerasIsLimited) {
  for (std::uint32_t id = 0; id < 10'000; ++id) {
    hear(geometry(id), "stranger", 0);
    hear(detection(id), "stranger", 0);
  }
  EXPECT_LE(cameras_.cameras(0).size(), 64U);
}

TEST(OtherClock, ACorrectClockIsNotCorrected) {
  OtherClock clock;
  EXPECT_EQ(clock.correction_s(), 0);
  for (int i = 0; i < 2000; ++i) clock.heard(1000 + 0.01 * i, 1000 + 0.01 * i + 0.0003 + 0.01 * (i % 7));
  EXPECT_EQ(clock.correction_s(), 0) << "late packets say nothing of the clock";
}

TEST(OtherClock, AClockThatIsSecondsOffIsCorrected) {
  OtherClock clock;
  for (int i = 0; i < 2000; ++i) clock.heard(1000 + 0.01 * i, 1002.84 + 0.01 * i + 0.0003 + 0.001 * (i % 7));
  EXPECT_NEAR(clock.correction_s(), 2.84, 1e-3);
  // The other clock is corrected meanwhile.
  for (int i = 0; i < 2000; ++i) clock.heard(1100 + 0.01 * i, 1100 + 0.01 * i + 0.0003);
  EXPECT_EQ(clock.correction_s(), 0);
}

}  // namespace
}  // namespace sslv::heard_cameras_test
