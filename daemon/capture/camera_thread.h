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
  kOpening,  // has not been open yet
  kRunning,
  kLost,   // closed, or cannot be opened; tried again with back-off
  kEnded,  // a recording has come to its end
};

/// "opening", "running", "lost", "ended".
std::string_view name_of(CameraState state);

struct CameraHealth {
  CameraState state = CameraState::kOpening;
  std::string error{};           // why it is lost, one line; empty otherwise
  std::uint64_t frames = 0;      // handed over
  std::uint64_t incomplete = 0;  // came damaged
  std::uint64_t dropped = 0;     // were never handed over, because nobody took them in time
  std::optional<PacketCounts> packets{};
  std::uint64_t reconnects = 0;  // times it was opened again after a loss
  double fps = 0;                // images handed over a second, over the last second
  int width = 0, height = 0;     // of the last image; 0 before the first
  PixelFormat format = PixelFormat::kMono8;
  std::int64_t progress_ns = 0;         // steady_ns() of the thread's last turn; stands still when it hangs
  CaptureTimes times{};                 // of the last image
  std::vector<std::string> warnings{};  // of the last opening, see Source
};

/// Counts that outlive the thread, which adds to them; they never go back.
struct CaptureTotals {
  std::atomic<std::uint64_t> incomplete{0}, dropped{0}, reconnects{0};  // as in CameraHealth
};

/// How long a camera's thread waits.
struct CameraDelays {
  /// Between attempts to open the camera, doubling from the first to the longest; the pause between two is
  /// shorter by what the first of them took, and never below the first.
  std::chrono::milliseconds first{250}, longest{1000};
  /// For a camera that is to stop and does not answer.
  std::chrono::milliseconds stop{1000};
};

/// Keeps one camera open on a thread of its own and hands over its images. A camera that fails, dies or
/// throws is closed and reopened; closing may block on dead hardware, so each dead source is closed on a
/// thread of its own and delays nothing. Repeated problems are logged once a second, counted. From image to
/// image the thread takes no lock: a request for its health delays no image.
class CameraThread {
 public:
  using Open = std::function<std::unique_ptr<Source>()>;
  using OnImage = std::function<void(CapturedImage&&)>;
  using OnIdle = std::function<bool()>;

  /// The thread is there and does nothing before start(). `name` begins log messages ("camera 0"). `open`
  /// makes a source or throws CaptureError; it must own all it uses, because a call that blocks is left
  /// behind by stop(). `on_image` must not throw. `on_idle` is called by the same thread while no image
  /// comes, and before a camera is closed: the time to give its buffers back. It says whether some are still
  /// out; then it is called again soon. Neither is called after stop(). Throws std::system_error when there
  /// is no thread to be had.
  CameraThread(std::string name, const ThreadSettings& settings, Open open, OnImage on_image,
               CameraDelays delays = {},
               std::shared_ptr<CaptureTotals> totals = std::make_shared<CaptureTotals>(),
               OnIdle on_idle = {});
  /// Stops.
  ~CameraThread();
  CameraThread(const CameraThread&) = delete;
  CameraThread& operator=(const CameraThread&) = delete;

  /// Begins to open the camera, once. The new thread itself stops `predecessor` and waits for that first, so
  /// that one camera is not open twice and one thread at a time is in on_image. The caller does not wait.
  void start(std::unique_ptr<CameraThread> predecessor = nullptr) noexcept;

  /// Begins what stop() does and does not wait for it: several cameras that hang are waited for at once.
  void ask_to_stop();
  /// Closes the camera and ends the thread: within a frame's time for a camera that answers. One that does
  /// not (opening or closing dead hardware takes seconds) is waited for as long as its delays say and then
  /// left to finish by itself. Waits for a running on_image however long it takes, also for that of a
  /// predecessor.
  void stop();
  /// stop() if that need not wait, once it was asked to stop: false while on_image is at work, or the camera
  /// may still answer in time.
  bool try_stop();

  /// A camera that is lost is tried again now, and after that with short pauses as at first; any other goes
  /// on as it is. Does not wait for what comes of it. Says what the camera was when it was asked.
  CameraState try_now();

  /// From any thread. kOpening before start(), too.
  CameraHealth health() const;
  /// Those of the open camera; none while it is not open, or has none.
  std::shared_ptr<Controls> controls() const;

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
  std::thread thread_;
};

}  // namespace sslv
