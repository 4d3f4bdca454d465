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
  bool is_named = false;                       // named in the settings: its cameras are used
  double silent_s = 0;                         // time since its last packet
  std::vector<int> cameras;                    // camera ids in its detections, ascending
  std::optional<SSL_GeometryFieldSize> field;  // field of its last geometry packet, without lines and arcs
};

/// A field dimension for which two visions publish different values.
struct SizeConflict {
  std::string name;
  double ours = 0, theirs = 0;
};

/// The dimensions that both messages contain with different values.
std::vector<SizeConflict> size_conflicts(const SSL_GeometryFieldSize& ours,
                                         const SSL_GeometryFieldSize& theirs);

/// The other programs that send to the vision group. Forgets a sender that is silent for a few seconds.
/// Thread-safe; receives in its own thread.
class OtherVisions {
 public:
  static constexpr double kForgottenAfter_s = 5;

  /// Whether packets with this sender address were sent by this daemon.
  using IsOwn = std::function<bool(const boost::asio::ip::udp::endpoint&)>;
  /// Called from the listening thread with every datagram of this daemon that the network returned.
  using OnOwn = std::function<void(std::span<const std::byte> datagram, double now_s)>;
  /// Called from the listening thread with every message of another vision. `is_named`: the settings name the
  /// sender's computer.
  using OnOther = std::function<void(const VisionMessage& message, const std::string& address, bool is_named,
                                     double now_s)>;
  explicit OtherVisions(
      IsOwn is_own, OnOwn on_own = [](std::span<const std::byte>, double) {},
      OnOther on_other = [](const VisionMessage&, const std::string&, bool, double) {});

  /// IPv4 addresses of the computers named in the settings.
  void set_named(std::set<std::string> addresses);

  /// Listens at `where` from now on; does nothing if it already listens there. Must not be called from two
  /// threads at the same time.
  void listen(const GroupAddress& where);

  /// Stops listening.
  void stop() { receiver_.listen(std::nullopt); }

  /// Processes one datagram. `now_s`: monotonic receive time. For the listening thread, and for tests that do
  /// not listen.
  void receive(std::span<const std::byte> datagram, const boost::asio::ip::udp::endpoint& sender,
               double now_s);

  std::vector<OtherVision> seen(double now_s) const;
  /// Number of datagrams that could not be decoded or were invalid.
  std::uint64_t refused() const;
  /// All senders, including this daemon, and the ways in which their packets arrive.
  std::vector<Arrival> arrivals(double now_s) const { return receiver_.arrivals(now_s); }
  std::vector<HeardOn> heard_elsewhere(double now_s) const { return receiver_.heard_elsewhere(now_s); }
  std::string broadcast_error() const { return receiver_.broadcast_error(); }
  std::string error() const { return receiver_.error(); }

 private:
  struct Sender {
    double heard_s = 0;
    std::map<int, double> camera_heard_s;  // by camera id
    std::optional<SSL_GeometryFieldSize> field;
  };

  void note(const VisionMessage& message, const std::string& address, bool is_named,
            double now_s);  // requires mutex_

  const IsOwn is_own_;
  const OnOwn on_own_;
  const OnOther on_other_;
  std::optional<GroupAddress> where_;
  mutable std::mutex mutex_;  // guards the following three members
  std::set<std::string> named_;
  std::map<std::string, Sender> senders_;
  std::uint64_t refused_ = 0;
  MulticastReceiver receiver_;  // last: stops before the members it uses are destroyed
};

}  // namespace sslv
