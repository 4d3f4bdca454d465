// SPDX-License-Identifier: Apache-2.0
#include "web/camera_feeds.h"

#include "web/route.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace sslv {

CameraFeeds::CameraFeeds(ViewSource& views, std::atomic<std::uint64_t>& jpegs_encoded)
    : views_(views), jpegs_encoded_(jpegs_encoded) {}

void CameraFeeds::ask_to_stop() {
  for (const auto& [camera_id, feed] : feeds_) feed->request_stop();
}

CameraFeed& CameraFeeds::of(std::uint32_t camera_id) {
  const std::vector<std::uint32_t> known = views_.camera_ids();
  if (std::find(known.begin(), known.end(), camera_id) == known.end()) {
    throw HttpError(404, "no camera " + std::to_string(camera_id));
  }
  const auto feed = feeds_.find(camera_id);
  if (feed != feeds_.end()) return *feed->second;
  // Create it before inserting: its thread may fail to start, and every entry must hold a feed.
  auto made = std::make_unique<CameraFeed>(views_, camera_id, jpegs_encoded_);
  return *feeds_.emplace(camera_id, std::move(made)).first->second;
}

CameraFeed* CameraFeeds::find(std::uint32_t camera_id) {
  const auto feed = feeds_.find(camera_id);
  return feed == feeds_.end() ? nullptr : feed->second.get();
}

void CameraFeeds::stop_previews(CameraFeed::ViewerId viewer) {
  for (const auto& [camera_id, feed] : feeds_) feed->stop_preview(viewer);
}

void CameraFeeds::stop_detections(CameraFeed::ViewerId viewer) {
  for (const auto& [camera_id, feed] : feeds_) feed->stop_detections(viewer);
}

}  // namespace sslv
