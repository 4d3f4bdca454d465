// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/source.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>

namespace sslv {

/// Delivers the images of one open camera to several takers, which never wait for each other. A thread of its
/// own receives the images; nothing is copied or allocated per taker.
class SharedCamera {
 public:
  using Open = std::function<std::unique_ptr<Source>()>;

  /// The open camera with this key, or a new one. Throws like `open`.
  static std::shared_ptr<SharedCamera> get(const std::string& key, const Open& open);
  ~SharedCamera();

  struct Counts {
    std::uint64_t dropped = 0;
    std::optional<PacketCounts> packets;
  };

  /// Receives every image delivered after its construction, if it takes the images in time.
  class Taker {
   public:
    explicit Taker(std::shared_ptr<SharedCamera> camera);
    ~Taker();
    Taker(const Taker&) = delete;
    Taker& operator=(const Taker&) = delete;

    /// See Source::next().
    CaptureStatus next(CapturedImage& image, std::string& problem, std::chrono::milliseconds timeout);
    // Counters as of the last next(). (Only the camera's own thread may read the source's counters.)
    std::uint64_t dropped() const noexcept { return dropped_ + of_camera_.dropped; }
    std::optional<PacketCounts> packets() const noexcept { return of_camera_.packets; }
    SharedCamera& camera() const { return *camera_; }

   private:
    friend class SharedCamera;
    const std::shared_ptr<SharedCamera> camera_;
    Counts of_camera_;  // used by the taker's thread only
    // Guarded by the camera's mutex.
    CaptureStatus status_ = CaptureStatus::kTimeout;  // result that arrived and was not taken; kTimeout: none
    CapturedImage image_;
    std::string problem_;
    std::atomic<std::uint64_t> dropped_{0};
  };

  std::shared_ptr<Controls> controls() { return source_->controls(); }
  std::vector<std::string> warnings() const { return source_->warnings(); }

 private:
  /// Images held by several takers. The last release of an image returns it to the camera, which may already
  /// be closed.
  struct Pool;

  explicit SharedCamera(std::unique_ptr<Source> source);
  void run();
  void hand_out(CaptureStatus status, CapturedImage& image, const std::string& problem);

  const std::unique_ptr<Source> source_;
  std::mutex mutex_;  // guards the following members and the takers' images
  Counts counts_;     // the source's counters after its last next()
  std::condition_variable changed_;
  std::set<Taker*> takers_;
  CaptureStatus end_ = CaptureStatus::kTimeout;  // kLost or kEnd: no more images will arrive
  std::string end_problem_;
  bool stop_ = false;
  const std::shared_ptr<Pool> pool_;
  std::thread thread_;
};

}  // namespace sslv
