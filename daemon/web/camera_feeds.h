// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "web/camera_feed.h"

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>

namespace sslv {

/// The feeds of all cameras, each made when it is first asked for. One thread at a time.
class CameraFeeds {
 public:
  /// Both must outlive this.
  CameraFeeds(ViewSource& views, std::atomic<std::uint64_t>& jpegs_encoded);
  ~CameraFeeds() { ask_to_stop(); }
  /// Begins what the destructor does, and does not wait for it: all feeds end together.
  void ask_to_stop();

  CameraFeed::ViewerId new_viewer() { return ++last_viewer_; }

  /// Of a camera. Throws HttpError 404 when there is no such camera, std::system_error when its
  /// thread cannot start.
  CameraFeed& of(std::uint32_t camera_id);

  /// Of a camera that somebody has watched, even if there is none any more; null: nobody has.
  CameraFeed* find(std::uint32_t camera_id);

  /// Of every camera.
  void stop_previews(CameraFeed::ViewerId viewer);
  void stop_detections(CameraFeed::ViewerId viewer);

 private:
  ViewSource& views_;
  std::atomic<std::uint64_t>& jpegs_encoded_;
  CameraFeed::ViewerId last_viewer_ = 0;
  std::map<std::uint32_t, std::unique_ptr<CameraFeed>> feeds_;
};

}  // namespace sslv
