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
  const auto write = [&](std::int64_t late_ns, const std::string& bytes) {
    tracks_.write(steady_ns() - late_ns, unix_time_ns() - late_ns, std::as_bytes(std::span(bytes)));
  };
  const auto is_due_in = [&](std::int64_t later_ns) { return tracks_.is_due(steady_ns() + later_ns); };
  EXPECT_FALSE(is_due_in(TracksForLog::kPeriod_ns)) << "nobody records";
  write(0, "before the log");
  recorder_.begin(file_);
  EXPECT_TRUE(is_due_in(TracksForLog::kPeriod_ns));
  send_tracked();
  ASSERT_TRUE(test::becomes([&] { return recorder_.status().tracked == 1; }));
  write(5'000'000, "late");  // before the message above, perhaps
  EXPECT_TRUE(is_due_in(2 * TracksForLog::kPeriod_ns));
  write(0, "in time");
  ASSERT_TRUE(test::becomes([&] { return recorder_.status().tracked == 3; }));
  recorder_.pause(true);
  EXPECT_FALSE(is_due_in(2 * TracksForLog::kPeriod_ns));
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

TEST_F(MatchLogRecorderTest, TracksAreInOrderWithMessagesWhenTheClockIsSet) {
  recorder_.begin(file_);
  constexpr std::int64_t kHour_ns = 3'600'000'000'000;
  const std::int64_t now_ns = steady_ns();
  const std::int64_t times_ns[] = {now_ns, now_ns + kHour_ns, now_ns - kHour_ns};
  for (int i = 0; i < 3; ++i) tracks_.write(now_ns + i, times_ns[i], {});
  ASSERT_TRUE(test::becomes([&] { return recorder_.status().tracked == 3; }));
  recorder_.end();
  MatchLogReader reader(file_);
  LoggedMessage message;
  for (const std::int64_t time_ns : times_ns) {
    ASSERT_TRUE(reader.next(message));
    EXPECT_EQ(message.time_ns, time_ns);
  }
}

TEST(TracksForLog, TakesThirtyASecondOfAnyRate) {
  for (const int rate_hz : {60, 75, 90, 240}) {
    TracksForLog tracks;
    tracks.want(true);
    int taken = 0;
    for (int i = 0; i < 10 * rate_hz; ++i) {
      const std::int64_t now_ns = 1'000'000'000 + 1'000'000'000LL * i / rate_hz + (i % 3) * 100'000;
      if (!tracks.is_due(now_ns)) continue;
      tracks.write(now_ns, now_ns, {});
      tracks.discard();
      ++taken;
    }
    EXPECT_NEAR(taken, 300, 3) << rate_hz;
  }
}

TEST_F(MatchLogRecorderTest, CountsTracksThatDoNotFitIntoMemory) {
  constexpr int kMany = 10'000;
  for (int i = 0; i < kMany; ++i) tracks_.write(i, i, {});
  EXPECT_GT(tracks_.take_dropped(), 0U);
  recorder_.begin(file_);
  recorder_.end();
  EXPECT_EQ(recorder_.status().tracked, 0U) << "they are of no log";
  recorder_.begin(folder_.path() / "b.log.gz");
  // Later than any time that the log takes yet.
  for (int i = 0; i < kMany; ++i) tracks_.write(steady_ns() + 500'000'000, unix_time_ns(), {});
  ASSERT_TRUE(test::becomes([&] { return recorder_.status().tracked + recorder_.status().lost == kMany; }));
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
