// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"

#include <array>
#include <tuple>

namespace sslv {

/// Which matches are recorded, and how much room recordings may take.
struct RecordingSettings {
  enum class MatchLogs { kByGameController, kByHand };

  MatchLogs match_logs = MatchLogs::kByGameController;
  int quota_mb = 10'000;
  int keep_free_mb = 1'000;

  static constexpr auto fields() {
    using R = RecordingSettings;
    return std::tuple{
        choice("match_logs", &R::match_logs,
               std::array{Choice<MatchLogs>{"by_game_controller", MatchLogs::kByGameController},
                          Choice<MatchLogs>{"by_hand", MatchLogs::kByHand}},
               "whether the game controller starts and ends match logs, or somebody does with a button"),
        number("quota_mb", &R::quota_mb, 10, 10'000'000, "MB",
               "recordings may take so much of the disk; the oldest go first, but not those that are pinned"),
        number("keep_free_mb", &R::keep_free_mb, 0, 10'000'000, "MB",
               "so much of the disk stays free; recording stops before"),
    };
  }
};

}  // namespace sslv
