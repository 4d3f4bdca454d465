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

/// The newest packet of a kind, as it came back from the network.
struct HeardPacket {
  std::vector<std::byte> bytes;  // an SSL_WrapperPacket
  double heard_s = 0;            // monotonic
  std::uint64_t count = 0;       // packets of this kind since the service listens there
  double per_s = 0;              // over the last second or so; 0 when none came
};

/// Keeps the newest packets that this service heard itself send: one for each camera, and the geometry.
/// May be used from any thread.
class HeardPackets {
 public:
  /// Takes one datagram, at a monotonic time.
  void receive(std::span<const std::byte> datagram, double now_s);
  void clear();

  /// Of each camera, by its id, that was heard in the last kForgottenAfter_s.
  std::map<std::uint32_t, HeardPacket> detections(double now_s) const;
  std::optional<HeardPacket> geometry(double now_s) const;

  /// Cameras may be taken out of the settings, and the geometry comes every minute at the longest.
  static constexpr double kForgottenAfter_s = 61;

 private:
  struct Kind {
    HeardPacket newest;
    double second_began_s = 0;
    std::uint64_t in_second = 0;
    void take(std::span<const std::byte> datagram, double now_s);
    HeardPacket at(double now_s) const;
  };
  mutable std::mutex mutex_;  // guards both
  std::map<std::uint32_t, Kind> cameras_;
  Kind geometry_;
};

/// A message in protobuf's own JSON, with the names of the .proto files, in one line; fields that the packet
/// does not have are absent. Empty for bytes that are no packet.
std::string packet_json(std::span<const std::byte> datagram);

}  // namespace sslv
