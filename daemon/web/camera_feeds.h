// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "web/camera_feed.h"

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>

namespace sslv {

/// The feeds of all cameras, each created on first use. Use from one thread at a time.
class CameraFeeds {
 public:
  /// `views` and `jpegs_encoded` must outlive this.
  CameraFeeds(ViewSource& views, std::atomic<std::uint64_t>& jpegs_encoded);
  ~CameraFeeds() { ask_to_stop(); }
  /// Starts stopping all feeds together without waiting; the destructor waits.
  void ask_to_stop();

  CameraFeed::ViewerId new_viewer() { return ++last_viewer_; }

  /// Returns the feed of a camera, created if needed. Throws HttpError 404 if there is no such camera,
  /// std::system_error if its thread cannot start.
  CameraFeed& of(std::uint32_t camera_id);

  /// Returns the feed of a camera that was watched before, even if the camera is gone; else null.
  CameraFeed* find(std::uint32_t camera_id);

  /// Stop the viewer's previews, and its detections, of all cameras.
  void stop_previews(CameraFeed::ViewerId viewer);
  void stop_detections(CameraFeed::ViewerId viewer);

 private:
  ViewSource& views_;
  std::atomic<std::uint64_t>& jpegs_encoded_;
  CameraFeed::ViewerId last_viewer_ = 0;
  std::map<std::uint32_t, std::unique_ptr<CameraFeed>> feeds_;
};

}  // namespace sslv
