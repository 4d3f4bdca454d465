// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "net/multicast_receiver.h"
#include "net/vision_message.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

namespace sslv {

/// Another program that sends to the vision group.
struct OtherVision {
  std::string address;
  bool is_named = false;                       // by the settings: its cameras are used
  double silent_s = 0;                         // since its last packet
  std::vector<int> cameras;                    // ids it sends detections with, rising
  std::optional<SSL_GeometryFieldSize> field;  // of its last geometry, without lines and arcs
};

/// A size of the field that two visions tell differently.
struct SizeConflict {
  std::string name;
  double ours = 0, theirs = 0;
};

/// The sizes that both have and that are not the same.
std::vector<SizeConflict> size_conflicts(const SSL_GeometryFieldSize& ours,
                                         const SSL_GeometryFieldSize& theirs);

/// Who else sends to the vision group. Forgets a sender that is silent for some seconds. May be used from any
/// thread; listens in one of its own.
class OtherVisions {
 public:
  static constexpr double kForgottenAfter_s = 5;

  /// Whether the sender of a packet is this daemon.
  using IsOwn = std::function<bool(const boost::asio::ip::udp::endpoint&)>;
  /// Called from the listening thread with every datagram of this daemon that the network brought back.
  using OnOwn = std::function<void(std::span<const std::byte> datagram, double now_s)>;
  /// Likewise with what another vision says; `is_named`: the settings name its computer.
  using OnOther = std::function<void(const VisionMessage& message, const std::string& address, bool is_named,
                                     double now_s)>;
  explicit OtherVisions(
      IsOwn is_own, OnOwn on_own = [](std::span<const std::byte>, double) {},
      OnOther on_other = [](const VisionMessage&, const std::string&, bool, double) {});

  /// IPv4 addresses of the computers that the settings name.
  void set_named(std::set<std::string> addresses);

  /// Listens there from now on; nothing happens when it does already. Not for two threads at once.
  void listen(const GroupAddress& where);

  /// Hears nothing more.
  void stop() { receiver_.listen(std::nullopt); }

  /// Takes one datagram, at a monotonic time. For the listening thread, and for tests that do not listen.
  void receive(std::span<const std::byte> datagram, const boost::asio::ip::udp::endpoint& sender,
               double now_s);

  std::vector<OtherVision> seen(double now_s) const;
  /// Datagrams that could not be read or made no sense.
  std::uint64_t refused() const;
  /// Who sends there at all, this daemon among them, and which way it comes.
  std::vector<Arrival> arrivals(double now_s) const { return receiver_.arrivals(now_s); }
  std::string broadcast_error() const { return receiver_.broadcast_error(); }
  std::string error() const { return receiver_.error(); }

 private:
  struct Sender {
    double heard_s = 0;
    std::map<int, double> camera_heard_s;  // by id
    std::optional<SSL_GeometryFieldSize> field;
  };

  void note(const VisionMessage& message, const std::string& address, bool is_named,
            double now_s);  // with mutex_ held

  const IsOwn is_own_;
  const OnOwn on_own_;
  const OnOther on_other_;
  std::optional<GroupAddress> where_;
  mutable std::mutex mutex_;  // guards the three below
  std::set<std::string> named_;
  std::map<std::string, Sender> senders_;
  std::uint64_t refused_ = 0;
  MulticastReceiver receiver_;  // last, so that it ends before what it uses
};

}  // namespace sslv
