// SPDX-License-Identifier: Apache-2.0
#include "recording/match_log_index.h"

#include "base/error.h"
#include "base/json.h"
#include "recording/match_log_reader.h"
#include "settings/state_folder.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <new>
#include <stdexcept>
#include <system_error>

#include <fmt/format.h>
#include <zlib.h>

namespace sslv {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFormat = "ssl-visiond log index";
constexpr int kVersion = 1;
/// Larger index files are ignored, so that reading one takes at most 64 MB of memory. This
/// program's index files are smaller.
constexpr std::uint64_t kMaxIndexBytes = std::uint64_t{8} << 20U;
constexpr std::size_t kMaxIndexValues = 200'000;  // number of JSON values in an index file

constexpr std::size_t kMaxPoints = 1 << 14;

/// Limit of counted message types: programs may use many types of their own.
constexpr std::size_t kMaxTypes = 64;

/// Limit of an event's text.
constexpr std::size_t kMaxTextBytes = 200;

constexpr std::streamoff kSignedBytes = 4096;

Json to_json(const MatchLogIndex& index) {
  Json messages = Json::object();
  for (const auto& [type, count] : index.messages) messages[std::to_string(type)] = count;
  Json points = Json::array();
  for (const MatchLogPoint& point : index.points)
    points.push_back({point.place.file_offset, point.place.offset, point.messages, point.all_before_ns});
  Json events = Json::array();
  for (const MatchEvent& event : index.events)
    events.push_back({{"time_ns", event.time_ns}, {"kind", name_of(event.kind)}, {"text", event.text}});
  return {{"format", kFormat},
          {"version", kVersion},
          {"file_bytes", index.file_bytes},
          {"end_crc32", index.end_sum},
          {"unpacked_bytes", index.unpacked_bytes},
          {"messages", std::move(messages)},
          {"first_ns", index.first_ns},
          {"last_ns", index.last_ns},
          {"points", std::move(points)},
          {"events", std::move(events)},
          {"tracker_crc32", index.tracker_sum},
          {"problem", index.problem}};
}

/// Throws std::exception for values that no log can have: the file is untrusted.
MatchLogIndex index_of(const Json& json) {
  const auto require = [](bool holds) {
    if (!holds) throw std::invalid_argument("is not an index");
  };
  const auto count = [&](const Json& number) {
    require(number.is_number_unsigned());
    return number.get<std::uint64_t>();
  };
  const auto time = [&](const Json& number) {
    require(number.is_number_integer());
    const auto time_ns = number.get<std::int64_t>();
    require(is_log_time(time_ns));
    return time_ns;
  };
  MatchLogIndex index;
  index.file_bytes = count(json.at("file_bytes"));
  index.end_sum = static_cast<std::uint32_t>(count(json.at("end_crc32")));
  index.unpacked_bytes = count(json.at("unpacked_bytes"));
  for (const auto& [type, number] : json.at("messages").items())
    index.messages[std::stoi(type)] = count(number);
  index.first_ns = time(json.at("first_ns"));
  index.last_ns = time(json.at("last_ns"));
  require(index.last_ns >= index.first_ns);
  for (const Json& point : json.at("points")) {
    const MatchLogPoint next{{count(point.at(0)), count(point.at(1))}, count(point.at(2)), time(point.at(3))};
    const MatchLogPoint before = index.points.empty() ? MatchLogPoint{} : index.points.back();
    require(next.place.file_offset > before.place.file_offset && next.place.offset > before.place.offset &&
            next.messages > before.messages && next.place.file_offset < index.file_bytes);
    require(index.points.empty() || next.all_before_ns >= before.all_before_ns);
    index.points.push_back(next);
  }
  require(json.at("events").size() <= MatchEventFinder::kMaxEvents);
  for (const Json& event : json.at("events")) {
    index.events.push_back({time(event.at("time_ns")), event_kind(event.at("kind").get<std::string>()),
                            shortened(event.at("text").get<std::string>(), kMaxTextBytes)});
  }
  index.tracker_sum = static_cast<std::uint32_t>(count(json.at("tracker_crc32")));
  index.problem = shortened(json.at("problem").get<std::string>(), SettingsError::kMaxBytes);
  return index;
}

}  // namespace

void MatchLogIndexMaker::add(const LoggedMessage& message, std::uint64_t offset, const UnpackPlace& place) {
  if (messages_ == 0) index_.first_ns = index_.last_ns = message.time_ns;
  const bool may_begin_here = place.offset == offset && messages_ > 0;
  const std::uint64_t before = index_.points.empty() ? 0 : index_.points.back().place.offset;
  if (may_begin_here && offset - before >= between_points_) {
    index_.points.push_back({place, messages_, index_.last_ns});
    if (index_.points.size() == kMaxPoints) {
      for (std::size_t i = 0; 2 * i + 1 < kMaxPoints; ++i) index_.points[i] = index_.points[2 * i + 1];
      index_.points.resize(kMaxPoints / 2);
      between_points_ *= 2;
    }
  }
  index_.last_ns = std::max(index_.last_ns, message.time_ns);
  ++messages_;
  if (index_.messages.size() < kMaxTypes || index_.messages.contains(message.type))
    ++index_.messages[message.type];
  index_.unpacked_bytes = offset + kMessageHeaderBytes + message.bytes.size();
  events_.add(message, index_.events);
  if (index_.tracker_sum == 0 && message.type == LoggedMessage::kTracker2020)
    index_.tracker_sum = tracker_sum_of(events_.tracker());
}

std::uint32_t tracker_sum_of(std::string_view uuid) {
  return static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(uuid.data()), static_cast<uInt>(uuid.size())));
}

MatchLogIndex make_match_log_index(const fs::path& log, const std::stop_token& stop) {
  MatchLogReader reader(log);
  MatchLogIndexMaker maker;
  LoggedMessage message;
  std::string problem;
  while (reader.next(message)) {
    if (stop.stop_requested()) throw StorageError(fmt::format("{}: was not read to its end", log.string()));
    if (reader.message_offset() > kMaxUnpackedBytes) {
      problem = fmt::format("{}: is larger than {} GiB when unpacked; the rest is ignored", log.string(),
                            kMaxUnpackedBytes >> 30U);
      break;
    }
    maker.add(message, reader.message_offset(), reader.place());
  }
  MatchLogIndex index = maker.take();
  index.problem = problem.empty() ? reader.problem() : problem;
  sign_match_log_index(log, index);
  return index;
}

fs::path index_file_of(const fs::path& log) {
  return log.string() + ".index";
}

void sign_match_log_index(const fs::path& log, MatchLogIndex& index) {
  std::ifstream in(log, std::ios::binary | std::ios::ate);
  const std::streamoff size = in.tellg();
  std::array<char, kSignedBytes> end{};
  in.seekg(std::max<std::streamoff>(0, size - kSignedBytes));
  in.read(end.data(), std::min(size, kSignedBytes));
  if (!in) throw StorageError(fmt::format("{}: cannot be read", log.string()));
  index.file_bytes = static_cast<std::uint64_t>(size);
  index.end_sum = static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(end.data()), static_cast<uInt>(in.gcount())));
}

std::optional<MatchLogIndex> read_match_log_index(const fs::path& log) {
  const fs::path file = index_file_of(log);
  std::error_code error;
  if (!fs::is_regular_file(file, error) || fs::file_size(file, error) > kMaxIndexBytes) return std::nullopt;
  std::ifstream in(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  try {
    const auto values = std::ranges::count_if(text, [](char c) { return c == ',' || c == '[' || c == '{'; });
    if (static_cast<std::size_t>(values) > kMaxIndexValues) return std::nullopt;
    const Json json = parse_bounded_json(text);
    if (json.at("format") != kFormat || json.at("version") != kVersion) return std::nullopt;
    MatchLogIndex index = index_of(json), now;
    sign_match_log_index(log, now);
    if (now.file_bytes != index.file_bytes || now.end_sum != index.end_sum) return std::nullopt;
    return index;
  } catch (const std::bad_alloc&) {  // the index may be valid
    throw;
  } catch (const std::exception&) {  // invalid: the caller makes a new one
    return std::nullopt;
  }
}

void write_match_log_index(const fs::path& log, const MatchLogIndex& index) {
  write_file_durably(index_file_of(log), json_text(to_json(index)) + "\n");
}

MatchLogIndex match_log_index(const fs::path& log, const std::stop_token& stop) {
  if (auto index = read_match_log_index(log)) return *std::move(index);
  MatchLogIndex index = make_match_log_index(log, stop);
  try {
    write_match_log_index(log, index);
  } catch (const StorageError&) {
    // The folder is read-only: the next call makes the index again.
  }
  return index;
}

}  // namespace sslv
