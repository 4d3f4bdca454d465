// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "web/view.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

namespace sslv {

/// The JPEG of a preview message, which begins with a header that says how long it is.
std::span<const char> jpeg_in(const std::string& preview_message);

/// One camera's images and detections on their way to the viewers. A thread of its own takes a view when a
/// viewer is due for one, encodes it once for every image, size and quality wanted, and hands it to the
/// viewers. It sleeps while nobody is due, so that without viewers nothing is encoded or even looked at. All
/// members may be called from any thread.
class CameraFeed {
 public:
  using ViewerId = std::uint64_t;
  using Message = std::shared_ptr<const std::string>;
  /// Called from the feed's thread; must not block. One call may still be under way after the viewer was
  /// removed.
  using Sink = std::function<void(const Message&)>;

  /// `views` and `jpegs_encoded`, which counts, must outlive the feed. Throws std::system_error when its
  /// thread cannot start.
  CameraFeed(ViewSource& views, std::uint32_t camera_id, std::atomic<std::uint64_t>& jpegs_encoded);

  /// Asks the thread to end; the destructor waits for it.
  void request_stop() { thread_.request_stop(); }

  /// Binary preview messages as docs/api.md has them: the next one only after acknowledge() of the one
  /// before. Again: changes the wish.
  void start_preview(ViewerId viewer, const PreviewWish& wish, Sink sink);
  void acknowledge(ViewerId viewer, std::uint32_t frame_number);
  /// Whichever frame is on its way.
  void acknowledge(ViewerId viewer);
  void stop_preview(ViewerId viewer);

  /// Detection messages, at most 30 a second. Again: nothing happens.
  void start_detections(ViewerId viewer, Sink sink);
  void stop_detections(ViewerId viewer);

 private:
  using Clock = std::chrono::steady_clock;
  struct Watcher {
    ViewerId viewer;
    std::optional<PreviewWish> wish;  // none: wants detections
    Sink sink;
    Clock::duration interval;
    Clock::time_point due;                     // no message before that
    std::uint64_t seen_version = 0;            // of the view it got last
    std::optional<std::uint32_t> in_flight{};  // number of a frame not acknowledged yet

    bool is_due(Clock::time_point now) const { return !in_flight && due <= now; }
  };
  struct Delivery {
    std::optional<PreviewWish> wish;
    Sink sink;
  };

  void run(const std::stop_token& stop);
  void put_off(std::uint32_t frame_number);
  void deliver(const View& view, const std::vector<Delivery>& deliveries, JpegEncoder& encoder,
               std::vector<std::uint8_t>& drawing);

  // With mutex_ held:
  Watcher* find(ViewerId viewer, bool preview);
  std::optional<Clock::time_point> next_due() const;  // none: nobody may get anything
  std::uint64_t oldest_version_seen() const;          // by those who are due
  std::vector<Delivery> take_due(const View& view);

  ViewSource& views_;
  const std::uint32_t camera_id_;
  std::atomic<std::uint64_t>& jpegs_encoded_;

  std::mutex mutex_;  // guards watchers_
  std::condition_variable_any changed_;
  std::vector<Watcher> watchers_;

  std::jthread thread_;  // last, so that it ends before what it uses
};

}  // namespace sslv
