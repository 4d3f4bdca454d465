// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sslv {

/// The newest packet of one kind, as received back from the network.
struct HeardPacket {
  std::vector<std::byte> bytes;  // an SSL_WrapperPacket
  double heard_s = 0;            // monotonic time of its arrival
  std::uint64_t count = 0;       // packets of this kind since listening began
  double per_s = 0;  // packets per second, over about the last second; 0 if no packet was received
};

/// Keeps the newest packets of this service as received back from the network: one per camera, and the
/// geometry. Thread-safe.
class HeardPackets {
 public:
  /// Adds one datagram. `now_s`: monotonic receive time.
  void receive(std::span<const std::byte> datagram, double now_s);
  void clear();

  /// The newest detection packet of each camera received in the last kForgottenAfter_s, by camera id.
  std::map<std::uint32_t, HeardPacket> detections(double now_s) const;
  std::optional<HeardPacket> geometry(double now_s) const;

  /// Packets are forgotten because cameras may be removed from the settings. The interval of geometry packets
  /// is at most a minute.
  static constexpr double kForgottenAfter_s = 61;

 private:
  struct Kind {
    HeardPacket newest;
    double second_began_s = 0;
    std::uint64_t in_second = 0;
    void take(std::span<const std::byte> datagram, double now_s);
    HeardPacket at(double now_s) const;
  };
  mutable std::mutex mutex_;  // guards cameras_ and geometry_
  std::map<std::uint32_t, Kind> cameras_;
  Kind geometry_;
};

/// The packet in protobuf's JSON mapping, in one line, with the field names of the .proto files. Absent
/// fields are omitted. Empty for bytes that are not a packet.
std::string packet_json(std::span<const std::byte> datagram);

}  // namespace sslv
