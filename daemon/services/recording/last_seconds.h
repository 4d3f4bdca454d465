// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/clock.h"
#include "base/kept_files.h"
#include "clips/clip_format.h"
#include "clips/image_ring.h"
#include "recording/recording_settings.h"
#include "services/cameras/cameras.h"

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <vector>

namespace sslv {

/// The memory for the newest images of all cameras: each gets a part of it by what it sends, so that all
/// reach back as far. look() and rings() are for one thread, that of clips; the rest for any.
class LastSeconds {
 public:
  /// So begin the names under which the service manager keeps the memory, also when the service crashes.
  static constexpr const char* kKeptName = "last_seconds-";

  /// `cameras` must outlive this.
  explicit LastSeconds(Cameras& cameras) : cameras_(cameras) {}

  /// To be called now and then: shares the memory out again when cameras or settings have changed, which
  /// empties what changes. Not while a ring is read. `now_s`: on the steady clock.
  void look(const LastSecondsSettings& settings, double now_s = steady_s(), const std::stop_token& stop = {});

  struct Ring {
    int camera_id = 0;
    std::shared_ptr<ImageRing> ring;
    double bytes_per_s = 0;  // that its camera puts there, or less than that
  };
  /// Those that have memory.
  std::vector<Ring> rings() const;

  /// What the cameras saw last before the service crashed: all memory that the service manager kept of an
  /// earlier run, as far as there are frames in it. The manager forgets it with the ring, unless that was put
  /// back.
  struct Left {
    std::vector<Ring> rings;
    bool was_read = false;  // a service crashed while it read what the one before had left
  };
  static Left left_rings(std::vector<KeptFile> files);

  struct CameraStatus {
    int id = 0;
    std::uint64_t frames = 0, dropped = 0, bytes = 0;  // dropped: while a clip was written
    double seconds = 0;                                // from the oldest to the newest frame
  };
  struct Status {
    std::uint64_t wanted_bytes = 0, bytes = 0;
    LastSecondsSettings settings;
    std::vector<CameraStatus> cameras;
    std::string problem;  // why it is less than wanted; empty: it is not
  };
  Status status() const;

 private:
  struct Known {
    RecordedCamera::Seen seen{};  // at seen_s
    double seen_s = 0;
    double last_bytes_per_s = 0;    // in the second before that
    double bytes_per_s = 0;         // that counts
    int uneven = 0;                 // times without one that counts
    std::uint64_t image_bytes = 0;  // of one
    bool is_kept() const { return image_bytes <= kMaxClipImageBytes; }
    std::shared_ptr<RecordedCamera> camera{};
    std::shared_ptr<ImageRing> ring{};
  };
  void measure(std::map<int, Known>& known, double now_s);
  void publish(const std::map<int, Known>& known);
  void share_out(std::map<int, Known>& known, std::uint64_t bytes, const std::stop_token& stop);
  void hand_over(const Known& known) const;

  Cameras& cameras_;
  double changed_s_ = 0;      // when the list of cameras did, on the steady clock
  mutable std::mutex mutex_;  // guards the rest, which only look() changes; never held for long
  std::map<int, Known> known_;
  LastSecondsSettings settings_;
  std::string problem_;
};

}  // namespace sslv
