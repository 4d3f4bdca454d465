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

/// The robots and balls of a detection packet as docs/openapi.json's Detections has them; none: it is none.
std::optional<Json> detections_json_of(std::span<const std::byte> packet);

/// Looks at a match log anywhere: what was known at a moment. No moment takes long: of a log in which reading
/// may begin at few places, as other programs pack them, a thread of low priority finds more, once. Used by
/// one thread at a time.
class MatchMoments {
 public:
  /// Unpacked bytes that are read for one moment.
  static constexpr std::uint64_t kMaxBytes = std::uint64_t{128} << 20U;

  /// `index`: of this log; `max_bytes`: for tests. Throws StorageError.
  MatchMoments(const std::filesystem::path& log, std::shared_ptr<const MatchLogIndex> index,
               std::uint64_t max_bytes = kMaxBytes);
  ~MatchMoments();

  /// docs/openapi.json's MatchMoment: the newest of each source that is no older than .2 s, of the game
  /// controller 2 s. `at_s`: since the log's first message, kept within the log. None: the log is still being
  /// read up to that time. Throws StorageError once it is told to stop, and for a time that cannot be
  /// reached.
  std::optional<Json> at(double at_s, const std::stop_token& stop = {});
  /// Waits until all places are found.
  void wait();

 private:
  class Places;
  Json field(const std::stop_token& stop);
  bool go_to(std::int64_t time_ns, const std::stop_token& stop);

  const std::shared_ptr<const MatchLogIndex> index_;
  const std::uint64_t max_bytes_;
  MatchLogReader reader_;
  std::optional<Json> field_;       // null: the log's beginning has none
  std::unique_ptr<Places> places_;  // null: the index has enough
};

}  // namespace sslv
