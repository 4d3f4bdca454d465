// SPDX-License-Identifier: Apache-2.0
//
// Match logs: written, read, indexed, and repaired after a power cut.
#include "base/error.h"
#include "base/json.h"
#include "recording/match_log_convert.h"
#include "recording/match_log_index.h"
#include "recording/match_log_reader.h"
#include "recording/match_log_writer.h"
#include "ssl_gc_referee_message.pb.h"
#include "ssl_vision_wrapper_tracked.pb.h"
#include "support/allocation_count.h"
#include "support/little_memory.h"
#include "support/temporary_folder.h"
#include "support/test_data.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <zlib.h>

namespace sslv::match_log_test {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::int64_t kBegin_ns = 1'800'000'000'000'000'000;

std::string contents(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void write(const fs::path& file, std::string_view bytes) {
  std::ofstream(file, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

std::vector<std::byte> bytes_of(std::string_view text) {
  std::vector<std::byte> out(text.size());
  std::ranges::transform(text, out.begin(), [](char c) { return std::byte(c); });
  return out;
}

/// Messages like those of a match: each repeats much of the one before.
class Match {
 public:
  explicit Match(unsigned seed = 1) : chance_(seed) {}

  LoggedMessage next() {
    LoggedMessage message;
    message.time_ns = kBegin_ns + 4'000'000LL * number_;
    message.type = number_ % 3 == 2 ? LoggedMessage::kTracker2020 : LoggedMessage::kVision2014;
    std::string text = fmt::format("frame {} of camera {}", number_, number_ % 4);
    for (int i = 0; i < 60; ++i) text += static_cast<char>(chance_() % 64 + (i % 3) * 64);
    message.bytes = bytes_of(text);
    ++number_;
    return message;
  }

 private:
  std::mt19937 chance_;
  int number_ = 0;
};

void add(MatchLogWriter& out, const LoggedMessage& message) {
  out.add(message.time_ns, message.type, message.bytes);
}

std::vector<LoggedMessage> write_match(const fs::path& file, int count) {
  Match match;
  MatchLogWriter out(file);
  std::vector<LoggedMessage> messages;
  for (int i = 0; i < count; ++i) add(out, messages.emplace_back(match.next()));
  out.finish();
  return messages;
}

void expect_same(const LoggedMessage& a, const LoggedMessage& b) {
  EXPECT_EQ(a.time_ns, b.time_ns);
  EXPECT_EQ(a.type, b.type);
  EXPECT_EQ(a.bytes, b.bytes);
}

/// A log's messages, and the reason why reading stopped.
struct WasRead {
  std::vector<LoggedMessage> messages;
  std::string problem;
};

WasRead read(const fs::path& file) {
  WasRead out;
  MatchLogReader reader(file);
  for (LoggedMessage message; reader.next(message);) out.messages.push_back(message);
  out.problem = reader.problem();
  return out;
}

class MatchLog : public ::testing::Test {
 protected:
  fs::path file(const std::string& name = "match.log.gz") const { return folder_.path() / name; }

  std::string error_of(std::string_view bytes) const {
    write(file("bad.log"), bytes);
    try {
      const std::string problem = read(file("bad.log")).problem;
      return problem.substr(std::min(problem.size(), folder_.path().string().size() + 1));
    } catch (const StorageError& error) {
      return std::string(error.what()).substr(folder_.path().string().size() + 1);
    }
  }

  TemporaryFolder folder_;
};

TEST_F(MatchLog, IsReadAsItWasWritten) {
  const auto written = write_match(file(), 30'000);
  const WasRead was_read = read(file());
  EXPECT_EQ(was_read.problem, "");
  ASSERT_EQ(was_read.messages.size(), written.size());
  for (std::size_t i = 0; i < written.size(); ++i) expect_same(was_read.messages[i], written[i]);
}

TEST_F(MatchLog, IsPlainGzipOfTheLeaguesFormat) {
  const auto written = write_match(file(), 3);
  std::string unpacked(100'000, '\0');
  gzFile in = gzopen(file().c_str(), "rb");
  unpacked.resize(
      static_cast<std::size_t>(gzread(in, unpacked.data(), static_cast<unsigned>(unpacked.size()))));
  EXPECT_EQ(gzclose(in), Z_OK);
  std::string expected("SSL_LOG_FILE\0\0\0\1", 16);
  for (const LoggedMessage& message : written) {
    for (int i = 7; i >= 0; --i) expected += static_cast<char>(message.time_ns >> 8 * i);
    expected += std::string("\0\0\0", 3) + static_cast<char>(message.type);
    expected += std::string("\0\0\0", 3) + static_cast<char>(message.bytes.size());
    expected.append(reinterpret_cast<const char*>(message.bytes.data()), message.bytes.size());
  }
  EXPECT_EQ(unpacked, expected);
}

TEST_F(MatchLog, CompressesNearlyAsWellAsASinglePass) {
  Match match;
  MatchLogWriter out(file());
  std::string plain;
  for (int i = 0; i < 60'000; ++i) {
    const LoggedMessage message = match.next();
    add(out, message);
    if (i % 125 == 124) out.flush();  // twice a second
    plain.append(16, '\0');
    plain.append(reinterpret_cast<const char*>(message.bytes.data()), message.bytes.size());
  }
  out.finish();
  std::vector<Bytef> packed(compressBound(plain.size()));
  uLongf size = packed.size();
  ASSERT_EQ(compress2(packed.data(), &size, reinterpret_cast<const Bytef*>(plain.data()), plain.size(), 6),
            Z_OK);
  EXPECT_LT(static_cast<double>(fs::file_size(file())), 1.1 * static_cast<double>(size));
}

TEST_F(MatchLog, HasAnIndexThatIsTheSameWhenItIsMadeAgain) {
  write_match(file(), 60'000);
  const auto written = read_match_log_index(file());
  ASSERT_TRUE(written.has_value());
  EXPECT_EQ(*written, make_match_log_index(file()));
  EXPECT_EQ(written->messages.at(LoggedMessage::kVision2014), 40'000U);
  EXPECT_EQ(written->messages.at(LoggedMessage::kTracker2020), 20'000U);
  EXPECT_EQ(written->first_ns, kBegin_ns);
  EXPECT_EQ(written->last_ns, kBegin_ns + 59'999 * 4'000'000LL);
  EXPECT_GE(written->points.size(), 4U);
}

TEST_F(MatchLog, AnotherFilesIndexIsIgnored) {
  write_match(file(), 100);
  const std::string index = contents(index_file_of(file()));
  fs::remove(file());
  fs::remove(index_file_of(file()));
  write_match(file(), 101);
  for (const std::string& other : {index, std::string("{"), std::string("[]"), std::string("")}) {
    write(index_file_of(file()), other);
    EXPECT_FALSE(read_match_log_index(file()).has_value());
    EXPECT_EQ(match_log_index(file()).messages.at(LoggedMessage::kVision2014), 68U);
    EXPECT_TRUE(read_match_log_index(file()).has_value()) << "it was put there again";
  }
}

TEST_F(MatchLog, AWrongIndexIsRebuilt) {
  write_match(file(), 20'000);
  const MatchLogIndex right = *read_match_log_index(file());
  ASSERT_FALSE(right.points.empty());
  const Json json = Json::parse(contents(index_file_of(file())));
  const auto tried = [&](const char* place, const Json& value) {
    Json lie = json;
    lie[Json::json_pointer(place)] = value;
    write(index_file_of(file()), lie.dump());
    EXPECT_FALSE(read_match_log_index(file()).has_value()) << place << " " << value;
    EXPECT_EQ(match_log_index(file()), right);
  };
  tried("/points/0/0", right.file_bytes + 1);
  tried("/points/0/0", -1);
  tried("/points/0/1", 1e300);
  tried("/points/0/2", 0);
  tried("/messages/4", -1);
  tried("/first_ns", right.last_ns + 1);
  tried("/last_ns", 1.5);
  tried("/events", Json{{{"time_ns", 1}, {"kind", "none"}, {"text", ""}}});
}

TEST_F(MatchLog, ReportsThatItWasRemovedWhileWriting) {
  MatchLogWriter out(file());
  Match match;
  add(out, match.next());
  out.flush();
  fs::remove(file());
  add(out, match.next());
  EXPECT_THROW(out.flush(), StorageError);
}

TEST_F(MatchLog, RepairingStopsOnRequest) {
  std::stop_source stop;
  stop.request_stop();
  write_match(file(), 100);
  EXPECT_THROW(repair_match_log(file(), stop.get_token()), StorageError);
  EXPECT_THROW(repair_match_log("/dev/zero"), StorageError);
}

TEST_F(MatchLog, GoesToAnyTime) {
  const auto written = write_match(file(), 60'000);
  std::string plain;
  {
    PackedFile packed(file());
    std::vector<std::byte> piece(1 << 20);
    while (const std::size_t count = packed.read(piece))
      plain.append(reinterpret_cast<const char*>(piece.data()), count);
  }
  write(file("match.log"), plain);
  for (const char* name : {"match.log.gz", "match.log"}) {
    SCOPED_TRACE(name);
    const MatchLogIndex index = match_log_index(file(name));
    EXPECT_GE(index.points.size(), 4U);
    MatchLogReader reader(file(name));
    LoggedMessage message;
    for (const std::size_t i : {59'999U, 0U, 1U, 30'000U, 12'345U, 12'346U, 59'998U}) {
      reader.go_to(written[i].time_ns, index);
      ASSERT_TRUE(reader.next(message));
      expect_same(message, written[i]);
      reader.go_to(written[i].time_ns - 1, index);
      ASSERT_TRUE(reader.next(message));
      expect_same(message, written[i]);
    }
    reader.go_to(written.back().time_ns + 1, index);
    EXPECT_FALSE(reader.next(message));
    EXPECT_EQ(reader.problem(), "");
    reader.go_to(0, index);
    for (std::size_t i = 0; i < written.size(); i += 1) {
      ASSERT_TRUE(reader.next(message));
      if (i % 1000 == 0) expect_same(message, written[i]);
    }
  }
}

// The clock was set back: a time occurs twice.
TEST_F(MatchLog, GoesToTheFirstMessageOfATimeThatCameTwice) {
  {
    Match match;
    MatchLogWriter out(file());
    for (int i = 0; i < 50'000; ++i) {
      LoggedMessage message = match.next();
      if (i >= 25'000) message.time_ns -= 40'000'000'000;
      add(out, message);
    }
    out.finish();
  }
  MatchLogReader reader(file());
  LoggedMessage message;
  const std::int64_t time_ns = kBegin_ns + 4'000'000LL * 20'000;
  reader.go_to(time_ns, match_log_index(file()));
  ASSERT_TRUE(reader.next(message));
  EXPECT_EQ(message.time_ns, time_ns);
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(message.bytes.data()), 11), "frame 20000");
}

TEST_F(MatchLog, FlushedMessagesSurviveAPowerCutAnywhere) {
  // The file on a disk that lost power: flushed data is complete; of the rest, some pages are written and
  // others zero.
  Match match;
  MatchLogWriter out(file("whole.log.gz"));
  struct Flush {
    std::uint64_t bytes;
    std::size_t messages;
  };
  std::vector<LoggedMessage> messages;
  std::vector<Flush> flushes;
  for (int i = 0; i < 12'000; ++i) {
    add(out, messages.emplace_back(match.next()));
    if (i % 97 == 96) {
      out.flush();
      flushes.push_back({out.bytes(), messages.size()});
    }
  }
  out.finish();
  const std::string whole = contents(file("whole.log.gz"));
  std::mt19937 chance(7);
  for (int i = 0; i < 200; ++i) {
    const std::size_t size = chance() % (whole.size() + 1);
    std::string cut = whole.substr(0, size);
    const auto behind =
        std::ranges::partition_point(flushes, [&](const Flush& flush) { return flush.bytes <= size; });
    const Flush safe = behind == flushes.begin() ? Flush{0, 0} : *(behind - 1);
    constexpr std::size_t kPage = 4096;
    for (std::size_t page = safe.bytes / kPage * kPage; page < cut.size() && i % 2 == 1; page += kPage) {
      if (chance() % 2 == 0) continue;
      for (std::size_t j = std::max<std::size_t>(page, safe.bytes); j < std::min(page + kPage, cut.size());
           ++j)
        cut[j] = '\0';
    }
    write(file(), cut);
    if (safe.messages == 0) {
      EXPECT_NO_THROW(try { repair_match_log(file()); } catch (const StorageError&){});
      continue;
    }
    repair_match_log(file());
    const WasRead was_read = read(file());
    EXPECT_EQ(was_read.problem, "") << "cut at " << size;
    ASSERT_GE(was_read.messages.size(), safe.messages) << "cut at " << size;
    for (std::size_t j = 0; j < safe.messages; j += 13) expect_same(was_read.messages[j], messages[j]);
    expect_same(was_read.messages[safe.messages - 1], messages[safe.messages - 1]);
    EXPECT_TRUE(repair_match_log(file()).was_whole) << "it is whole now";
    if (i % 10 == 0) {
      EXPECT_EQ(std::system(fmt::format("gzip -t {}", file().string()).c_str()), 0)
          << "other programs say so too";
    }
  }
}

TEST_F(MatchLog, AWriterThatGoesAwayLeavesWhatItFlushed) {
  std::vector<LoggedMessage> messages;
  {
    Match match;
    MatchLogWriter out(file());
    for (int i = 0; i < 500; ++i) add(out, messages.emplace_back(match.next()));
    out.flush();
    for (int i = 0; i < 5; ++i) add(out, match.next());
  }
  EXPECT_THAT(read(file()).messages, SizeIs(::testing::Ge(500U))) << "as it is";
  EXPECT_THAT(read(file()).problem, HasSubstr("is cut off"));
  EXPECT_FALSE(repair_match_log(file()).was_whole);
  const WasRead was_read = read(file());
  EXPECT_EQ(was_read.problem, "");
  ASSERT_THAT(was_read.messages, SizeIs(500));
  expect_same(was_read.messages.back(), messages.back());
}

TEST_F(MatchLog, AFileOfThatNameStaysAsItIs) {
  write(file(), "of somebody else");
  EXPECT_THROW(MatchLogWriter{file()}, StorageError);
  EXPECT_TRUE(repair_match_log(file()).is_other);
  EXPECT_EQ(contents(file()), "of somebody else");
  EXPECT_THROW(MatchLogWriter{folder_.path() / "no" / "folder.log.gz"}, StorageError);
}

/// Packs text as another program does: one gzip member without flushes.
std::string packed(const std::string& text) {
  const test::TemporaryFolder folder;
  const std::string name = (folder.path() / "x.gz").string();
  gzFile out = gzopen(name.c_str(), "wb");
  gzwrite(out, text.data(), static_cast<unsigned>(text.size()));
  gzclose(out);
  return contents(name);
}

TEST_F(MatchLog, ACutLogOfAnotherProgramIsRewrittenWithAllItsMessages) {
  const auto written = write_match(file("ours.log.gz"), 2'000);
  convert_match_log(file("ours.log.gz"), file("plain.log"));
  const std::string whole = packed(contents(file("plain.log")));
  const std::string cut = whole.substr(0, whole.size() / 2);
  write(file(), cut);
  EXPECT_TRUE(repair_match_log(file()).is_other);
  EXPECT_EQ(contents(file()), cut);
  const std::size_t readable = read(file()).messages.size();
  EXPECT_GT(readable, written.size() / 3);

  EXPECT_THAT(repair_any_log(file()), HasSubstr("is cut off"));
  EXPECT_EQ(contents(file().string() + ".damaged"), cut);
  EXPECT_FALSE(fs::exists(file().string() + ".rewritten"));
  const WasRead was_read = read(file());
  EXPECT_EQ(was_read.problem, "");
  ASSERT_EQ(was_read.messages.size(), readable);
  expect_same(was_read.messages.back(), written[readable - 1]);
  EXPECT_THROW(repair_any_log(file()), StorageError) << "the damaged file is kept";
  fs::remove(file().string() + ".damaged");
  EXPECT_EQ(repair_any_log(file()), "is whole");

  // Behind a log of ours, which has flushes.
  const std::string ours = contents(file("ours.log.gz"));
  write(file(), ours + cut);
  repair_any_log(file());
  EXPECT_EQ(read(file()).messages.size(), written.size() + readable);
  EXPECT_EQ(read(file()).problem, "");
}

TEST_F(MatchLog, EmptyLogsInAFileAreFew) {
  const std::string head("SSL_LOG_FILE\0\0\0\1", 16),
      empty_index = std::string(11, '\0') + '\6' + std::string(4, '\0');
  EXPECT_EQ(error_of(head + head + head), "");
  EXPECT_EQ(error_of(head + empty_index + head), "");
  std::string many = head;
  for (int i = 0; i < 100; ++i) many += empty_index;
  EXPECT_EQ(error_of(many), "bad.log: has many logs without messages");
  EXPECT_EQ(error_of(head + std::string("\0\0\0\0\0\0\0\0\0\0\0\6\x7f\0\0\0", 16)),
            "bad.log: the index after message 0 is larger than its log");
  EXPECT_EQ(error_of(head + std::string("\0\0\0\0\0\0\0\0\0\0\0\6\0\0\0\5", 16) + "1234"),
            "bad.log: the index after message 0 is cut off");
  write(file(), "");
  EXPECT_TRUE(repair_match_log(file()).is_other);
}

TEST_F(MatchLog, SeveralLogsInOneFileAreReadAsOne) {
  const auto written = write_match(file("ours.log.gz"), 2'000);
  convert_match_log(file("ours.log.gz"), file("plain.log"));
  const std::string ours = contents(file("ours.log.gz")), plain = contents(file("plain.log"));
  const auto expect_twice = [&](const fs::path& log) {
    const WasRead was_read = read(log);
    EXPECT_EQ(was_read.problem, "");
    ASSERT_EQ(was_read.messages.size(), 2 * written.size());
    expect_same(was_read.messages[written.size()], written[0]);
    expect_same(was_read.messages.back(), written.back());
  };
  for (const std::string& text : {ours + ours, packed(plain) + packed(plain), packed(plain) + ours}) {
    write(file(), text);
    expect_twice(file());
    EXPECT_TRUE(repair_match_log(file()).was_whole);
    EXPECT_EQ(contents(file()), text);
  }
  write(file("twice.log"), plain + plain);
  expect_twice(file("twice.log"));
  write(file("twice.log"), plain + "rest");
  EXPECT_EQ(read(file("twice.log")).messages.size(), written.size());
  EXPECT_THAT(read(file("twice.log")).problem, HasSubstr("message 2001 is cut off"));
}

TEST_F(MatchLog, SaysWhatIsWrongInOneLine) {
  const std::string head("SSL_LOG_FILE\0\0\0\1", 16);
  const std::string time("\0\0\0\0\0\0\0\5", 8), type("\0\0\0\4", 4), size("\0\0\0\12", 4);
  EXPECT_EQ(error_of(head), "");
  EXPECT_EQ(error_of("RIFF....WAVE"),
            "bad.log: is not a log of the league: it does not begin with SSL_LOG_FILE");
  EXPECT_EQ(error_of(""), "bad.log: is not a log of the league: it does not begin with SSL_LOG_FILE");
  EXPECT_EQ(error_of("SSL_LOG_FILE"), "bad.log: is not a log of the league: it ends in its header");
  EXPECT_EQ(error_of(std::string("SSL_LOG_FILE\0\0\0\2", 16)),
            "bad.log: log version 2 is unknown; expected 1");
  const std::string old =
      "bad.log: is a log of version 0, which old programs wrote with Qt; expected version 1";
  EXPECT_EQ(error_of(std::string("SSL_LOG_FILE\0\0\0\0", 16)), old);
  EXPECT_EQ(error_of(std::string("\0\0\0\30\0S\0S\0L\0_\0L\0O\0G\0_\0F\0I\0L\0E", 28)), old);
  EXPECT_EQ(error_of(head + time + type), "bad.log: message 1 is cut off");
  EXPECT_EQ(error_of(head + time + type + size + "short"), "bad.log: message 1 is cut off");
  EXPECT_EQ(error_of(head + time + type + size + "0123456789"), "");
  EXPECT_EQ(error_of(head + time + type + std::string("\xff\0\0\1", 4)),
            "bad.log: message 1 is larger than any packet");
  EXPECT_EQ(error_of(head + time + type + std::string("\0\xff\0\1", 4)),
            "bad.log: message 1 is larger than any packet");
  EXPECT_EQ(error_of("\x1f\x8b rest"), "bad.log: is damaged: its compressed data is invalid");
  EXPECT_THROW(MatchLogReader{file("none.log")}, StorageError);
  EXPECT_THROW(MatchLogReader{folder_.path()}, StorageError);
}

TEST_F(MatchLog, DamageIsNoticedAndWhatCameBeforeIsKept) {
  const auto written = write_match(file(), 20'000);
  std::string bytes = contents(file());
  bytes[bytes.size() * 3 / 4] ^= 0x55;
  fs::remove(index_file_of(file()));
  write(file(), bytes);
  const WasRead was_read = read(file());
  EXPECT_THAT(was_read.problem,
              ::testing::AnyOf(HasSubstr("is damaged"), HasSubstr("is larger than any packet"),
                               HasSubstr("has an invalid time")));
  EXPECT_GT(was_read.messages.size(), written.size() / 2);
  EXPECT_NE(match_log_index(file()).problem, "");
}

TEST_F(MatchLog, SurvivesArbitraryBytes) {
  write_match(file(), 2'000);
  const std::string whole = contents(file());
  std::mt19937 chance(3);
  for (int i = 0; i < 300; ++i) {
    std::string bytes = whole.substr(0, i % 3 == 0 ? chance() % whole.size() : whole.size());
    for (unsigned j = 0; j < chance() % 20 && !bytes.empty(); ++j)
      bytes[chance() % bytes.size()] = static_cast<char>(chance());
    write(file(), bytes);
    fs::remove(index_file_of(file()));
    try {
      const MatchLogIndex index = match_log_index(file());
      MatchLogReader reader(file());
      reader.go_to(kBegin_ns + 1'000'000'000, index);
      LoggedMessage message;
      while (reader.next(message)) {
      }
    } catch (const StorageError&) {
    }
    try {
      repair_match_log(file());
      const auto repaired = read(file());
      EXPECT_EQ(repaired.problem, "");
    } catch (const StorageError&) {
    }
  }
}

TEST_F(MatchLog, HighlyCompressedLogsTakeLittleMemory) {
  // 64 MiB of empty messages, which compress to a small file.
  gzFile out = gzopen(file().c_str(), "wb9");
  gzwrite(out, "SSL_LOG_FILE\0\0\0\1", 16);
  const std::string zeros(1 << 20, '\0');
  for (int i = 0; i < 64; ++i) gzwrite(out, zeros.data(), static_cast<unsigned>(zeros.size()));
  gzclose(out);
  const MatchLogIndex index = make_match_log_index(file());
  EXPECT_EQ(index.messages.at(0), 64U << 16U);
  EXPECT_THAT(index.points, IsEmpty());
}

TEST_F(MatchLog, NeedsNoIndexWhenComplete) {
  fs::create_directories(index_file_of(file()) / "in the way");
  const std::vector<LoggedMessage> messages = write_match(file(), 100);
  const WasRead log = read(file());
  EXPECT_EQ(log.problem, "");
  EXPECT_THAT(log.messages, SizeIs(messages.size()));
}

TEST_F(MatchLog, MessagesWithImpossibleTimesAreSkipped) {
  for (const std::int64_t time_ns : {std::int64_t{-1}, std::numeric_limits<std::int64_t>::min(),
                                     std::numeric_limits<std::int64_t>::max(), std::int64_t{1} << 62}) {
    fs::remove(file());
    {
      MatchLogWriter out(file());
      out.add(kBegin_ns, LoggedMessage::kVision2014, bytes_of("good"));
      out.add(time_ns, LoggedMessage::kVision2014, bytes_of("bad"));
      out.finish();
    }
    const WasRead log = read(file());
    EXPECT_THAT(log.messages, SizeIs(1));
    EXPECT_THAT(log.problem, HasSubstr("message 2 has an invalid time"));
    const MatchLogIndex index = match_log_index(file());
    EXPECT_EQ(index.last_ns, kBegin_ns);
  }
}

TEST_F(MatchLog, AnIndexTakesLittleMemory) {
  if (!counts_allocations()) GTEST_SKIP() << "the sanitizer has its own allocator";
  write_match(file(), 10);
  const std::string good = contents(index_file_of(file()));
  for (const char* value : {R"("")", "[]", "{}", R"({"":{}})", "[0,0,0,0]"}) {
    for (const int count : {39'000, 1'000'000}) {
      std::string lie = good.substr(0, good.rfind('}')) + R"(,"more":[)" + value;
      for (int i = 1; i < count; ++i) lie.append(",").append(value);
      write(index_file_of(file()), lie + "]}");
      EXPECT_TRUE(test::fits_into(test::kMemoryForAFile, [&] { read_match_log_index(file()); })) << value;
      EXPECT_EQ(read_match_log_index(file()).has_value(), count < 100'000) << value;
    }
  }
  fs::resize_file(index_file_of(file()), 64 << 20);
  EXPECT_TRUE(test::fits_into(test::kMemoryForAFile, [&] { read_match_log_index(file()); }));
}

/// The index of a log of any length can be read again.
TEST(MatchLogIndexMaker, LeavesOutPointsOfAVeryLongLog) {
  MatchLogIndexMaker maker;
  LoggedMessage message{.time_ns = kBegin_ns, .type = LoggedMessage::kVision2014, .bytes = bytes_of("x")};
  for (std::uint64_t i = 0; i < 100'000; ++i) {
    const std::uint64_t offset = kLogHeaderBytes + (i << 20U);
    maker.add(message, offset, {offset, offset});
    message.time_ns += 1'000'000;
  }
  const std::vector<MatchLogPoint>& points = maker.index().points;
  EXPECT_LE(points.size(), 16'384U);
  EXPECT_GE(points.size(), 8'192U);
  for (std::size_t i = 1; i < points.size(); ++i) {
    ASSERT_GT(points[i].place.offset, points[i - 1].place.offset);
    ASSERT_LE(points[i].place.offset - points[i - 1].place.offset, std::uint64_t{16} << 20U);
    ASSERT_EQ(points[i].place.offset, kLogHeaderBytes + (points[i].messages << 20U));
  }
}

TEST_F(MatchLog, ReadsThePacketsOfARealMatch) {
  const auto path = test_data_folder() / "logs/roboime_larc2016_cyrosxfei2.log";
  if (!fs::exists(path)) GTEST_SKIP() << "no recorded match at " << path;
  const MatchLogIndex index = make_match_log_index(path);
  EXPECT_EQ(index.messages.at(LoggedMessage::kVision2014), 7992U);
  EXPECT_EQ(index.messages.at(LoggedMessage::kVision2010), 7992U);
  EXPECT_EQ(index.messages.at(LoggedMessage::kReferee), 1328U);
  EXPECT_EQ(index.problem, "");
  MatchLogReader all(path), from_point(path);
  std::vector<LoggedMessage> messages;
  for (LoggedMessage message; all.next(message);) messages.push_back(message);
  LoggedMessage message;
  for (std::size_t i = 0; i < messages.size(); i += 500) {
    from_point.go_to(messages[i].time_ns, index);
    ASSERT_TRUE(from_point.next(message));
    EXPECT_GE(message.time_ns, messages[i].time_ns);
    const auto first = std::ranges::find_if(
        messages, [&](const LoggedMessage& one) { return one.time_ns >= messages[i].time_ns; });
    expect_same(message, *first);
  }
}

// ---- events

struct PlayedMatch {
  MatchEventFinder finder;
  std::vector<MatchEvent> events;
  std::int64_t time_ns = kBegin_ns;

  void say(const google::protobuf::MessageLite& message, std::int32_t type) {
    time_ns += 100'000'000;
    finder.add({time_ns, type, bytes_of(message.SerializeAsString())}, events);
  }
  void referee(int stage, int command, unsigned yellow, unsigned blue, const std::string& source = "gc",
               const std::string& name = "Immortals") {
    Referee message;
    message.set_stage(stage);
    message.set_command(command);
    message.mutable_yellow()->set_name(name);
    message.mutable_yellow()->set_score(yellow);
    message.mutable_blue()->set_name("TIGERs");
    message.mutable_blue()->set_score(blue);
    message.set_source_identifier(source);
    say(message, LoggedMessage::kReferee);
  }
  void kick(double start_s, float speed_m_s, const std::string& uuid = "ours") {
    TrackerWrapperPacket message;
    message.set_uuid(uuid);
    TrackedFrame& frame = *message.mutable_tracked_frame();
    frame.set_frame_number(1);
    frame.set_timestamp(start_s + 0.25);
    KickedBall& ball = *frame.mutable_kicked_ball();
    ball.mutable_pos()->set_x(0);
    ball.mutable_pos()->set_y(0);
    ball.mutable_vel()->set_x(speed_m_s);
    ball.mutable_vel()->set_y(0);
    ball.mutable_vel()->set_z(0);
    ball.set_start_timestamp(start_s);
    ball.mutable_robot_id()->set_id(4);
    ball.mutable_robot_id()->set_team(BLUE);
    say(message, LoggedMessage::kTracker2020);
  }
  std::vector<std::string> texts() const {
    std::vector<std::string> out;
    for (const MatchEvent& event : events)
      out.push_back(fmt::format("{}: {}", name_of(event.kind), event.text));
    return out;
  }
};

TEST(MatchEvents, TellCommandsStagesGoalsAndKicks) {
  PlayedMatch match;
  match.referee(0, 0, 0, 0);
  match.referee(1, 5, 0, 0);
  match.referee(1, 5, 0, 0);
  match.referee(1, 2, 0, 0);
  match.kick(100, 6.5F);
  match.kick(100.01, 6.4F);
  match.kick(103, 3);
  match.referee(1, 1, 0, 1);
  match.referee(13, 0, 0, 1);
  EXPECT_THAT(match.texts(),
              ElementsAre("stage: Before the first half", "command: Halt", "stage: First half",
                          "command: Kick-off, blue", "command: Normal start", "kick: Kick by blue 4, 6.5 m/s",
                          "kick: Kick by blue 4, 3.0 m/s", "command: Stop", "goal: Goal for TIGERs: 0 : 1",
                          "stage: Match over", "command: Halt"));
  EXPECT_EQ(match.events[5].time_ns, kBegin_ns + 500'000'000 - 250'000'000)
      << "when it was kicked, not when it was told";
}

TEST(MatchEvents, IgnoreKicksWithoutATime) {
  PlayedMatch match;
  constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  for (const double start_s : {kNoNumber, kEndless, -kEndless, kNoNumber}) match.kick(start_s, 6.5F);
  EXPECT_THAT(match.texts(), IsEmpty());
  match.kick(100, 6.5F);
  EXPECT_THAT(match.texts(), SizeIs(1));
}

TEST(MatchEvents, FollowOneOfSeveralSources) {
  PlayedMatch match;
  match.referee(1, 2, 0, 0);
  match.referee(4, 0, 5, 5, "another hall");
  match.kick(100, 6.5F);
  match.kick(100.2, 6.5F, "another tracker");
  EXPECT_THAT(match.texts(),
              ElementsAre("stage: First half", "command: Normal start", "kick: Kick by blue 4, 6.5 m/s"));
  match.time_ns += 6'000'000'000;
  match.referee(4, 0, 5, 5, "another hall");
  EXPECT_EQ(match.events.size(), 7U) << "the first is gone";
}

TEST(MatchEvents, ALongNameIsCut) {
  PlayedMatch match;
  for (unsigned i = 0; i < 3; ++i) match.referee(1, 2, i, 0, "gc", std::string(60'000, 'A'));
  ASSERT_EQ(match.events.size(), 4U);
  EXPECT_LT(match.events.back().text.size(), 100U);
}

TEST(MatchEvents, UnknownNumbersAreToldAsNumbers) {
  PlayedMatch match;
  match.referee(99, -1, 0, 0);
  EXPECT_THAT(match.texts(), ElementsAre("stage: Stage 99", "command: Command -1"));
}

}  // namespace
}  // namespace sslv::match_log_test
