// SPDX-License-Identifier: Apache-2.0
#include "recording/match_log_reader.h"

#include "base/error.h"
#include "recording/match_log_index.h"

#include <algorithm>
#include <array>
#include <string_view>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Logs of version 0 are streams of Qt: a string's length (4 bytes), then two bytes for each character.
constexpr std::string_view kOldMagic{"\0S\0S\0L\0_\0L\0O", 12};

constexpr UnpackPlace kFirstMessage{kLogHeaderBytes, kLogHeaderBytes};

std::string_view text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

MatchLogReader::MatchLogReader(const std::filesystem::path& path) : name_(path.string()), file_(path) {
  std::array<std::byte, kLogHeaderBytes> head{};
  const std::size_t count = file_.read(head);
  const auto refuse = [&](const std::string& why) { throw StorageError(fmt::format("{}: {}", name_, why)); };
  if (count < head.size() && !file_.problem().empty()) refuse(file_.problem());
  constexpr const char* kVersion0 =
      "is a log of version 0, which old programs wrote with Qt; expected version 1";
  if (text(head).substr(4) == kOldMagic) refuse(kVersion0);
  if (text(head).substr(0, kLogMagic.size()) != kLogMagic)
    refuse(fmt::format("is not a log of the league: it does not begin with {}", kLogMagic));
  const auto& known = log_header();
  if (count == head.size() && std::ranges::equal(head, known)) return;
  if (count < head.size()) refuse("is not a log of the league: it ends in its header");
  std::uint32_t version = 0;
  for (std::size_t i = kLogMagic.size(); i < head.size(); ++i)
    version = version << 8U | std::to_integer<std::uint32_t>(head[i]);
  if (version == 0) refuse(kVersion0);
  refuse(
      fmt::format("log version {} is unknown; expected {}", static_cast<std::int32_t>(version), kLogVersion));
}

bool MatchLogReader::stop(const std::string& why) {
  is_at_end_ = true;
  problem_ = fmt::format("{}: {}", name_, why);
  return false;
}

/// Skips bytes of the file. False if it ends before.
bool MatchLogReader::skip(std::uint64_t bytes) {
  std::array<std::byte, 4096> skipped{};
  while (bytes > 0) {
    const std::size_t count =
        file_.read(std::span(skipped).first(std::min<std::uint64_t>(bytes, skipped.size())));
    if (count == 0) return false;
    bytes -= count;
  }
  return true;
}

/// Reads the next message's header unless it was already read. False at the end, or after a problem. Skips
/// indices and the beginnings of further logs.
bool MatchLogReader::read_header() {
  if (header_) return true;
  if (is_at_end_) return false;
  std::uint64_t offset = 0;
  std::array<std::byte, kMessageHeaderBytes> bytes{};
  std::size_t count = 0;
  MessageHeader header;
  constexpr int kMostWithoutMessages = 8;  // a bomb of empty logs must not keep this thread
  for (int i = 0;; ++i) {
    offset = file_.offset();
    count = file_.read(bytes);
    header = read_message_header(bytes);
    const bool is_index = header.type == LoggedMessage::kIndex;
    if (count < bytes.size() || (!is_index && bytes != log_header())) break;
    if (i == kMostWithoutMessages) return stop("has many logs without messages");
    if (!is_index) continue;
    // An index has 8 bytes for each message, and a message at least 16.
    const auto index_bytes = static_cast<std::uint64_t>(std::max(0, header.size));
    if (header.size < 0 || index_bytes > offset / 2 + kMaxMessageBytes)
      return stop(fmt::format("the index after message {} is larger than its log", messages_));
    if (!skip(index_bytes)) return stop(fmt::format("the index after message {} is cut off", messages_));
  }
  if (count < bytes.size()) {
    is_at_end_ = true;
    if (count == 0 && file_.problem().empty()) return false;
    return stop(file_.problem().empty() || file_.problem() == PackedFile::kCutOff
                    ? fmt::format("message {} is cut off", messages_ + 1)
                    : fmt::format("{} after message {}", file_.problem(), messages_));
  }
  if (header.size < 0 || header.size > kMaxMessageBytes)
    return stop(fmt::format("message {} is larger than any packet", messages_ + 1));
  if (!is_log_time(header.time_ns)) return stop(fmt::format("message {} has an invalid time", messages_ + 1));
  header_ = header;
  message_offset_ = offset;
  const UnpackPlace place = file_.place();
  // In an unpacked file, reading can start at each message.
  place_ = file_.is_packed() ? place : UnpackPlace{offset, offset};
  return true;
}

bool MatchLogReader::next(LoggedMessage& out) {
  if (!read_header()) return false;
  out.time_ns = header_->time_ns;
  out.type = header_->type;
  out.bytes.resize(static_cast<std::size_t>(header_->size));
  header_.reset();
  if (file_.read(out.bytes) < out.bytes.size()) {
    return stop(file_.problem().empty() || file_.problem() == PackedFile::kCutOff
                    ? fmt::format("message {} is cut off", messages_ + 1)
                    : fmt::format("{} after message {}", file_.problem(), messages_));
  }
  ++messages_;
  return true;
}

void MatchLogReader::go_to_begin() {
  header_.reset();
  is_at_end_ = false;
  problem_.clear();
  messages_ = 0;
  if (!file_.is_packed()) return file_.go_to(kFirstMessage);
  file_.go_to(UnpackPlace{});
  std::array<std::byte, kLogHeaderBytes> head{};
  file_.read(head);
}

void MatchLogReader::go_to(std::int64_t time_ns, const MatchLogIndex& index) {
  go_to_begin();
  // The last point with only earlier messages before it.
  const auto behind = std::ranges::partition_point(
      index.points, [&](const MatchLogPoint& point) { return point.all_before_ns < time_ns; });
  if (behind != index.points.begin()) {
    const MatchLogPoint& point = *(behind - 1);
    file_.go_to(point.place);
    messages_ = point.messages;
  }
  skip_to(time_ns, kMaxUnpackedBytes, {});
}

void MatchLogReader::go_to(const UnpackPlace& message) {
  go_to_begin();
  file_.go_to(message);
}

void MatchLogReader::go_to(const MemberPlace& place, std::uint64_t next_offset) {
  go_to_begin();
  file_.go_to(place);
  std::array<std::byte, 4096> passed{};
  while (file_.offset() < next_offset) {
    const std::uint64_t left = next_offset - file_.offset();
    if (file_.read(std::span(passed).first(std::min<std::uint64_t>(left, passed.size()))) == 0) return;
  }
}

bool MatchLogReader::skip_to(std::int64_t time_ns, std::uint64_t max_bytes, const std::stop_token& stop) {
  const std::uint64_t begin = file_.offset();
  LoggedMessage skipped;
  while (read_header() && header_->time_ns < time_ns) {
    if (stop.stop_requested() || file_.offset() - begin > max_bytes) return false;
    if (!next(skipped)) break;
  }
  return true;
}

}  // namespace sslv
