// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"

#include <array>
#include <tuple>

namespace sslv {

/// The memory of the cameras' newest images: the ring buffers from which clips are made.
struct LastSecondsSettings {
  enum class Images { kWhole, kEveryNth };

  int memory_mb = 512;
  Images images = Images::kWhole;
  int every_nth = 4;

  /// Every n-th image is kept; returns n.
  int kept_every() const { return images == Images::kEveryNth ? every_nth : 1; }

  static constexpr auto fields() {
    using L = LastSecondsSettings;
    return std::tuple{
        number("memory_mb", &L::memory_mb, 0, 1'000'000, "MB",
               "memory for the newest images of all cameras, from which clips are made; 0: none are kept"),
        choice("images", &L::images,
               std::array{Choice<Images>{"whole", Images::kWhole},
                          Choice<Images>{"every_nth", Images::kEveryNth}},
               "which: every one, or only every n-th"),
        number("every_nth", &L::every_nth, 2, 1000, "", "n, for every n-th image"),
    };
  }
};

/// The length of clips, and the events that save one automatically.
struct ClipSettings {
  double seconds = 10, seconds_after = 2;
  bool on_alert = false, on_goal = false, on_command = false, on_crash = true;

  static constexpr auto fields() {
    using C = ClipSettings;
    return std::tuple{
        number("seconds", &C::seconds, 0.5, 600.0, "s", "how far back a clip reaches, if the memory does"),
        number("seconds_after", &C::seconds_after, 0.0, 600.0, "s",
               "how long it goes on after what it was made for"),
        flag("on_alert", &C::on_alert, "make one when an alert comes, at most one a minute for each kind"),
        flag("on_goal", &C::on_goal, "make one when the game controller counts a goal"),
        flag("on_command", &C::on_command, "make one at each command of the game controller"),
        flag("on_crash", &C::on_crash,
             "make one when the service starts again after a crash, of all that was in memory then"),
    };
  }
};

/// Settings for match logs, disk space, the ring buffers and clips.
struct RecordingSettings {
  enum class MatchLogs { kByGameController, kByHand };

  MatchLogs match_logs = MatchLogs::kByGameController;
  int quota_mb = 10'000;
  int keep_free_mb = 1'000;
  LastSecondsSettings last_seconds;
  ClipSettings clips;

  static constexpr auto fields() {
    using R = RecordingSettings;
    return std::tuple{
        choice("match_logs", &R::match_logs,
               std::array{Choice<MatchLogs>{"by_game_controller", MatchLogs::kByGameController},
                          Choice<MatchLogs>{"by_hand", MatchLogs::kByHand}},
               "whether the game controller starts and ends match logs, or somebody does with a button"),
        number("quota_mb", &R::quota_mb, 10, 10'000'000, "MB",
               "recordings may take so much of the disk; the oldest go first, but not those that are pinned, "
               "nor the newest match log, which may exceed it"),
        number("keep_free_mb", &R::keep_free_mb, 0, 10'000'000, "MB",
               "so much of the disk stays free; recording stops before"),
        group("last_seconds", &R::last_seconds, "the cameras' newest images, in memory"),
        group("clips", &R::clips, "files with the last seconds of all cameras"),
    };
  }
};

}  // namespace sslv
