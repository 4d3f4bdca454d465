// SPDX-License-Identifier: Apache-2.0
#include "services/recording/match_log_recorder.h"

#include "base/clock.h"
#include "recording/match_log_reader.h"
#include "ssl_vision_wrapper_tracked.pb.h"
#include "support/becomes.h"
#include "support/group_listener.h"
#include "support/temporary_folder.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace sslv::match_log_recorder_test {
namespace {

class MatchLogRecorderTest : public ::testing::Test {
 protected:
  MatchLogRecorderTest() {
    const GroupAddress here{GroupListener::kGroup, listener_.port(), "lo"}, nowhere{"239.255.77.1", 1, "lo"};
    recorder_.listen({.vision = nowhere, .tracker = here, .referee = {}});
  }
  void send_tracked() {
    TrackerWrapperPacket packet;
    packet.set_uuid("a");
    packet.mutable_tracked_frame()->set_frame_number(1);
    packet.mutable_tracked_frame()->set_timestamp(1);
    send(sender_, packet.SerializeAsString());
  }

  test::TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_.path() / "a.log.gz";
  GroupListener listener_;  // reserves the port
  MulticastSender sender_{settings_for(listener_)};
  std::atomic<bool> are_ours_ = true;
  TracksForLog tracks_;
  MatchLogRecorder recorder_{[this](std::int32_t, const auto&) { return are_ours_.load(); }, tracks_};
};

TEST_F(MatchLogRecorderTest, DropsAndCountsForeignMessages) {
  recorder_.begin(file_);
  for (std::uint64_t i = 1; i <= 100; ++i) {
    send(sender_, i % 2 == 0 ? std::string() : std::string(1400, 'x'));
    // Few enough to fit into the socket's buffer.
    if (i % 20 != 0) continue;
    ASSERT_TRUE(test::becomes([&] { return recorder_.status().refused == i; }));
  }
  send_tracked();
  ASSERT_TRUE(test::becomes([&] { return recorder_.status().tracked == 1; }));
  recorder_.end();
  EXPECT_EQ(recorder_.status().problem, "");
  EXPECT_EQ(recorder_.status().lost, 0U);
  MatchLogReader reader(file_);
  LoggedMessage message;
  EXPECT_TRUE(reader.next(message));
  EXPECT_EQ(message.type, LoggedMessage::kTracker2020);
  EXPECT_FALSE(reader.next(message)) << "nothing else is in the log";
}

TEST_F(MatchLogRecorderTest, StrangersAreCutToAsMuchAsIsOurs) {
  recorder_.begin(file_);
  const auto sent = [&](std::uint64_t tracked, std::uint64_t cut) {
    send_tracked();
    return test::becomes(
        [&] { return recorder_.status().tracked == tracked && recorder_.status().cut == cut; });
  };
  are_ours_ = false;
  ASSERT_TRUE(sent(1, 0)) << "there is room";
  EXPECT_EQ(recorder_.status().counted_share(), 1) << "nothing is ours";
  recorder_.cut_strangers(true);
  ASSERT_TRUE(sent(1, 1));
  are_ours_ = true;
  ASSERT_TRUE(sent(2, 1));
  EXPECT_EQ(recorder_.status().counted_share(), 1) << "no more of theirs than of ours";
  recorder_.cut_strangers(true);
  are_ours_ = false;
  ASSERT_TRUE(sent(3, 1)) << "as much as ours, whatever came while there was room";
  ASSERT_TRUE(sent(3, 2));
  const MatchLogRecorder::Status status = recorder_.status();
  EXPECT_EQ(2 * status.ours_bytes, status.strangers_bytes);
  EXPECT_DOUBLE_EQ(status.counted_share(), 2. / 3);
  recorder_.cut_strangers(false);
  ASSERT_TRUE(sent(4, 2));
  recorder_.end();
}

TEST_F(MatchLogRecorderTest, HoldsTracksThatAreNotSent) {
  const auto write = [&](std::int64_t time_ns, const std::string& bytes) {
    tracks_.write(time_ns, std::as_bytes(std::span(bytes)));
  };
  EXPECT_FALSE(tracks_.is_due(unix_time_ns() + TracksForLog::kPeriod_ns)) << "nobody records";
  write(unix_time_ns(), "before the log");
  recorder_.begin(file_);
  EXPECT_TRUE(tracks_.is_due(unix_time_ns() + TracksForLog::kPeriod_ns));
  send_tracked();
  ASSERT_TRUE(test::becomes([&] { return recorder_.status().tracked == 1; }));
  const std::int64_t late_ns = unix_time_ns() - 5'000'000;  // before the message above, perhaps
  write(late_ns, "late");
  EXPECT_FALSE(tracks_.is_due(late_ns + TracksForLog::kPeriod_ns - 1)) << "too soon";
  EXPECT_TRUE(tracks_.is_due(late_ns + TracksForLog::kPeriod_ns));
  EXPECT_TRUE(tracks_.is_due(late_ns - 3'600'000'000'000)) << "the clock was set back";
  write(unix_time_ns(), "in time");
  ASSERT_TRUE(test::becomes([&] { return recorder_.status().tracked == 3; }));
  recorder_.pause(true);
  EXPECT_FALSE(tracks_.is_due(unix_time_ns() + TracksForLog::kPeriod_ns));
  recorder_.end();
  MatchLogReader reader(file_);
  LoggedMessage message;
  std::int64_t last_ns = 0;
  std::uint64_t bytes = 0;
  std::vector<std::string> found;
  while (reader.next(message)) {
    EXPECT_EQ(message.type, LoggedMessage::kTracker2020);
    EXPECT_GE(message.time_ns, last_ns);
    last_ns = message.time_ns;
    bytes += message.bytes.size() + kMessageHeaderBytes;
    const auto* const text = reinterpret_cast<const char*>(message.bytes.data());
    found.emplace_back(text, message.bytes.size());
  }
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(std::ranges::count(found, "late"), 1);
  EXPECT_EQ(found.back(), "in time");
  EXPECT_EQ(recorder_.status().ours_bytes, bytes) << "the quota counts them as ours";
}

TEST_F(MatchLogRecorderTest, CountsTracksThatDoNotFitIntoMemory) {
  for (int i = 0; i < 1000; ++i) tracks_.write(i, {});
  EXPECT_GT(tracks_.take_dropped(), 0U);
  recorder_.begin(file_);
  recorder_.end();
  EXPECT_EQ(recorder_.status().tracked, 0U) << "they are of no log";
  recorder_.begin(folder_.path() / "b.log.gz");
  // Later than any time that the log takes yet.
  for (int i = 0; i < 1000; ++i) tracks_.write(unix_time_ns() + 500'000'000, {});
  ASSERT_TRUE(test::becomes([&] { return recorder_.status().tracked + recorder_.status().lost == 1000; }));
  EXPECT_GT(recorder_.status().lost, 0U);
  recorder_.end();
}

TEST_F(MatchLogRecorderTest, ALogWhoseIndexCannotBeWrittenIsRecorded) {
  recorder_.begin(file_);
  std::filesystem::create_directories(index_file_of(file_) / "in the way");
  send_tracked();
  ASSERT_TRUE(test::becomes([&] { return recorder_.status().tracked == 1; }));
  recorder_.end();
  EXPECT_EQ(recorder_.status().problem, "") << "the index can be made again";
  EXPECT_EQ(make_match_log_index(file_).problem, "");
  EXPECT_EQ(make_match_log_index(file_).messages.at(LoggedMessage::kTracker2020), 1U);
}

}  // namespace
}  // namespace sslv::match_log_recorder_test
