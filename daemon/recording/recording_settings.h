// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"

#include <array>
#include <optional>
#include <tuple>

namespace sslv {

/// The memory of the cameras' newest images: the ring buffers from which clips are made.
struct LastSecondsSettings {
  enum class Images { kWhole, kEveryNth };

  std::optional<int> memory_mb;
  Images images = Images::kWhole;
  int every_nth = 4;

  /// Every n-th image is kept; returns n.
  int kept_every() const { return images == Images::kEveryNth ? every_nth : 1; }

  static constexpr auto fields() {
    using L = LastSecondsSettings;
    return std::tuple{
        number("memory_mb", &L::memory_mb, 0, 1'000'000, "MB",
               "memory for the newest images of all cameras, from which clips are made; null: enough for a "
               "clip, if "
               "the computer has it; 0: none are kept"),
        choice("images", &L::images,
               std::array{Choice<Images>{"whole", Images::kWhole},
                          Choice<Images>{"every_nth", Images::kEveryNth}},
               "images to keep: all, or every n-th"),
        number("every_nth", &L::every_nth, 2, 1000, "", "n, if every n-th image is kept"),
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
        number("seconds", &C::seconds, 0.5, 600.0, "s",
               "length of a clip before its trigger; limited by the memory"),
        number("seconds_after", &C::seconds_after, 0.0, 600.0, "s", "length of a clip after its trigger"),
        flag("on_alert", &C::on_alert, "save a clip on an alert, at most one a minute for each kind"),
        flag("on_goal", &C::on_goal, "save a clip when the game controller counts a goal"),
        flag("on_command", &C::on_command, "save a clip at each command of the game controller"),
        flag("on_crash", &C::on_crash,
             "save a clip when the service restarts after a crash, of all images that were in memory"),
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
               "started and ended by the game controller, or by hand with a button"),
        number("quota_mb", &R::quota_mb, 10, 10'000'000, "MB",
               "maximum disk space for recordings; the oldest are deleted first, except pinned ones and the "
               "newest match log, which may exceed the limit"),
        number("keep_free_mb", &R::keep_free_mb, 0, 10'000'000, "MB",
               "minimum free disk space; recording stops when it is reached"),
        group("last_seconds", &R::last_seconds, "the cameras' newest images, in memory"),
        group("clips", &R::clips, "files with the last seconds of all cameras"),
    };
  }
};

}  // namespace sslv
