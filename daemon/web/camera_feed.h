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

/// Returns the JPEG at the end of a preview message, after the header.
std::span<const char> jpeg_in(const std::string& preview_message);

/// Sends one camera's images and detections to the viewers on its own thread: fetches a view when a viewer is
/// due, encodes it once per requested image, size and quality, and passes it to the viewers. Sleeps while no
/// viewer is due, so without viewers nothing is fetched or encoded. All members are thread-safe.
class CameraFeed {
 public:
  using ViewerId = std::uint64_t;
  using Message = std::shared_ptr<const std::string>;
  /// Called from the feed's thread; must not block. One call may still be in progress after the viewer was
  /// removed.
  using Sink = std::function<void(const Message&)>;

  /// `views` and the counter `jpegs_encoded` must outlive the feed. Throws std::system_error if its thread
  /// cannot start.
  CameraFeed(ViewSource& views, std::uint32_t camera_id, std::atomic<std::uint64_t>& jpegs_encoded);

  /// Asks the thread to end; the destructor waits for it.
  void request_stop() { thread_.request_stop(); }

  /// Sends binary preview messages (docs/api.md), each only after acknowledge() of the previous one. Calling
  /// it again changes the wish.
  void start_preview(ViewerId viewer, const PreviewWish& wish, Sink sink);
  void acknowledge(ViewerId viewer, std::uint32_t frame_number);
  /// Acknowledges the frame in flight, regardless of its number.
  void acknowledge(ViewerId viewer);
  void stop_preview(ViewerId viewer);

  /// Sends detection messages, at most 30 a second. Calling it again does nothing.
  void start_detections(ViewerId viewer, Sink sink);
  void stop_detections(ViewerId viewer);

 private:
  using Clock = std::chrono::steady_clock;
  struct Watcher {
    ViewerId viewer;
    std::optional<PreviewWish> wish;  // none: the viewer wants detections
    Sink sink;
    Clock::duration interval;
    Clock::time_point due;                     // no message before this time
    std::uint64_t seen_version = 0;            // version of the view sent last
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
  std::optional<Clock::time_point> next_due() const;  // none: no viewer may get a message
  std::uint64_t oldest_version_seen() const;          // among the viewers that are due
  std::vector<Delivery> take_due(const View& view);

  ViewSource& views_;
  const std::uint32_t camera_id_;
  std::atomic<std::uint64_t>& jpegs_encoded_;

  std::mutex mutex_;  // guards watchers_
  std::condition_variable_any changed_;
  std::vector<Watcher> watchers_;

  std::jthread thread_;  // last: stops before the members it uses are destroyed
};

}  // namespace sslv
