// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/snapshot.h"
#include "net/multicast.h"
#include "net/packets.h"

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <stop_token>
#include <thread>
#include <vector>

namespace sslv {

/// The largest UDP payload of IPv4.
inline constexpr std::size_t kMaxDatagramBytes = 65'507;

/// Publishes the detections of one camera from the camera's own thread. Keeps its message and buffer, so a
/// frame allocates nothing in steady state.
class DetectionSender {
 public:
  explicit DetectionSender(MulticastSender& out) : out_(out) { buffer_.reserve(kMaxDatagramBytes); }

  /// Sends one packet, also when nothing was found, and returns its t_sent (Unix s). Never waits; a packet
  /// that does not leave is counted by the MulticastSender.
  double send(const FrameInfo& info, const RobotList& robots, const BallList& balls) noexcept;
  /// The one that was sent last, if it was of this frame; empty: none was.
  std::span<const std::byte> packet_of(std::uint32_t frame_number) const {
    return frame_number == last_number_ ? last_packet_ : std::span<const std::byte>();
  }

 private:
  MulticastSender& out_;
  SSL_WrapperPacket packet_;
  std::vector<std::byte> buffer_;
  std::span<const std::byte> last_packet_;
  std::uint32_t last_number_ = 0;
};

/// Publishes the geometry again and again from a thread of its own, so that teams get it without any camera.
class GeometrySender {
 public:
  /// Nothing is sent while `geometry` holds none. Both arguments must outlive this.
  GeometrySender(MulticastSender& out, const Snapshot<Geometry>& geometry,
                 std::chrono::duration<double> interval);

  /// Sends at once and then at this interval: to be called after a change of the interval or the geometry.
  void restart(std::chrono::duration<double> interval);

 private:
  void run(const std::stop_token& stop);
  void send();

  MulticastSender& out_;
  const Snapshot<Geometry>& geometry_;
  SSL_WrapperPacket packet_;  // this and the buffer: of the thread alone
  std::vector<std::byte> buffer_;

  std::mutex mutex_;  // guards all below
  std::condition_variable_any restarted_;
  std::chrono::duration<double> interval_;
  bool due_ = true;

  std::jthread thread_;  // last, so that it ends before what it uses
};

}  // namespace sslv
