// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/kept_files.h"
#include "clips/clip_writer.h"
#include "clips/left_ring.h"
#include "services/recording/clip_camera.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace sslv {

/// What the cameras saw last before the service crashed: all memory that the service manager kept of an
/// earlier run. In the end it is given back, unless it was put back. Used by one thread.
class LeftRings {
 public:
  explicit LeftRings(std::vector<KeptFile> files);
  ~LeftRings();
  LeftRings(const LeftRings&) = delete;
  LeftRings& operator=(const LeftRings&) = delete;

  /// The next start of the service finds all of it again.
  void put_back() noexcept;

  /// A service crashed while it read what the one before had left.
  bool was_read() const { return was_read_; }
  /// Of all cameras, as far as it is known before their frames are looked at; frames is 0: there is nothing.
  const LeftRing::Extent& extent() const { return extent_; }

  /// Writes the frame that arrived first of those that were not written yet, or leaves it out where the clip
  /// cannot begin with it. False: there was none. `every_nth`: which frames were kept on purpose. Throws
  /// StorageError.
  bool write_next(ClipWriter& writer, int every_nth);

  std::uint64_t frames() const { return frames_; }  // that were written
  std::uint64_t missing() const;                    // that the clip lacks
  double newest_s() const { return newest_s_; }     // when the newest of them was captured, Unix time

 private:
  struct Camera {
    int id = 0;
    std::unique_ptr<LeftRing> ring;
    std::unique_ptr<ClipCamera> camera{};  // from its first frame on
  };

  std::vector<std::string> names_;  // for the service manager
  std::vector<Camera> cameras_;
  LeftRing::Extent extent_;
  std::uint64_t frames_ = 0;
  double newest_s_ = 0;
  bool was_read_ = false;
};

}  // namespace sslv
