// SPDX-License-Identifier: Apache-2.0
// The cost of match logs, as a table in Markdown: match_log_table [LOG]. Repeats LOG to make a match of two
// hours; without LOG, uses generated packets.
#include "base/error.h"
#include "net/packets.h"
#include "net/tracker_packets.h"
#include "recording/match_log_index.h"
#include "recording/match_log_reader.h"
#include "recording/match_log_writer.h"
#include "ssl_vision_wrapper.pb.h"
#include "support/temporary_folder.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <zlib.h>

namespace sslv {
namespace {

constexpr std::int64_t kTwoHours_ns = 2 * 3600 * std::int64_t{1'000'000'000};

class Watch {
 public:
  double ms() const {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin_).count();
  }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

/// One minute of four cameras at 60 Hz that see 22 robots driving in circles, with pixel noise, and of their
/// tracks at 30 Hz.
std::vector<LoggedMessage> drawn_minute() {
  std::vector<LoggedMessage> out;
  std::vector<std::byte> buffer;
  std::mt19937 chance(1);
  std::normal_distribution<double> noise(0, 0.3);
  for (std::uint32_t frame = 0; frame < 60 * 60; ++frame) {
    for (std::uint32_t camera = 0; camera < 4; ++camera) {
      const double t_s = 1.8e9 + frame / 60.0 + camera * 1e-3;
      RobotList robots;
      for (int i = static_cast<int>(camera); i < 22; i += 4) {
        Robot& robot = robots.robots.emplace_back();
        robot.team = i < 11 ? Team::kYellow : Team::kBlue;
        robot.id = i % 11;
        robot.x_mm = 300.0 * i - 3000 + 200 * std::cos(t_s + i) + noise(chance);
        robot.y_mm = 200 * std::sin(t_s + i) + noise(chance);
        robot.orientation_rad = std::remainder(t_s + i, 2 * M_PI);
        robot.confidence = 0.9 + 0.1 * std::abs(noise(chance));
      }
      SSL_WrapperPacket packet;
      write_detection(FrameInfo{.camera_id = camera, .number = frame, .times = {.t_capture_s = t_s}}, robots,
                      {}, t_s, packet);
      const auto bytes = serialize(packet, buffer);
      out.push_back(
          {static_cast<std::int64_t>(t_s * 1e9), LoggedMessage::kVision2014, {bytes.begin(), bytes.end()}});
    }
    if (frame % 2 != 0) continue;
    TrackedField tracked{.number = frame, .t_s = 1.8e9 + frame / 60.0 + 4e-3};
    for (int i = 0; i < 22; ++i) {
      TrackedRobot& robot = tracked.robots.emplace_back();
      robot.name = {i < 11 ? Team::kYellow : Team::kBlue, i % 11};
      const double phase = tracked.t_s + i;
      robot.place_mm = {300.0 * i - 3000 + 200 * std::cos(phase) + noise(chance),
                        200 * std::sin(phase) + noise(chance)};
      robot.velocity_mm_s = {-200 * std::sin(phase) + noise(chance), 200 * std::cos(phase) + noise(chance)};
      robot.orientation_rad = std::remainder(phase, 2 * M_PI);
      robot.turn_rad_s = 1 + 0.01 * noise(chance);
      robot.visibility = 1;
    }
    TrackerWrapperPacket packet;
    write_tracked(tracked, {"7f6c7a52-43a8-4e0a-8f39-0f4d0a8b2c11", "ssl-visiond"}, packet);
    const auto bytes = serialize(packet, buffer);
    out.push_back({static_cast<std::int64_t>(tracked.t_s * 1e9),
                   LoggedMessage::kTracker2020,
                   {bytes.begin(), bytes.end()}});
  }
  return out;
}

std::vector<LoggedMessage> messages_of(const std::filesystem::path& log) {
  MatchLogReader reader(log);
  std::vector<LoggedMessage> out;
  for (LoggedMessage message; reader.next(message);) out.push_back(message);
  return out;
}

/// Size in bytes of the same messages compressed as by `gzip -6`.
class AllAtOnce {
 public:
  AllAtOnce() { deflateInit2(&zlib_, 6, Z_DEFLATED, 16 + MAX_WBITS, 8, Z_DEFAULT_STRATEGY); }
  ~AllAtOnce() { deflateEnd(&zlib_); }
  AllAtOnce(const AllAtOnce&) = delete;
  AllAtOnce& operator=(const AllAtOnce&) = delete;
  void add(std::span<const std::byte> bytes, int flush = Z_NO_FLUSH) {
    zlib_.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(bytes.data()));
    zlib_.avail_in = static_cast<uInt>(bytes.size());
    do {
      std::array<Bytef, 64 * 1024> out;
      zlib_.next_out = out.data();
      zlib_.avail_out = out.size();
      deflate(&zlib_, flush);
    } while (zlib_.avail_out == 0);
  }
  std::uint64_t finish() {
    add({}, Z_FINISH);
    return zlib_.total_out;
  }

 private:
  z_stream zlib_{};
};

void print_table(const std::vector<LoggedMessage>& some, const std::string& source) {
  const test::TemporaryFolder folder;
  const std::filesystem::path log = folder.path() / "match.log.gz";
  const std::int64_t length_ns = some.back().time_ns - some.front().time_ns + 1'000'000;
  std::uint64_t messages = 0, plain_bytes = 0;
  double writing_ms = 0;
  std::uint64_t at_once_bytes;
  {
    MatchLogWriter writer(log);
    AllAtOnce at_once;
    std::int64_t flushed_ns = 0;
    for (std::int64_t begin_ns = 0; begin_ns < kTwoHours_ns; begin_ns += length_ns) {
      for (const LoggedMessage& message : some) {
        const std::int64_t at_ns = begin_ns + message.time_ns - some.front().time_ns;
        const Watch watch;
        writer.add(some.front().time_ns + at_ns, message.type, message.bytes);
        if (at_ns - flushed_ns >= 500'000'000) {
          writer.flush();
          flushed_ns = at_ns;
        }
        writing_ms += watch.ms();
        at_once.add(message_header(
            {some.front().time_ns + at_ns, message.type, static_cast<std::int32_t>(message.bytes.size())}));
        at_once.add(message.bytes);
        ++messages;
        plain_bytes += kMessageHeaderBytes + message.bytes.size();
      }
    }
    writer.finish();
    at_once_bytes = at_once.finish();
  }
  const Watch making;
  const MatchLogIndex made = make_match_log_index(log);
  const double making_ms = making.ms();

  std::vector<double> opening_ms, going_ms;
  std::mt19937_64 chance(2);
  std::optional<MatchLogIndex> index;
  for (int i = 0; i < 20; ++i) {
    const Watch watch;
    index = read_match_log_index(log);
    const MatchLogReader reader(log);
    opening_ms.push_back(watch.ms());
  }
  MatchLogReader reader(log);
  LoggedMessage message;
  for (int i = 0; i < 300; ++i) {
    const std::int64_t time_ns =
        index->first_ns +
        static_cast<std::int64_t>(chance() % static_cast<std::uint64_t>(index->last_ns - index->first_ns));
    const Watch watch;
    reader.go_to(time_ns, *index);
    if (!reader.next(message) || message.time_ns < time_ns)
      throw StorageError("the log does not go where it should");
    going_ms.push_back(watch.ms());
  }
  std::ranges::sort(opening_ms);
  std::ranges::sort(going_ms);
  const auto file_bytes = static_cast<double>(std::filesystem::file_size(log));
  const auto row = [](const std::string& what, const std::string& value) {
    std::printf("| %s | %s |\n", what.c_str(), value.c_str());
  };
  std::printf("Two hours of %s\n\n| | |\n|---|---|\n", source.c_str());
  row("messages, unpacked",
      fmt::format("{} messages, {:.0f} MB", messages, static_cast<double>(plain_bytes) * 1e-6));
  row("file, index", fmt::format("{:.1f} MB, {:.0f} kB", file_bytes * 1e-6,
                                 static_cast<double>(std::filesystem::file_size(index_file_of(log))) * 1e-3));
  row("size against `gzip -6` of the same",
      fmt::format("{:.3f}", file_bytes / static_cast<double>(at_once_bytes)));
  row("packing and writing, flushed twice a second",
      fmt::format("{:.2f} % of one core", writing_ms / (static_cast<double>(kTwoHours_ns) * 1e-6) * 100));
  row("open with its index, median (max)",
      fmt::format("{:.1f} ({:.1f}) ms", opening_ms[opening_ms.size() / 2], opening_ms.back()));
  row("go to a time, median (max of 300)",
      fmt::format("{:.1f} ({:.1f}) ms", going_ms[going_ms.size() / 2], going_ms.back()));
  row("make the index again",
      fmt::format("{:.1f} s{}", making_ms * 1e-3, made == *index ? "" : " (and it differs!)"));
}

}  // namespace
}  // namespace sslv

int main(int argc, char** argv) {
  try {
    if (argc > 1) {
      sslv::print_table(sslv::messages_of(argv[1]),
                        std::string("the log ") + std::filesystem::path(argv[1]).filename().string());
    } else {
      sslv::print_table(sslv::drawn_minute(), "drawn packets: 4 cameras at 60 Hz, 22 robots");
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "match_log_table: %s\n", error.what());
    return 1;
  }
}
