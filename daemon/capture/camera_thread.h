// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"
#include "capture/source.h"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace sslv {

struct ThreadSettings {
  int realtime_priority = 0;
  int cpu = -1;
  static constexpr auto fields() {
    return std::tuple{
        number("realtime_priority", &ThreadSettings::realtime_priority, 0, 99, "",
               "SCHED_FIFO priority of the camera's threads; 0: not real-time"),
        number("cpu", &ThreadSettings::cpu, -1, 1023, "", "the one processor they run on; -1: any"),
    };
  }
};

enum class CameraState {
  kOpening,  // has not been opened yet
  kRunning,
  kLost,   // closed, or cannot be opened; retried with back-off
  kEnded,  // a recording has ended
};

/// "opening", "running", "lost", "ended".
std::string_view name_of(CameraState state);

struct CameraHealth {
  CameraState state = CameraState::kOpening;
  std::string error{};           // why the camera is lost, in one line; empty if it is not lost
  std::uint64_t frames = 0;      // delivered images
  std::uint64_t incomplete = 0;  // damaged images
  std::uint64_t dropped = 0;     // images never delivered, because they were not taken in time
  std::optional<PacketCounts> packets{};
  std::uint64_t reconnects = 0;  // reopenings after a loss
  double fps = 0;                // delivered images per second, over the last second
  int width = 0, height = 0;     // size of the last image; 0 before the first image
  PixelFormat format = PixelFormat::kMono8;
  std::int64_t progress_ns = 0;         // steady_ns() of the thread's last iteration; old if the thread hangs
  CaptureTimes times{};                 // times of the last image
  std::vector<std::string> warnings{};  // problems of the last opening, see Source::warnings()
};

/// Counters that outlive the thread that increments them; they never decrease.
struct CaptureTotals {
  std::atomic<std::uint64_t> incomplete{0}, dropped{0}, reconnects{0};  // see CameraHealth
};

/// Delays of a camera's thread.
struct CameraDelays {
  /// Pauses between attempts to open the camera, doubling from first to longest. The duration of a failed
  /// attempt is subtracted from the pause, but the pause is never shorter than `first`.
  std::chrono::milliseconds first{250}, longest{1000};
  /// Maximum time for which stop() waits for a camera that does not answer.
  std::chrono::milliseconds stop{1000};
};

/// Keeps one camera open on its own thread and delivers its images. A camera that fails, dies or throws is
/// closed and reopened; closing may block on dead hardware, so each dead source is closed on a separate
/// thread. Repeated problems are logged once a second with their count. The image loop takes no lock, so
/// health() delays no image.
class CameraThread {
 public:
  using Open = std::function<std::unique_ptr<Source>()>;
  using OnImage = std::function<void(CapturedImage&&)>;
  using OnIdle = std::function<bool()>;

  /// The thread waits for start(). `name` begins log messages ("camera 0"). `open` creates a source or throws
  /// CaptureError; it must own all it uses, because stop() abandons a blocked call. `on_image` must not
  /// throw. `on_idle` is called on the same thread while no image arrives, and before a camera is closed, to
  /// release its buffers; it returns whether some buffers are still held, and is then called again soon.
  /// Neither callback is called after stop(). Throws std::system_error if no thread can be created.
  CameraThread(std::string name, const ThreadSettings& settings, Open open, OnImage on_image,
               CameraDelays delays = {},
               std::shared_ptr<CaptureTotals> totals = std::make_shared<CaptureTotals>(),
               OnIdle on_idle = {});
  /// Calls stop().
  ~CameraThread();
  CameraThread(const CameraThread&) = delete;
  CameraThread& operator=(const CameraThread&) = delete;

  /// Starts opening the camera. May be called once. The new thread first stops `predecessor` and waits for
  /// it, so that the camera is never open twice and only one thread at a time runs on_image. Does not block
  /// the caller.
  void start(std::unique_ptr<CameraThread> predecessor = nullptr) noexcept;

  /// Requests the stop without waiting for it, so that several hanging cameras can stop in parallel.
  void ask_to_stop();
  /// Closes the camera and ends the thread, within one frame's time if the camera answers. Waits up to
  /// CameraDelays::stop for a camera that does not answer (opening or closing dead hardware takes seconds),
  /// and then lets it finish in the background. Waits without limit for a running on_image, including a
  /// predecessor's.
  void stop();
  /// Calls stop() if that would not block; ask_to_stop() must have been called before. Returns false, without
  /// stopping, while on_image is running or while the camera may still answer in time.
  bool try_stop();

  /// Retries a lost camera now, and then with pauses that begin at CameraDelays::first again; has no effect
  /// on a camera that is not lost. Does not wait for the result. Returns the state at the time of the call.
  CameraState try_now();

  /// From any thread; also valid before start() (kOpening).
  CameraHealth health() const;
  /// The open camera's controls; null if the camera is not open or has no controls.
  std::shared_ptr<Controls> controls() const;

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
  std::thread thread_;
};

}  // namespace sslv
