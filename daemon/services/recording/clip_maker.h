// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/snapshot.h"
#include "clips/clip.h"
#include "clips/clip_writer.h"
#include "config/config.h"
#include "services/event.h"
#include "services/recording/clip_camera.h"
#include "services/recording/last_seconds.h"
#include "services/recording/recording_files.h"

#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

namespace sslv {

/// A request to write a clip.
struct ClipOrder {
  std::string name;       // part of the file's name
  std::string kind;       // ClipAbout::kind
  std::string why;        // human-readable reason
  std::string who{};      // the client's address; empty: no client
  double begin_s, end_s;  // on the steady clock
  /// The next run of the service can write this clip: if the service stops now, the unfinished file is
  /// removed.
  bool can_wait = false;
};

/// Progress of a clip.
struct ClipProgress {
  std::string file{};
  std::string why{};
  std::uint64_t bytes = 0, frames = 0, missing = 0;
  std::string problem{};  // why the clip is missing or incomplete
};

/// Writes one clip from the ring buffers of running cameras, or from the ring buffers that a crash left in
/// memory. For one thread of low priority; never blocks cameras.
class ClipMaker {
 public:
  struct Hooks {
    /// Called at the beginning, after each frame and at the end.
    std::function<void(const ClipProgress&)> tell;
    /// Called while make() waits for frames.
    std::function<void()> wait;
    /// Returns the events during the clip; called at the clip's end. `newest_s`: capture time of the clip's
    /// newest frame, Unix.
    std::function<std::vector<ClipEvent>(double newest_s)> happened;
  };

  /// `config`, `files` and `events` must outlive this. `events` receives an event for each removed recording
  /// and for the written clip. `max_blocks`: for tests.
  ClipMaker(const Snapshot<Config>& config, RecordingFiles& files, EventQueue& events,
            std::uint64_t max_blocks = kMaxClipBlocks)
      : config_(config), files_(files), events_(events), max_blocks_(max_blocks) {}

  /// Returns when the clip's time is over and its frames are written, when the clip is full, or when stopped.
  /// Removes a clip without frames. Releases all held frames.
  ClipProgress make(const ClipOrder& order, std::vector<LastSeconds::Ring> rings, int every_nth,
                    const Hooks& hooks, const std::stop_token& stop);

 private:
  struct Work;
  void write(Work& work, const std::stop_token& stop);
  static bool write_next(Work& work);
  void finish(Work& work);

  const Snapshot<Config>& config_;
  RecordingFiles& files_;
  EventQueue& events_;
  const std::uint64_t max_blocks_;
};

}  // namespace sslv
