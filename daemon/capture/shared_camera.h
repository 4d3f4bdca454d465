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

/// One open camera whose images go to several takers, none of which waits for another. A thread of its own
/// takes them from the camera; nothing is copied and nothing allocated for each.
class SharedCamera {
 public:
  using Open = std::function<std::unique_ptr<Source>()>;

  /// The camera known by this key, or a new one. Throws what `open` throws.
  static std::shared_ptr<SharedCamera> get(const std::string& key, const Open& open);
  ~SharedCamera();

  struct Counts {
    std::uint64_t dropped = 0;
    std::optional<PacketCounts> packets;
  };

  /// Sees every image from its making on, as long as it comes to take them.
  class Taker {
   public:
    explicit Taker(std::shared_ptr<SharedCamera> camera);
    ~Taker();
    Taker(const Taker&) = delete;
    Taker& operator=(const Taker&) = delete;

    /// As Source::next().
    CaptureStatus next(CapturedImage& image, std::string& problem, std::chrono::milliseconds timeout);
    // As of the last next(). The source's own counters are for the thread that uses it.
    std::uint64_t dropped() const noexcept { return dropped_ + of_camera_.dropped; }
    std::optional<PacketCounts> packets() const noexcept { return of_camera_.packets; }
    SharedCamera& camera() const { return *camera_; }

   private:
    friend class SharedCamera;
    const std::shared_ptr<SharedCamera> camera_;
    Counts of_camera_;  // the taker's thread's
    // Guarded by the camera's mutex.
    CaptureStatus status_ = CaptureStatus::kTimeout;  // what came and was not taken; kTimeout: nothing
    CapturedImage image_;
    std::string problem_;
    std::atomic<std::uint64_t> dropped_{0};
  };

  std::shared_ptr<Controls> controls() { return source_->controls(); }
  std::vector<std::string> warnings() const { return source_->warnings(); }

 private:
  /// Images that several takers have; the last one to let go gives an image back to the camera, which may
  /// be closed by then.
  struct Pool;

  explicit SharedCamera(std::unique_ptr<Source> source);
  void run();
  void hand_out(CaptureStatus status, CapturedImage& image, const std::string& problem);

  const std::unique_ptr<Source> source_;
  std::mutex mutex_;  // guards what follows, and what the takers were given
  Counts counts_;     // as of the last call of next()
  std::condition_variable changed_;
  std::set<Taker*> takers_;
  CaptureStatus end_ = CaptureStatus::kTimeout;  // kLost or kEnd: there will be no more
  std::string end_problem_;
  bool stop_ = false;
  const std::shared_ptr<Pool> pool_;
  std::thread thread_;
};

}  // namespace sslv
