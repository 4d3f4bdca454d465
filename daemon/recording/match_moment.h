// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "recording/match_log_index.h"
#include "recording/match_log_reader.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>

namespace sslv {

/// Robots and balls of a packet, as Detections in docs/openapi.json; none if it is not a detection packet.
std::optional<Json> detections_json_of(std::span<const std::byte> packet);

/// Returns the state of the game at any moment of a match log, in bounded time. Logs that other programs
/// packed have few places at which reading can start; for these logs, a low-priority thread finds more
/// places, once. Use from one thread at a time.
class MatchMoments {
 public:
  /// Limit of unpacked bytes to read for one moment.
  static constexpr std::uint64_t kMaxBytes = std::uint64_t{128} << 20U;

  /// `index`: of this log; `max_bytes`: for tests. Throws StorageError.
  MatchMoments(const std::filesystem::path& log, std::shared_ptr<const MatchLogIndex> index,
               std::uint64_t max_bytes = kMaxBytes);
  ~MatchMoments();

  /// MatchMoment of docs/openapi.json: the newest message of each source, if it is at most 0.2 s old (game
  /// controller: 2 s). `at_s`: s since the log's first message, clamped to the log. None: the thread that
  /// finds places has not reached that time yet. Throws StorageError on a stop request, and if reading to
  /// that time would exceed the limit of bytes.
  std::optional<Json> at(double at_s, const std::stop_token& stop = {});
  /// Waits until the thread that finds places has ended.
  void wait();

 private:
  class Places;
  Json field(const std::stop_token& stop);
  bool go_to(std::int64_t time_ns, const std::stop_token& stop);

  const std::shared_ptr<const MatchLogIndex> index_;
  const std::uint64_t max_bytes_;
  MatchLogReader reader_;
  std::optional<Json> field_;       // null: no geometry at the log's beginning
  std::unique_ptr<Places> places_;  // null: the index has enough points
};

}  // namespace sslv
