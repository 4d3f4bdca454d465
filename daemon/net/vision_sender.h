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

/// Publishes the detections of one camera from the camera's own thread. Reuses its message and buffer, so
/// that a frame allocates nothing in steady state.
class DetectionSender {
 public:
  explicit DetectionSender(MulticastSender& out) : out_(out) { buffer_.reserve(kMaxDatagramBytes); }

  /// Sends one packet, even without detections, and returns its t_sent (Unix s). Never waits; the
  /// MulticastSender counts packets that could not be sent.
  double send(const FrameInfo& info, const RobotList& robots, const BallList& balls) noexcept;
  /// The last packet if it was sent for this frame, otherwise empty.
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

/// Publishes the geometry periodically from its own thread, so that teams receive it even without a camera.
class GeometrySender {
 public:
  /// Sends nothing while `geometry` is null. Both references must outlive this object.
  GeometrySender(MulticastSender& out, const Snapshot<Geometry>& geometry,
                 std::chrono::duration<double> interval);

  /// Sends immediately and then at this interval. Call after a change of the interval or the geometry.
  void restart(std::chrono::duration<double> interval);

 private:
  void run(const std::stop_token& stop);
  void send();

  MulticastSender& out_;
  const Snapshot<Geometry>& geometry_;
  SSL_WrapperPacket packet_;  // like buffer_, used only by the thread
  std::vector<std::byte> buffer_;

  std::mutex mutex_;  // guards the following members
  std::condition_variable_any restarted_;
  std::chrono::duration<double> interval_;
  bool due_ = true;

  std::jthread thread_;  // last: ends before the members it uses are destroyed
};

}  // namespace sslv
