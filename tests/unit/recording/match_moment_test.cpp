// SPDX-License-Identifier: Apache-2.0
#include "recording/match_moment.h"

#include "base/error.h"
#include "recording/match_log_writer.h"
#include "ssl_gc_referee_message.pb.h"
#include "ssl_vision_wrapper.pb.h"
#include "ssl_vision_wrapper_tracked.pb.h"
#include "support/temporary_folder.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <zlib.h>

namespace sslv::match_moment_test {
namespace {

constexpr std::int64_t kBegin_ns = 1'800'000'000'000'000'000;

/// A log of 20 s: two cameras at 10 Hz, the second one until 10 s, with a ball that rolls at 100 mm/s; a
/// tracker until 10 s; the game controller once a second; one geometry message, at 2 s.
class MatchMomentTest : public testing::Test {
 protected:
  MatchMomentTest() {
    MatchLogWriter writer(file());
    const auto add = [&](double at_s, std::int32_t type, const std::string& text) {
      writer.add(kBegin_ns + static_cast<std::int64_t>(at_s * 1e9), type, std::as_bytes(std::span(text)));
    };
    for (int i = 0; i <= 200; ++i) {
      const double at_s = i * 0.1;
      for (std::uint32_t camera = 0; camera < 2; ++camera) {
        SSL_WrapperPacket packet;
        auto* frame = packet.mutable_detection();
        frame->set_frame_number(static_cast<std::uint32_t>(i));
        frame->set_t_capture(at_s);
        frame->set_t_sent(at_s);
        frame->set_camera_id(camera);
        auto* ball = frame->add_balls();
        ball->set_confidence(1);
        ball->set_x(static_cast<float>(100 * at_s));
        ball->set_y(static_cast<float>(camera));
        ball->set_pixel_x(0);
        ball->set_pixel_y(0);
        if (i == 20 && camera == 0) {
          auto* size = packet.mutable_geometry()->mutable_field();
          size->set_field_length(9000);
          size->set_field_width(6000);
          size->set_goal_width(1000);
          size->set_goal_depth(180);
          size->set_boundary_width(300);
        }
        if (camera == 0 || i < 100) add(at_s, LoggedMessage::kVision2014, packet.SerializeAsString());
      }
      if (i < 100) {
        TrackerWrapperPacket packet;
        packet.set_uuid("a");
        auto* frame = packet.mutable_tracked_frame();
        frame->set_frame_number(1);
        frame->set_timestamp(at_s);
        auto* robot = frame->add_robots();
        robot->mutable_robot_id()->set_id(4);
        robot->mutable_robot_id()->set_team(::Team::BLUE);
        robot->mutable_pos()->set_x(1.5);
        robot->mutable_pos()->set_y(0);
        robot->set_orientation(1);
        const std::string tracked = packet.SerializeAsString();
        packet.set_uuid("the tracker that sends first");
        robot->mutable_pos()->set_x(2.5);
        add(at_s + 0.005, LoggedMessage::kTracker2020, packet.SerializeAsString());
        add(at_s + 0.01, LoggedMessage::kTracker2020, tracked);
      }
      if (i % 10 == 0) {
        Referee referee;
        referee.set_stage(1);
        referee.set_command(i < 100 ? 1 : 3);
        referee.mutable_yellow()->set_name("A");
        referee.mutable_yellow()->set_score(static_cast<std::uint32_t>(i / 100));
        add(at_s + 0.02, LoggedMessage::kReferee, referee.SerializeAsString());
      }
    }
    writer.finish();
  }
  std::filesystem::path file() const { return folder_.path() / "match.log.gz"; }

  test::TemporaryFolder folder_;
};

TEST_F(MatchMomentTest, HasTheStateAtThatTime) {
  MatchMoments moments(file(), std::make_shared<const MatchLogIndex>(match_log_index(file())));
  const Json five = moments.at(5.05).value();
  ASSERT_EQ(five["cameras"].size(), 2U);
  EXPECT_EQ(five["cameras"][1]["id"], 1);
  EXPECT_NEAR(five["cameras"][1]["time_s"].get<double>(), 5, 1e-6);
  EXPECT_NEAR(five["cameras"][1]["balls"][0]["x"].get<double>(), 500, 1e-3);
  EXPECT_EQ(five["tracked"]["robots"][0]["team"], "blue");
  EXPECT_NEAR(five["tracked"]["robots"][0]["x"].get<double>(), 2500, 1e-3) << "events are from this tracker";
  EXPECT_EQ(five["referee"]["command"], "Stop");
  EXPECT_EQ(five["referee"]["yellow"]["score"], 0);
  EXPECT_EQ(five["field"]["length"], 9000);

  const Json fifteen = moments.at(15.05).value();
  EXPECT_EQ(fifteen["cameras"].size(), 1U) << "the other one has stopped";
  EXPECT_TRUE(fifteen["tracked"].is_null());
  EXPECT_EQ(fifteen["referee"]["command"], "Force start");
  EXPECT_EQ(fifteen["referee"]["yellow"]["score"], 1);
  EXPECT_NEAR(moments.at(5.05).value()["cameras"][0]["balls"][0]["x"].get<double>(), 500, 1e-3)
      << "back again";
  EXPECT_NEAR(moments.at(1e9).value()["time_s"].get<double>(), 20.02, 1e-3) << "kept within the log";
  EXPECT_EQ(moments.at(-1).value()["time_s"], 0);
}

/// Repacks a log as one gzip member of many small blocks.
void pack_at_once(const std::filesystem::path& from, const std::filesystem::path& to) {
  const gzFile in = gzopen(from.c_str(), "rb");
  std::vector<unsigned char> bytes(1 << 20), packed(1 << 20);
  bytes.resize(static_cast<std::size_t>(gzread(in, bytes.data(), static_cast<unsigned>(bytes.size()))));
  gzclose(in);
  z_stream zlib{};
  deflateInit2(&zlib, 6, Z_DEFLATED, 16 + MAX_WBITS, 1, Z_DEFAULT_STRATEGY);
  zlib.next_in = bytes.data();
  zlib.avail_in = static_cast<uInt>(bytes.size());
  zlib.next_out = packed.data();
  zlib.avail_out = static_cast<uInt>(packed.size());
  EXPECT_EQ(deflate(&zlib, Z_FINISH), Z_STREAM_END);
  std::ofstream(to, std::ios::binary)
      .write(reinterpret_cast<const char*>(packed.data()), static_cast<std::streamsize>(zlib.total_out));
  deflateEnd(&zlib);
}

/// Other recorders' logs can only be read from the beginning, which happens once, in the background.
TEST_F(MatchMomentTest, IsFoundQuicklyInALogWithoutIndexPoints) {
  const auto whole = folder_.path() / "theirs.log.gz";
  pack_at_once(file(), whole);
  const auto index = std::make_shared<const MatchLogIndex>(make_match_log_index(whole));
  ASSERT_TRUE(index->points.empty());
  constexpr std::uint64_t kBudget = 12'000;
  ASSERT_GT(index->unpacked_bytes, 2 * kBudget);
  MatchMoments ours(file(), std::make_shared<const MatchLogIndex>(match_log_index(file())));
  MatchMoments theirs(whole, index, kBudget);
  EXPECT_NO_THROW(theirs.at(15)) << "known already, or not yet";
  theirs.wait();
  for (const double at_s : {15.05, 0.0, 19.95, 10.0, 3.3, 3.2, 20.0})
    EXPECT_EQ(theirs.at(at_s), ours.at(at_s)) << at_s;
}

TEST_F(MatchMomentTest, IsFoundInAVeryLongLog) {
  const auto whole = folder_.path() / "theirs.log.gz";
  pack_at_once(file(), whole);
  MatchLogIndex index = make_match_log_index(whole);
  index.unpacked_bytes = std::uint64_t{1} << 40U;  // as if far more data followed
  MatchMoments moments(whole, std::make_shared<const MatchLogIndex>(index), 12'000);
  moments.wait();
  for (const double at_s : {3.3, 10.0, 19.95}) EXPECT_TRUE(moments.at(at_s)) << at_s;
}

TEST_F(MatchMomentTest, IsRefusedTooFarFromAnyIndexPoint) {
  const auto plain = folder_.path() / "plain.log.gz";
  // Stored, not compressed: one block, inside which reading cannot begin.
  {
    const gzFile in = gzopen(file().c_str(), "rb"), out = gzopen(plain.c_str(), "wb0");
    std::vector<char> bytes(1 << 20);
    const int count = gzread(in, bytes.data(), static_cast<unsigned>(bytes.size()));
    EXPECT_EQ(gzwrite(out, bytes.data(), static_cast<unsigned>(count)), count);
    gzclose(in);
    gzclose(out);
  }
  MatchMoments moments(plain, std::make_shared<const MatchLogIndex>(make_match_log_index(plain)), 2000);
  moments.wait();
  EXPECT_THROW(moments.at(19), StorageError);
  EXPECT_TRUE(moments.at(0.1));
}

TEST_F(MatchMomentTest, LimitsTheContentsOfForgedPackets) {
  const auto forged = folder_.path() / "forged.log.gz";
  {
    MatchLogWriter writer(forged);
    for (std::uint32_t camera = 0; camera < 300; ++camera) {
      SSL_WrapperPacket packet;
      auto* frame = packet.mutable_detection();
      frame->set_frame_number(1);
      frame->set_t_capture(1);
      frame->set_t_sent(1);
      frame->set_camera_id(camera);
      for (int i = 0; i < 2000; ++i) {
        auto* ball = frame->add_balls();
        ball->set_confidence(1);
        ball->set_x(1);
        ball->set_y(1);
        ball->set_pixel_x(0);
        ball->set_pixel_y(0);
      }
      const std::string text = packet.SerializeAsString();
      writer.add(kBegin_ns, LoggedMessage::kVision2014, std::as_bytes(std::span(text)));
      const std::string larger(70'000, '\0');
      writer.add(kBegin_ns, LoggedMessage::kVision2014, std::as_bytes(std::span(larger)));
    }
    writer.finish();
  }
  MatchMoments moments(forged, std::make_shared<const MatchLogIndex>(match_log_index(forged)));
  const Json moment = moments.at(0).value();
  EXPECT_EQ(moment["cameras"].size(), 64U);
  EXPECT_EQ(moment["cameras"][0]["balls"].size(), 256U);
}

TEST(DetectionsJson, IsEmptyForInvalidPackets) {
  EXPECT_FALSE(detections_json_of({}));
  const std::string text = "\x12\xff\xff";
  EXPECT_FALSE(detections_json_of(std::as_bytes(std::span(text))));
}

}  // namespace
}  // namespace sslv::match_moment_test
