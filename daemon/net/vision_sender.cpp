// SPDX-License-Identifier: Apache-2.0
#include "net/vision_sender.h"

#include "base/clock.h"

namespace sslv {

double DetectionSender::send(const FrameInfo& info, const RobotList& robots, const BallList& balls) noexcept {
  const double t_sent_s = unix_time_s();
  write_detection(info, robots, balls, t_sent_s, packet_);
  last_packet_ = serialize(packet_, buffer_);
  last_number_ = info.number;
  out_.send(last_packet_);
  return t_sent_s;
}

GeometrySender::GeometrySender(MulticastSender& out, const Snapshot<Geometry>& geometry,
                               std::chrono::duration<double> interval)
    : out_(out),
      geometry_(geometry),
      interval_(interval),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

void GeometrySender::restart(std::chrono::duration<double> interval) {
  {
    const std::lock_guard lock(mutex_);
    interval_ = interval;
    due_ = true;
  }
  restarted_.notify_one();
}

void GeometrySender::run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    due_ = false;
    lock.unlock();
    send();
    lock.lock();
    restarted_.wait_for(lock, stop, interval_, [this] { return due_; });
  }
}

void GeometrySender::send() {
  const auto geometry = geometry_.load();
  if (!geometry) return;
  write_geometry(*geometry, packet_);
  out_.send(serialize(packet_, buffer_));
}

}  // namespace sslv
