// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "recording/match_log_index.h"
#include "recording/match_log_reader.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

namespace sslv {

/// The robots and balls of a detection packet as docs/openapi.json's Detections has them; none: it is none.
std::optional<Json> detections_json_of(std::span<const std::byte> packet);

/// Looks at a match log anywhere: what was known at a moment. Used by one thread at a time.
class MatchMoments {
 public:
  /// `index`: of this log. Throws StorageError.
  MatchMoments(const std::filesystem::path& log, std::shared_ptr<const MatchLogIndex> index);

  /// docs/openapi.json's MatchMoment: the newest of each source that is no older than .2 s, of the game
  /// controller 2 s. `at_s`: since the log's first message, kept within the log. Throws StorageError once it
  /// is told to stop.
  Json at(double at_s, const std::stop_token& stop = {});

 private:
  Json field(const std::stop_token& stop);

  const std::shared_ptr<const MatchLogIndex> index_;
  MatchLogReader reader_;
  std::optional<Json> field_;  // null: the log's beginning has none
};

}  // namespace sslv
