// SPDX-License-Identifier: Apache-2.0
#include "services/recording/recording_files.h"

#include "base/error.h"
#include "recording/match_log_writer.h"
#include "support/temporary_folder.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace sslv {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

constexpr std::uint64_t kPlenty = std::uint64_t{1} << 60U;

class RecordingFilesTest : public ::testing::Test {
 protected:
  /// A log whose bytes cannot be packed.
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

  test::TemporaryFolder folder_;
  RecordingFiles files_{folder_.path()};
};

TEST_F(RecordingFilesTest, MakesRoomWithTheOldestThatIsNotPinned) {
  // By when they were written: the name of one says something else, as that of another program's log may.
  const auto now = fs::file_time_type::clock::now();
  int hours = 0;
  for (const char* name :
       {"zz_of_others.log.gz", "2026-07-02_b.log.gz", "2026-07-03_c.log.gz", "2026-07-04_d.log.gz"}) {
    write(name);
    fs::last_write_time(files_.path_of(name), now - std::chrono::hours(10 - hours++));
  }
  files_.pin("2026-07-02_b.log.gz", true);
  EXPECT_THAT(files_.make_room(kPlenty), IsEmpty());
  const std::uint64_t all = files_.disk_use().used_bytes;
  EXPECT_GT(all, 40'000U);
  EXPECT_THAT(files_.make_room(all - 1), ElementsAre("zz_of_others.log.gz"));
  EXPECT_THAT(files_.make_room(all / 4 + 100), ElementsAre("2026-07-03_c.log.gz", "2026-07-04_d.log.gz"));
  EXPECT_THAT(names(), ElementsAre("2026-07-02_b.log.gz"));
  EXPECT_THAT(files_.make_room(0), IsEmpty()) << "what is pinned stays";
  files_.pin("2026-07-02_b.log.gz", false);
  EXPECT_THAT(files_.make_room(0), ElementsAre("2026-07-02_b.log.gz"));
  EXPECT_TRUE(fs::is_empty(folder_.path())) << "nothing of them is left";
}

TEST_F(RecordingFilesTest, RemovesNothingWhereThatWouldNotBeEnough) {
  write("a.log.gz");
  write("b.log.gz");
  EventQueue events;
  RecordingSettings settings;
  settings.keep_free_mb = 10'000'000;  // no disk has so much
  EXPECT_THROW(files_.make_room(settings, events), StorageError);
  settings.keep_free_mb = 0;
  settings.quota_mb = 10;
  EXPECT_THROW(files_.make_room(settings, events, 11 * kMb), StorageError);
  EXPECT_THAT(names(), UnorderedElementsAre("a.log.gz", "b.log.gz"));
  files_.make_room(settings, events, 10 * kMb);
  EXPECT_THAT(names(), IsEmpty());
  EXPECT_EQ(events.take().size(), 2U);
}

TEST_F(RecordingFilesTest, TheLogThatIsWrittenIsNotRemoved) {
  const fs::path log = files_.begin("match");
  write(log.filename().string(), 10, false);
  EXPECT_THAT(files_.make_room(0), IsEmpty());
  EXPECT_FALSE(files_.remove(log.filename().string()));
  files_.end(log, true);
  EXPECT_TRUE(files_.remove(log.filename().string()));
}

TEST_F(RecordingFilesTest, WhatStandsBesideALogGoesWithIt) {
  const fs::path begun = files_.begin("match");
  write("a.log.gz");
  files_.pin("a.log.gz", true);
  std::ofstream(folder_.path() / "notes.index") << "of somebody else";
  fs::remove(files_.path_of("a.log.gz"));
  files_.look_after({});
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

TEST_F(RecordingFilesTest, WhatWasNotFinishedIsMadeWhole) {
  const fs::path log = files_.begin("match");
  write(log.filename().string(), 10, false);
  files_.end(log, false);  // its service was killed
  RecordingFiles later(folder_.path());
  later.look_after({});
  const auto file = later.find(log.filename().string());
  ASSERT_TRUE(file && file->index);
  EXPECT_EQ(file->problem, "");
  EXPECT_EQ(file->index->messages.at(LoggedMessage::kVision2014), 10U);
}

TEST_F(RecordingFilesTest, WhatOthersPutThereIsReadAndStaysAsItIs) {
  write("theirs.log.gz", 10, false);
  fs::remove(index_file_of(files_.path_of("theirs.log.gz")));
  const auto size = fs::file_size(files_.path_of("theirs.log.gz"));
  std::ofstream(files_.path_of("none.log")) << "none";
  std::ofstream(files_.path_of("notes.txt")) << "none";
  fs::create_directory(files_.path_of("folder.log"));
  fs::create_symlink("/etc/passwd", files_.path_of("link.log"));
  files_.look_after({});
  EXPECT_THAT(names(), UnorderedElementsAre("theirs.log.gz", "none.log"));
  EXPECT_EQ(fs::file_size(files_.path_of("theirs.log.gz")), size);
  EXPECT_THAT(files_.find("theirs.log.gz")->problem, HasSubstr("is cut off"));
  EXPECT_THAT(files_.find("none.log")->problem, HasSubstr("is no log of the league"));
}

TEST_F(RecordingFilesTest, ALogThatIsReplacedIsReadAgain) {
  write("a.log.gz", 10);
  files_.look_after({});
  EXPECT_EQ(files_.find("a.log.gz")->index->messages.at(LoggedMessage::kVision2014), 10U);
  files_.remove("a.log.gz");
  write("a.log.gz", 20);
  EXPECT_EQ(files_.find("a.log.gz")->index, nullptr);
  files_.look_after({});
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
}  // namespace sslv
