// SPDX-License-Identifier: Apache-2.0
#include "web/camera_feed.h"

#include "base/background.h"
#include "base/log.h"
#include "web/route.h"

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

namespace sslv {
namespace {

constexpr double kDetectionsPerSecond = 30;
// Timeout for a view before checking again for viewers.
constexpr std::chrono::milliseconds kPatience{250};
// Pause after an image that cannot be encoded.
constexpr std::chrono::seconds kFailurePause{1};

std::chrono::steady_clock::duration interval_of(double per_second) {
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(1.0 / per_second));
}

/// The messages of one view, each made on first use and then shared.
class Messages {
 public:
  /// `drawing`: buffer for the labelled image, reused for each view.
  Messages(const View& view, JpegEncoder& encoder, std::vector<std::uint8_t>& drawing,
           std::atomic<std::uint64_t>& jpegs_encoded)
      : view_(view), encoder_(encoder), drawing_(drawing), jpegs_encoded_(jpegs_encoded) {}

  CameraFeed::Message detections() {
    if (!detections_) {
      Json data = header();
      data.update(view_.detections);
      detections_ =
          std::make_shared<const std::string>(to_text({{"topic", "detections"}, {"data", std::move(data)}}));
    }
    return detections_;
  }

  CameraFeed::Message preview(const PreviewWish& wish) {
    const Picture& picture = picture_for(wish);
    const int width = std::min(wish.width, picture.image.width);
    const Preview* alike = nullptr;
    for (const Preview& made : previews_) {
      if (made.picture != picture.kind || made.width != width || made.quality != wish.quality) continue;
      if (made.regions == wish.regions) return made.message;
      alike = &made;
    }
    const std::span<const char> jpeg =
        alike != nullptr ? jpeg_in(*alike->message) : encode(picture, width, wish.quality);
    Json data = header();
    data["picture"] = name_of(picture.kind);
    data["width"] = view_.image.width;
    data["height"] = view_.image.height;
    data.update(view_.detections);
    if (!view_.misses.empty()) data["misses"] = view_.misses;
    if (wish.regions) data["regions"] = view_.regions ? view_.regions() : Json(nullptr);
    previews_.push_back(
        {picture.kind, width, wish.quality, wish.regions, preview_message(to_text(data), jpeg)});
    return previews_.back().message;
  }

 private:
  struct Preview {
    PictureKind picture;
    int width, quality;
    bool regions;
    CameraFeed::Message message;
  };

  /// The result points into the encoder.
  std::span<const char> encode(const Picture& picture, int width, int quality) {
    const std::span<const std::uint8_t> jpeg = encoder_.encode(picture.image, width, quality, picture.chroma);
    ++jpegs_encoded_;
    return {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()};
  }

  const Picture& picture_for(const PreviewWish& wish) {
    if (wish.picture == PictureKind::kCamera) return camera_picture_;
    if (!labelled_picture_) labelled_picture_ = picture_of(view_, wish.picture, drawing_);
    return *labelled_picture_;
  }

  Json header() const {
    return {{"camera", view_.camera_id}, {"frame", view_.frame_number}, {"t_capture", view_.t_capture_s}};
  }

  static CameraFeed::Message preview_message(const std::string& header, std::span<const char> jpeg) {
    const auto length = static_cast<std::uint32_t>(header.size());
    std::string message;
    message.reserve(sizeof(length) + header.size() + jpeg.size());
    for (int shift = 0; shift < 32; shift += 8) message += static_cast<char>((length >> shift) & 0xff);
    message += header;
    message.append(jpeg.begin(), jpeg.end());
    return std::make_shared<const std::string>(std::move(message));
  }

  const View& view_;
  JpegEncoder& encoder_;
  std::vector<std::uint8_t>& drawing_;
  std::atomic<std::uint64_t>& jpegs_encoded_;
  CameraFeed::Message detections_;
  const Picture camera_picture_ = picture_of(view_, PictureKind::kCamera, drawing_);
  std::optional<Picture> labelled_picture_;  // the camera's image if there is no labelled one
  std::vector<Preview> previews_;
};

}  // namespace

std::span<const char> jpeg_in(const std::string& preview_message) {
  std::uint32_t header_size = 0;
  for (std::size_t i = sizeof(header_size); i-- > 0;)
    header_size = header_size << 8 | static_cast<unsigned char>(preview_message[i]);
  return std::span(preview_message).subspan(sizeof(header_size) + header_size);
}

CameraFeed::CameraFeed(ViewSource& views, std::uint32_t camera_id, std::atomic<std::uint64_t>& jpegs_encoded)
    : views_(views),
      camera_id_(camera_id),
      jpegs_encoded_(jpegs_encoded),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

void CameraFeed::start_preview(ViewerId viewer, const PreviewWish& wish, Sink sink) {
  {
    const std::lock_guard lock(mutex_);
    if (Watcher* watcher = find(viewer, true)) {
      watcher->wish = wish;
      watcher->interval = interval_of(wish.fps);
      watcher->due = Clock::now();
      watcher->seen_version = 0;  // sends the current image again, with the new wish
    } else {
      watchers_.push_back({viewer, wish, std::move(sink), interval_of(wish.fps), Clock::now()});
    }
  }
  changed_.notify_all();
}

void CameraFeed::acknowledge(ViewerId viewer, std::uint32_t frame_number) {
  {
    const std::lock_guard lock(mutex_);
    Watcher* watcher = find(viewer, true);
    if (watcher == nullptr || watcher->in_flight != frame_number) return;
    watcher->in_flight.reset();
  }
  changed_.notify_all();
}

void CameraFeed::acknowledge(ViewerId viewer) {
  {
    const std::lock_guard lock(mutex_);
    Watcher* watcher = find(viewer, true);
    if (watcher == nullptr) return;
    watcher->in_flight.reset();
  }
  changed_.notify_all();
}

void CameraFeed::start_detections(ViewerId viewer, Sink sink) {
  {
    const std::lock_guard lock(mutex_);
    if (find(viewer, false) != nullptr) return;
    watchers_.push_back(
        {viewer, std::nullopt, std::move(sink), interval_of(kDetectionsPerSecond), Clock::now()});
  }
  changed_.notify_all();
}

void CameraFeed::stop_preview(ViewerId viewer) {
  const std::lock_guard lock(mutex_);
  std::erase_if(watchers_, [&](const Watcher& watcher) { return watcher.viewer == viewer && watcher.wish; });
}

void CameraFeed::stop_detections(ViewerId viewer) {
  const std::lock_guard lock(mutex_);
  std::erase_if(watchers_, [&](const Watcher& watcher) { return watcher.viewer == viewer && !watcher.wish; });
}

CameraFeed::Watcher* CameraFeed::find(ViewerId viewer, bool preview) {
  for (Watcher& watcher : watchers_) {
    if (watcher.viewer == viewer && watcher.wish.has_value() == preview) return &watcher;
  }
  return nullptr;
}

std::optional<CameraFeed::Clock::time_point> CameraFeed::next_due() const {
  std::optional<Clock::time_point> next;
  for (const Watcher& watcher : watchers_) {
    if (!watcher.in_flight && (!next || watcher.due < *next)) next = watcher.due;
  }
  return next;
}

std::uint64_t CameraFeed::oldest_version_seen() const {
  const Clock::time_point now = Clock::now();
  std::uint64_t oldest = std::numeric_limits<std::uint64_t>::max();
  for (const Watcher& watcher : watchers_) {
    if (watcher.is_due(now)) oldest = std::min(oldest, watcher.seen_version);
  }
  return oldest;
}

std::vector<CameraFeed::Delivery> CameraFeed::take_due(const View& view) {
  const Clock::time_point now = Clock::now();
  std::vector<Delivery> deliveries;
  for (Watcher& watcher : watchers_) {
    if (!watcher.is_due(now) || watcher.seen_version >= view.version) continue;
    watcher.seen_version = view.version;
    // Relative to the due time, not to the current time, so that a slightly late view does not lower the
    // rate.
    watcher.due = std::max(watcher.due + watcher.interval, now + watcher.interval / 2);
    if (watcher.wish) watcher.in_flight = view.frame_number;
    deliveries.push_back({watcher.wish, watcher.sink});
  }
  return deliveries;
}

void CameraFeed::put_off(std::uint32_t frame_number) {
  const std::lock_guard lock(mutex_);
  for (Watcher& watcher : watchers_) {
    if (watcher.in_flight != frame_number) continue;
    watcher.in_flight.reset();
    watcher.due = Clock::now() + kFailurePause;
  }
}

void CameraFeed::deliver(const View& view, const std::vector<Delivery>& deliveries, JpegEncoder& encoder,
                         std::vector<std::uint8_t>& drawing) {
  Messages messages(view, encoder, drawing, jpegs_encoded_);
  for (const Delivery& to : deliveries) to.sink(to.wish ? messages.preview(*to.wish) : messages.detections());
}

void CameraFeed::run(const std::stop_token& stop) {
  become_idle_thread(("view" + std::to_string(camera_id_)).c_str());
  JpegEncoder encoder;
  std::vector<std::uint8_t> drawing;
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    const std::optional<Clock::time_point> due = next_due();
    if (!due) {
      changed_.wait(lock, stop, [&] { return next_due().has_value(); });
      continue;
    }
    const Clock::time_point now = Clock::now();
    if (*due > now) {
      changed_.wait_until(lock, stop, *due, [&] { return next_due() < due; });
      continue;
    }

    const std::uint64_t seen = oldest_version_seen();
    lock.unlock();
    std::optional<View> view = views_.wait_view(camera_id_, seen, kPatience);
    lock.lock();
    if (!view) {
      // wait_view() returns at once if the camera is missing.
      changed_.wait_until(lock, stop, now + kPatience, [] { return false; });
      continue;
    }
    const std::vector<Delivery> deliveries = take_due(*view);
    lock.unlock();
    try {
      deliver(*view, deliveries, encoder, drawing);
    } catch (const std::exception& error) {
      log::warning("web: no image of camera {} for viewers: {}", camera_id_, error.what());
      put_off(view->frame_number);
    }
    view.reset();  // release it before waiting
    lock.lock();
  }
}

}  // namespace sslv
