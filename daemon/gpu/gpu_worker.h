// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/handover.h"
#include "gpu/threshold_device.h"
#include "image/image.h"
#include "vision/lut.h"
#include "vision/regions.h"

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>

namespace sslv {

/// Labels images on a GPU for a camera's thread, which never waits longer than its deadline. All calls in
/// which a driver may block (opening, shaders, images, closing) run in the worker's own thread. That thread
/// uses only copies, so a hanging thread accesses no freed memory.
class GpuWorker {
 public:
  using Clock = std::chrono::steady_clock;

  struct Limits {
    /// A GPU that takes longer to answer is closed and reopened.
    std::chrono::nanoseconds hangs_after = std::chrono::seconds(1);
    /// Wait before reopening after a loss or without a GPU. Doubled with each try, reset after the GPU has
    /// worked for `sound_after`.
    std::chrono::nanoseconds shortest_wait = std::chrono::seconds(1);
    std::chrono::nanoseconds longest_wait = std::chrono::minutes(5);
    std::chrono::nanoseconds sound_after = std::chrono::minutes(1);
    /// Maximum time for which the destructor waits for the thread before detaching it.
    std::chrono::nanoseconds longest_end = std::chrono::seconds(2);
  };

  /// The work to prepare for: buffers of this size, a shader for this format.
  struct Work {
    PixelFormat format = PixelFormat::kMono8;
    int width = 0, height = 0;  // size of the image in pixels
    int table_bits = 0;
    bool operator==(const Work&) const = default;
  };
  static Work work_for(const Lut& lut, const ImageView& image);

  struct Status {
    enum class Kind : std::uint8_t {
      kOpening,  // opening the GPU for the first time
      kOpen,     // open and ready for the requested work
      kNoGpu,    // no GPU; retried after `wait`
      kLost,     // GPU lost; reopened after `wait`
      kUnfit,    // the GPU cannot do the work requested last
    };
    Kind kind = Kind::kOpening;
    std::string name;  // name of the GPU
    bool is_software = false;
    std::string problem;              // empty without a problem
    std::chrono::nanoseconds wait{};  // time until the next try
    int number = 0;                   // number of status changes so far
  };

  /// The worker's thread inherits the caller's priority and processors. Throws std::system_error if the
  /// thread cannot be created.
  explicit GpuWorker(OpenDevice open) : GpuWorker(std::move(open), Limits()) {}
  GpuWorker(OpenDevice open, const Limits& limits);
  /// Waits up to `longest_end`.
  ~GpuWorker();
  GpuWorker(const GpuWorker&) = delete;
  GpuWorker& operator=(const GpuWorker&) = delete;

  // The following functions are for the camera's thread only. They allocate nothing and take no lock.

  /// Whether images of this kind can be labelled now. If not, starts preparing for them as soon as possible.
  bool takes(const Work& work) noexcept;

  enum class Answer : std::uint8_t {
    kLabels,
    kNone,  // the GPU has failed
    kLate,  // no labels by the deadline; a later result is discarded
  };
  /// Call only after takes(work_for(lut, image)) returned true. Labels the whole image without a mask, and
  /// swaps the result into `labels`.
  Answer label(const Lut& lut, const ImageView& image, LabelImage& labels, Clock::time_point until) noexcept;

  /// The worker thread's processor time for the newest labels, without the caller's.
  std::chrono::nanoseconds cpu_time() const { return cpu_time_; }
  /// Whether the GPU has not answered within `hangs_after` since an image was given up as late.
  bool hangs() const noexcept;

  Handover<Status>::Use status() noexcept;

 private:
  struct Shared;

  const std::shared_ptr<Shared> shared_;  // shared with the thread, which may have to be detached
  Clock::time_point late_since_{};
  std::chrono::nanoseconds cpu_time_{};
  std::thread thread_;
};

}  // namespace sslv
