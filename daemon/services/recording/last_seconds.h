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

/// Ring buffers with the newest images (the last seconds) of all cameras. Their memory is divided by data
/// rate, so that all cover the same time. look() and rings() are for the clip thread only; all other
/// functions are for any thread.
class LastSeconds {
 public:
  /// Prefix of the names under which the service manager keeps the memory, also after a crash.
  static constexpr const char* kKeptName = "last_seconds-";

  /// `cameras` must outlive this.
  explicit LastSeconds(Cameras& cameras) : cameras_(cameras) {}

  /// Call it regularly, but not while a ring is read. Divides the memory again when cameras, their highest
  /// data rates or settings have changed; rings whose size changes lose their images. `now_s`: on the steady
  /// clock.
  void look(const RecordingSettings& recording, double now_s = steady_s(), const std::stop_token& stop = {});

  struct Ring {
    int camera_id = 0;
    std::shared_ptr<ImageRing> ring;
    double bytes_per_s = 0;  // data rate into the ring; below the camera's if only every n-th image is kept
  };
  /// The rings of the cameras that have memory.
  std::vector<Ring> rings() const;

  /// The cameras' last images before a crash: all rings with frames that the service manager kept from an
  /// earlier run. The service manager releases a ring's memory when the ring is destroyed, unless put_back()
  /// was called.
  struct Left {
    std::vector<Ring> rings;
    bool was_read = false;  // the service crashed while it read an earlier crash's memory
  };
  static Left crash_rings(std::vector<KeptFile> files);

  struct CameraStatus {
    int id = 0;
    std::uint64_t frames = 0, dropped = 0, bytes = 0;  // dropped: frames, while a clip was written
    double seconds = 0;                                // from the oldest to the newest frame
  };
  struct Status {
    std::uint64_t wanted_bytes = 0, bytes = 0;
    LastSecondsSettings settings;
    bool is_off() const { return settings.memory_mb == 0; }
    std::vector<CameraStatus> cameras;
    std::string problem;  // why there is less memory than requested; empty: no problem
  };
  Status status() const;

 private:
  struct Known {
    RecordedCamera::Seen seen{};  // counts at seen_s
    double seen_s = 0;
    double last_bytes_per_s = 0;    // rate in the last interval with frames
    double bytes_per_s = 0;         // highest accepted rate, by which the memory is divided
    std::uint64_t rated_bytes = 0;  // image_bytes at that rate
    int uneven = 0;                 // intervals without an accepted rate
    std::uint64_t image_bytes = 0;  // mean size of an image in the last interval with frames
    bool is_kept() const { return image_bytes <= kMaxClipImageBytes; }
    std::shared_ptr<RecordedCamera> camera{};
    std::shared_ptr<ImageRing> ring{};
  };
  void measure(std::map<int, Known>& known, double now_s);
  void publish(const std::map<int, Known>& known);
  void share_out(std::map<int, Known>& known, std::uint64_t bytes, const std::stop_token& stop);
  void hand_over(const Known& known) const;

  Cameras& cameras_;
  double changed_s_ = 0;      // last change of the list of cameras, on the steady clock
  mutable std::mutex mutex_;  // guards the members below, which only look() changes; held briefly
  std::map<int, Known> known_;
  LastSecondsSettings settings_;
  std::uint64_t wanted_bytes_ = 0;  // 0: all that is needed is there
  std::string problem_;
};

}  // namespace sslv
