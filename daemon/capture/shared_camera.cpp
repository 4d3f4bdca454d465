// SPDX-License-Identifier: Apache-2.0
#include "capture/shared_camera.h"

#include <array>
#include <exception>
#include <map>
#include <utility>

namespace sslv {

struct SharedCamera::Pool {
  struct Held {
    Image image;
    std::shared_ptr<Pool> pool;  // set while the image is lent
    std::atomic<int> takers{0};
    std::atomic<bool> is_free{true};  // set last, after the other members are released
  };
  static constexpr std::size_t kMaxOut = 64;  // more than any backend lends at once
  std::array<Held, kMaxOut> held;

  /// Each taker's release of an image calls this; the last one frees the slot.
  static void let_go(void*, void* lent) noexcept {
    auto& held = *static_cast<Held*>(lent);
    if (held.takers.fetch_sub(1) > 1) return;
    held.image = Image();
    const std::shared_ptr<Pool> pool = std::move(held.pool);
    held.is_free.store(true);
  }
};

std::shared_ptr<SharedCamera> SharedCamera::get(const std::string& key, const Open& open) {
  struct Entry {
    std::mutex mutex;  // held while the camera is opened; other callers for this camera wait here
    std::weak_ptr<SharedCamera> camera;
  };
  static std::mutex mutex;
  static std::map<std::string, Entry> entries;  // entries are never removed
  const auto entry_of = [&]() -> Entry& {
    const std::lock_guard lock(mutex);
    return entries[key];
  };
  Entry& entry = entry_of();
  const std::lock_guard lock(entry.mutex);
  if (auto known = entry.camera.lock()) {
    const std::lock_guard known_lock(known->mutex_);
    if (known->end_ == CaptureStatus::kTimeout) return known;
  }
  std::shared_ptr<SharedCamera> camera(new SharedCamera(open()));
  entry.camera = camera;
  return camera;
}

SharedCamera::SharedCamera(std::unique_ptr<Source> source)
    : source_(std::move(source)), pool_(std::make_shared<Pool>()), thread_([this] { run(); }) {}

SharedCamera::~SharedCamera() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  thread_.join();
}

void SharedCamera::run() {
  for (;;) {
    {
      const std::lock_guard lock(mutex_);
      if (stop_) return;
    }
    CapturedImage image;
    std::string problem;
    CaptureStatus status = CaptureStatus::kLost;
    try {
      status = source_->next(image, problem, std::chrono::milliseconds(100));
    } catch (const std::exception& error) {
      problem = error.what();
    } catch (...) {
      problem = "unknown error";
    }
    if (status == CaptureStatus::kTimeout) {  // packet counts may have changed
      const std::lock_guard lock(mutex_);
      counts_ = {source_->dropped(), source_->packets()};
      continue;
    }
    hand_out(status, image, problem);
    if (status == CaptureStatus::kLost || status == CaptureStatus::kEnd) return;
  }
}

void SharedCamera::hand_out(CaptureStatus status, CapturedImage& image, const std::string& problem) {
  {
    const std::lock_guard lock(mutex_);
    counts_ = {source_->dropped(), source_->packets()};
    Pool::Held* held = nullptr;
    if (status == CaptureStatus::kImage && !takers_.empty()) {
      for (Pool::Held& one : pool_->held) {
        if (one.is_free.load()) held = &one;
      }
    }
    // If all slots are taken, the image is dropped.
    const bool none_is_free = status == CaptureStatus::kImage && held == nullptr;
    if (held != nullptr) {
      held->is_free.store(false);
      held->takers.store(static_cast<int>(takers_.size()));
      held->pool = pool_;
      held->image = std::move(image.image);
    }
    for (Taker* taker : takers_) {
      const bool has_picture = taker->status_ == CaptureStatus::kImage;
      if (status == CaptureStatus::kImage && (has_picture || none_is_free)) ++taker->dropped_;
      if (none_is_free || (status == CaptureStatus::kIncomplete && has_picture)) continue;
      taker->status_ = status;
      taker->problem_ = problem;
      if (held == nullptr) continue;
      taker->image_.image = Image(held->image.view(), nullptr, held, &Pool::let_go);
      taker->image_.times = image.times;
      taker->image_.whole = image.whole;
      taker->image_.is_damaged = image.is_damaged;
      taker->image_.name = image.name;
    }
    if (status == CaptureStatus::kLost || status == CaptureStatus::kEnd) {
      end_ = status;
      end_problem_ = problem;
    }
  }
  changed_.notify_all();
}

SharedCamera::Taker::Taker(std::shared_ptr<SharedCamera> camera) : camera_(std::move(camera)) {
  const std::lock_guard lock(camera_->mutex_);
  camera_->takers_.insert(this);
}

SharedCamera::Taker::~Taker() {
  const std::lock_guard lock(camera_->mutex_);
  camera_->takers_.erase(this);
}

CaptureStatus SharedCamera::Taker::next(CapturedImage& image, std::string& problem,
                                        std::chrono::milliseconds timeout) {
  std::unique_lock lock(camera_->mutex_);
  camera_->changed_.wait_for(lock, timeout, [&] {
    return status_ != CaptureStatus::kTimeout || camera_->end_ != CaptureStatus::kTimeout;
  });
  of_camera_ = camera_->counts_;
  if (status_ == CaptureStatus::kTimeout) {
    problem = camera_->end_problem_;
    return camera_->end_;
  }
  image = std::move(image_);
  problem = std::move(problem_);
  return std::exchange(status_, CaptureStatus::kTimeout);
}

}  // namespace sslv
