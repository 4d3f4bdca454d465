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

/// A clip that is to be written.
struct ClipOrder {
  std::string name;       // part of the file's name
  std::string kind;       // ClipAbout::kind
  std::string why;        // for people
  std::string who{};      // the client's address; empty: nobody
  double begin_s, end_s;  // on the steady clock
  /// The next start of the service can write it as well: if it stops now, nothing is left of it.
  bool can_wait = false;
};

/// How a clip stands.
struct ClipProgress {
  std::string file{};
  std::string why{};
  std::uint64_t bytes = 0, frames = 0, missing = 0;
  std::string problem{};  // why it could not be written, or not to its end
};

/// Writes one clip of what rings hold: of cameras that go on filling them, or of memory that a crash left.
/// For one thread of low priority; cameras wait for nothing.
class ClipMaker {
 public:
  struct Hooks {
    /// Called often while it is written.
    std::function<void(const ClipProgress&)> tell;
    /// Called while frames are waited for.
    std::function<void()> wait;
    /// What happened in the clip's time, asked for at its end. `newest_s`: of its frames, Unix time.
    std::function<std::vector<ClipEvent>(double newest_s)> happened;
  };

  /// `config` and `files` must outlive this, `events` gets what was removed to make room, and the clip.
  /// `max_blocks`: for tests.
  ClipMaker(const Snapshot<Config>& config, RecordingFiles& files, EventQueue& events,
            std::uint64_t max_blocks = kMaxClipBlocks)
      : config_(config), files_(files), events_(events), max_blocks_(max_blocks) {}

  /// Returns when the clip's time is over and its frames are written, when it has as many as it can have, or
  /// when it is told to stop. Nothing is left of a clip without frames. Lets all frames go.
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
