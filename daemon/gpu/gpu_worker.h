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

/// Labels images on a GPU for a camera's thread, which never waits longer than it says. Everything that a
/// driver may block in (opening, shaders, images, closing) happens in a thread of the worker's own. That
/// thread works on copies only, so that one that hangs touches nothing that is gone.
class GpuWorker {
 public:
  using Clock = std::chrono::steady_clock;

  struct Limits {
    /// A GPU that answers later than this is closed and opened again.
    std::chrono::nanoseconds hangs_after = std::chrono::seconds(1);
    /// Between a loss, or no GPU, and the next try: doubled with each try, until one was `sound_after` well.
    std::chrono::nanoseconds shortest_wait = std::chrono::seconds(1);
    std::chrono::nanoseconds longest_wait = std::chrono::minutes(5);
    std::chrono::nanoseconds sound_after = std::chrono::minutes(1);
    /// How long the end of the worker waits for its thread before it leaves it behind.
    std::chrono::nanoseconds longest_end = std::chrono::seconds(2);
  };

  /// What the thread gets ready for: memory of that size, a shader for that format.
  struct Work {
    PixelFormat format = PixelFormat::kMono8;
    int width = 0, height = 0;  // of the image, in pixels
    int table_bits = 0;
    bool operator==(const Work&) const = default;
  };
  static Work work_for(const Lut& lut, const ImageView& image);

  struct Status {
    enum class Kind : std::uint8_t {
      kOpening,  // for the first time
      kOpen,     // and ready for what it was asked for
      kNoGpu,    // looked for again after `wait`
      kLost,     // likewise
      kUnfit,    // there is one, but not for the work that it was last asked for
    };
    Kind kind = Kind::kOpening;
    std::string name;  // of the GPU
    bool is_software = false;
    std::string problem;              // empty while nothing is wrong
    std::chrono::nanoseconds wait{};  // until the next try
    int number = 0;                   // of changes before it
  };

  /// Its thread has the priority and processors of the caller. Throws std::system_error when the system gives
  /// none.
  explicit GpuWorker(OpenDevice open) : GpuWorker(std::move(open), Limits()) {}
  GpuWorker(OpenDevice open, const Limits& limits);
  /// Not for a thread that must not wait.
  ~GpuWorker();
  GpuWorker(const GpuWorker&) = delete;
  GpuWorker& operator=(const GpuWorker&) = delete;

  // All of these are for one thread, the camera's. None allocates, none takes a lock.

  /// Whether it labels such images at once. If not, it gets ready for them as soon as it can.
  bool takes(const Work& work) noexcept;

  enum class Answer : std::uint8_t {
    kLabels,
    kNone,  // the GPU has failed
    kLate,  // not by then; what still comes of it is thrown away
  };
  /// Only after takes() said so for work_for(lut, image). Labels all of the image, without a mask, into
  /// memory that it swaps with what `labels` had.
  Answer label(const Lut& lut, const ImageView& image, LabelImage& labels, Clock::time_point until) noexcept;

  /// What the newest labels took of a processor, apart from what they took of the caller's.
  std::chrono::nanoseconds cpu_time() const { return cpu_time_; }
  /// An image was given up for being late so long ago, and the GPU still has not answered.
  bool hangs() const noexcept;

  Handover<Status>::Use status() noexcept;

 private:
  struct Shared;

  const std::shared_ptr<Shared> shared_;  // with the thread, which may have to be left behind
  Clock::time_point late_since_{};
  std::chrono::nanoseconds cpu_time_{};
  std::thread thread_;
};

}  // namespace sslv
