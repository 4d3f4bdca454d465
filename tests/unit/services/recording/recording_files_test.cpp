// SPDX-License-Identifier: Apache-2.0
#include "services/recording/recording_files.h"

#include "base/error.h"
#include "recording/match_log_writer.h"
#include "support/temporary_folder.h"

#include <chrono>
#include <csignal>
#include <cstddef>
#include <fstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <sys/resource.h>

namespace sslv::recording_files_test {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

class RecordingFilesTest : public ::testing::Test {
 protected:
  /// Writes a log of bytes that cannot be compressed.
  void write(const std::string& name, int messages = 10, bool ends = true) const {
    MatchLogWriter writer(files_.path_of(name));
    std::vector<std::byte> bytes(1000);
    unsigned chance = 1;
    for (int i = 0; i < messages; ++i) {
      for (std::byte& byte : bytes) byte = std::byte((chance = chance * 1664525U + 1013904223U) >> 24U);
      writer.add(1'000'000'000LL * i, LoggedMessage::kVision2014, bytes);
    }
    ends ? writer.finish() : writer.flush();
  }
  std::vector<std::string> names() const {
    std::vector<std::string> out;
    for (const RecordingFile& file : files_.list(RecordingFile::Kind::kMatchLog)) out.push_back(file.name);
    return out;
  }

  /// Writes a file of this size and age; its name says whether it is a log or a clip.
  void put(const std::string& name, int mb, int hours) const {
    std::ofstream(files_.path_of(name), std::ios::binary) << "anything";
    fs::resize_file(files_.path_of(name), static_cast<std::uintmax_t>(mb) * kMb);
    fs::last_write_time(files_.path_of(name), fs::file_time_type::clock::now() - std::chrono::hours(hours));
  }
  /// Names of the recordings that are deleted to free space for `wanted_mb` more.
  std::vector<std::string> goes_for(RoomFor whom, int wanted_mb = 0) {
    const Room room = files_.make_room(settings_, whom, events_, static_cast<std::uint64_t>(wanted_mb) * kMb);
    problem_ = room.problem;
    is_scarce_ = room.is_scarce;
    std::vector<std::string> out;
    for (const Event& event : events_.take()) {
      const std::string begin = "Recording ", end = " was removed to make room";
      out.push_back(event.title.substr(begin.size(), event.title.size() - begin.size() - end.size()));
      EXPECT_FALSE(fs::exists(files_.path_of(out.back())));
    }
    return out;
  }
  std::string refusal(RoomFor whom, int wanted_mb = 0) {
    try {
      files_.make_room(settings_, whom, events_, static_cast<std::uint64_t>(wanted_mb) * kMb);
    } catch (const StorageError& error) {
      EXPECT_THAT(events_.take(), IsEmpty());
      return error.what();
    }
    return "it has room";
  }

  test::TemporaryFolder folder_;
  RecordingFiles files_{folder_.path()};
  EventQueue events_;
  RecordingSettings settings_ = [] {
    RecordingSettings settings;
    settings.quota_mb = 100;
    settings.keep_free_mb = 0;
    return settings;
  }();
  std::string problem_;
  bool is_scarce_ = false;
};

TEST_F(RecordingFilesTest, ClipsGoBeforeMatchLogsAndOldOnesFirst) {
  // Age is the time of writing, not that in the name: other programs name their logs differently.
  put("zz_of_others.log.gz", 20, 9);
  put("2026-07-02_b.log.gz", 20, 8);
  put("2026-07-03_c.log.gz", 20, 7);
  put("2026-07-04_a.clip", 20, 2);
  put("2026-07-04_b.clip", 20, 1);
  EXPECT_THAT(goes_for(RoomFor::kMatchLog), IsEmpty());
  EXPECT_THAT(goes_for(RoomFor::kMatchLog, 10), ElementsAre("2026-07-04_a.clip"));
  EXPECT_THAT(goes_for(RoomFor::kMatchLog, 50), ElementsAre("2026-07-04_b.clip", "zz_of_others.log.gz"));
  files_.pin("2026-07-02_b.log.gz", true);
  EXPECT_THAT(goes_for(RoomFor::kMatchLog, 70), IsEmpty());
  EXPECT_THAT(names(), ElementsAre("2026-07-03_c.log.gz", "2026-07-02_b.log.gz"));
}

TEST_F(RecordingFilesTest, PinnedFilesAndTheNewestLogStay) {
  put("a.log.gz", 70, 9);
  files_.pin("a.log.gz", true);
  put("b.log.gz", 20, 8);
  put("c.log.gz", 40, 7);
  EXPECT_THAT(goes_for(RoomFor::kMatchLog), IsEmpty()) << "they would not be enough";
  EXPECT_EQ(
      problem_,
      "recordings take 130 MB, and may take 100 MB (/recording/quota_mb); no more of them can be removed");
  put("c.log.gz", 20, 7);
  EXPECT_THAT(goes_for(RoomFor::kMatchLog), ElementsAre("b.log.gz"));
  EXPECT_EQ(problem_, "");
  settings_.quota_mb = 10;
  EXPECT_THAT(goes_for(RoomFor::kMatchLog), IsEmpty());
  EXPECT_THAT(names(), ElementsAre("c.log.gz", "a.log.gz"));
}

/// With the whole quota pinned, the running match's log is still written, and stays after the match.
TEST_F(RecordingFilesTest, TheLogOfTheMatchThatRunsHasTheHighestRank) {
  put("a.log.gz", 100, 9);
  files_.pin("a.log.gz", true);
  EXPECT_THAT(goes_for(RoomFor::kMatchLog), IsEmpty());
  const fs::path log = files_.begin("match");
  put(log.filename().string(), 50, 0);
  for (int check = 0; check < 3; ++check) {
    EXPECT_THAT(goes_for(RoomFor::kMatchLog), IsEmpty());
    EXPECT_THAT(problem_, HasSubstr("recordings take 150 MB"));
    if (check == 1) files_.end(log, true);
  }
  EXPECT_TRUE(fs::exists(log));
}

/// A real match does not fill more than half of the quota with one log.
TEST_F(RecordingFilesTest, NothingGoesForALogThatStrangersFilled) {
  put("a.log.gz", 30, 9);
  files_.pin("a.log.gz", true);
  put("a.clip", 20, 8);
  files_.pin("a.clip", true);
  files_.pin("a.log.gz", true);
  const fs::path log = files_.begin("match");
  const std::string name = log.filename().string();
  put(name, 60, 1);
  EXPECT_THAT(goes_for(RoomFor::kMatchLog), IsEmpty());
  EXPECT_THAT(problem_, HasSubstr("recordings take 110 MB"));
  EXPECT_THAT(refusal(RoomFor::kClip), HasSubstr("recordings take 110 MB"));
  files_.end(log, true);
  EXPECT_THAT(goes_for(RoomFor::kMatchLog), IsEmpty()) << "after the match, too";
  files_.pin("a.clip", false);
  files_.pin("a.log.gz", false);
  put("next.log.gz", 1, 0);
  EXPECT_THAT(goes_for(RoomFor::kMatchLog), ElementsAre(name)) << "it is deleted first";
}

/// Strangers' packets count only up to the amount of ours. A fifth of the log is ours: 20 of its 50 MB count.
TEST_F(RecordingFilesTest, NothingGoesForWhatStrangersSendBeyondOurs) {
  put("a.log.gz", 30, 9);
  const fs::path log = files_.begin("match");
  const std::string name = log.filename().string();
  files_.count(name, 0.4);
  put(name, 40, 1);
  EXPECT_THAT(goes_for(RoomFor::kMatchLog), IsEmpty());
  EXPECT_FALSE(is_scarce_);
  put(name, 50, 1);
  EXPECT_THAT(goes_for(RoomFor::kMatchLog), IsEmpty());
  EXPECT_TRUE(is_scarce_) << "a quarter of the quota is for what is ours";
  EXPECT_EQ(problem_, "");
  put("a.log.gz", 60, 9);
  EXPECT_THAT(goes_for(RoomFor::kMatchLog), IsEmpty());
  EXPECT_THAT(problem_, HasSubstr("recordings take 110 MB"));
  files_.end(log, true);
  EXPECT_THAT(goes_for(RoomFor::kMatchLog), IsEmpty()) << "after the match, too";
  files_.count(name, 1);
  EXPECT_THAT(goes_for(RoomFor::kMatchLog), ElementsAre("a.log.gz"));
}

TEST_F(RecordingFilesTest, AClipLeavesRoomForLogsAndTakesNoneOfTheirs) {
  put("a.log.gz", 50, 9);
  put("b.log.gz", 20, 8);
  put("a.clip", 10, 1);
  // A quarter of the quota is reserved for match logs.
  EXPECT_THAT(refusal(RoomFor::kClip, 20), HasSubstr("would take 100 MB, and may take 75 MB"));
  EXPECT_THAT(goes_for(RoomFor::kClip, 4), ElementsAre("a.clip"));
  EXPECT_THAT(names(), ElementsAre("b.log.gz", "a.log.gz"));
}

TEST_F(RecordingFilesTest, RemovesNothingForADiskThatMustStayFree) {
  put("a.log.gz", 70, 9);
  put("a.clip", 70, 9);
  settings_.keep_free_mb = 10'000'000;  // more than any disk has
  for (const RoomFor whom : {RoomFor::kMatchLog, RoomFor::kClip})
    EXPECT_THAT(refusal(whom), HasSubstr("/recording/keep_free_mb"));
  EXPECT_TRUE(fs::exists(files_.path_of("a.clip")));
}

TEST_F(RecordingFilesTest, OnAFullDiskClipsGoForAMatchLog) {
  // Sparse files, larger than anything that other programs may write meanwhile.
  constexpr int kTera_mb = 1'000'000;
  settings_.quota_mb = 10 * kTera_mb;
  settings_.keep_free_mb = static_cast<int>(files_.disk_use().free_bytes / kMb) + kTera_mb / 2;
  put("a.log.gz", kTera_mb, 9);
  put("b.log.gz", 1, 8);
  EXPECT_THAT(refusal(RoomFor::kMatchLog), HasSubstr("/recording/keep_free_mb"));
  put("a.clip", kTera_mb, 2);
  put("b.clip", kTera_mb, 1);
  EXPECT_THAT(refusal(RoomFor::kClip), HasSubstr("clips 0.4 GB more"));
  EXPECT_THAT(goes_for(RoomFor::kMatchLog), ElementsAre("a.clip"));
  EXPECT_TRUE(fs::exists(files_.path_of("b.clip"))) << "the other one is enough";
}

TEST_F(RecordingFilesTest, TheLogThatIsWrittenIsNotRemoved) {
  const fs::path log = files_.begin("match");
  put(log.filename().string(), 200, 9);
  put("newest.log.gz", 1, 1);
  EXPECT_THAT(goes_for(RoomFor::kMatchLog), IsEmpty());
  EXPECT_FALSE(files_.remove(log.filename().string()));
  files_.end(log, true);
  EXPECT_THAT(goes_for(RoomFor::kMatchLog), ElementsAre(log.filename().string()));
}

/// While it exists, no file of this program can grow beyond this size.
class FullDisk {
 public:
  explicit FullDisk(std::uint64_t bytes) : handler_(::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &limit_);
    const rlimit small{bytes, limit_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &small);
  }
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &limit_);
    ::signal(SIGXFSZ, handler_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit limit_{};
  void (*handler_)(int);
};

TEST_F(RecordingFilesTest, ARepairThatFailedIsTriedAgain) {
  const fs::path log = files_.begin("match");
  write(log.filename().string(), 10, false);
  files_.end(log, false);  // as if the service was killed
  RecordingFiles later(folder_.path());
  const auto file = [&] { return later.find(log.filename().string()); };
  {
    const FullDisk disk(1000);
    later.look_after({}, 100);
    EXPECT_THAT(file()->problem, HasSubstr("File too large"));
    EXPECT_EQ(file()->index, nullptr);
  }
  later.look_after({}, 101);
  EXPECT_EQ(file()->index, nullptr) << "not at once";
  later.look_after({}, 1000);
  EXPECT_EQ(file()->problem, "");
  ASSERT_TRUE(file()->index);
  EXPECT_EQ(file()->index->messages.at(LoggedMessage::kVision2014), 10U);
  EXPECT_FALSE(fs::exists(log.string() + ".unfinished"));
}

TEST_F(RecordingFilesTest, ALogsSideFilesAreDeletedWithIt) {
  const fs::path begun = files_.begin("match");
  write("a.log.gz");
  files_.pin("a.log.gz", true);
  std::ofstream(folder_.path() / "notes.index") << "of somebody else";
  fs::remove(files_.path_of("a.log.gz"));
  files_.look_after({}, 0);
  EXPECT_FALSE(fs::exists(index_file_of(files_.path_of("a.log.gz"))));
  EXPECT_FALSE(fs::exists(files_.path_of("a.log.gz.pinned")));
  EXPECT_TRUE(fs::exists(folder_.path() / "notes.index"));
  EXPECT_TRUE(fs::exists(begun.string() + ".unfinished")) << "it is about to be written";
}

TEST_F(RecordingFilesTest, TwoOfOneMinuteHaveTwoNames) {
  const fs::path first = files_.begin("match");
  write(first.filename().string());
  files_.end(first, true);
  const fs::path second = files_.begin("match");
  EXPECT_NE(first, second);
  EXPECT_THAT(second.filename().string(), HasSubstr("_match"));
}

TEST_F(RecordingFilesTest, UnfinishedLogsAreRepaired) {
  const fs::path log = files_.begin("match");
  write(log.filename().string(), 10, false);
  files_.end(log, false);  // as if the service was killed
  RecordingFiles later(folder_.path());
  later.look_after({}, 0);
  const auto file = later.find(log.filename().string());
  ASSERT_TRUE(file && file->index);
  EXPECT_EQ(file->problem, "");
  EXPECT_EQ(file->index->messages.at(LoggedMessage::kVision2014), 10U);
}

TEST_F(RecordingFilesTest, ForeignFilesAreReadAndNotChanged) {
  write("theirs.log.gz", 10, false);
  fs::remove(index_file_of(files_.path_of("theirs.log.gz")));
  const auto size = fs::file_size(files_.path_of("theirs.log.gz"));
  std::ofstream(files_.path_of("none.log")) << "none";
  std::ofstream(files_.path_of("notes.txt")) << "none";
  fs::create_directory(files_.path_of("folder.log"));
  fs::create_symlink("/etc/passwd", files_.path_of("link.log"));
  files_.look_after({}, 0);
  EXPECT_THAT(names(), UnorderedElementsAre("theirs.log.gz", "none.log"));
  EXPECT_EQ(fs::file_size(files_.path_of("theirs.log.gz")), size);
  EXPECT_THAT(files_.find("theirs.log.gz")->problem, HasSubstr("is cut off"));
  EXPECT_THAT(files_.find("none.log")->problem, HasSubstr("is not a log of the league"));
}

TEST_F(RecordingFilesTest, ALogThatIsReplacedIsReadAgain) {
  write("a.log.gz", 10);
  files_.look_after({}, 0);
  EXPECT_EQ(files_.find("a.log.gz")->index->messages.at(LoggedMessage::kVision2014), 10U);
  files_.remove("a.log.gz");
  write("a.log.gz", 20);
  EXPECT_EQ(files_.find("a.log.gz")->index, nullptr);
  files_.look_after({}, 0);
  EXPECT_EQ(files_.find("a.log.gz")->index->messages.at(LoggedMessage::kVision2014), 20U);
}

TEST(MatchLogName, IsAFileOfTheFolderAndNothingElse) {
  for (const char* name : {"a.log", "2026-07-03_14-05_GROUP_PHASE_A-vs-B.log.gz", "a b.log"})
    EXPECT_TRUE(is_recording_name(name)) << name;
  for (const char* name : {"", ".log", ".log.gz", "..log", "../a.log", "a/b.log", "a\\b.log", "a.txt",
                           "a.log.index", "a\n.log", "ä.log", "a.log.pinned"})
    EXPECT_FALSE(is_recording_name(name)) << name;
  std::string long_name(300, 'a');
  long_name.append(".log");
  EXPECT_FALSE(is_recording_name(long_name));
  EXPECT_FALSE(is_recording_name(std::string("a\0.log", 6)));
}

}  // namespace
}  // namespace sslv::recording_files_test
