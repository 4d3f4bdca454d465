// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>  // Asio of Boost 1.74 uses std::exchange without this include
#include <vector>

#include <boost/asio/ip/udp.hpp>

namespace sslv {

/// The address to listen on. Broadcasts to the port are received as well, on the same network card.
struct GroupAddress {
  std::string group;  // IPv4 multicast address, or a broadcast address
  int port = 0;
  std::string interface;  // name or IPv4 address of the network card; empty: selected by the system's routes

  bool operator==(const GroupAddress&) const = default;
};

/// The ways in which packets of a computer arrive.
struct Arrival {
  std::string address;
  bool by_multicast = false, by_broadcast = false;
};

/// A computer whose packets to the group arrive on a network card.
struct HeardOn {
  std::string address, card;
};

/// Receives the datagrams of a multicast group and the broadcasts to its port, in its own thread, which has
/// lower priority than the cameras' threads. A datagram that arrives both ways is passed on once. A group
/// that could not be joined is retried every `look_interval`. A group is rejoined after ten silent intervals,
/// because the card may have been removed and restored.
class MulticastReceiver {
 public:
  /// Called from the receiver's thread with every datagram and its sender.
  using Handler =
      std::function<void(std::span<const std::byte> datagram, const boost::asio::ip::udp::endpoint& sender)>;

  /// `thread_name` has at most 15 characters. Throws std::system_error if the thread cannot be created.
  MulticastReceiver(std::string thread_name, Handler handler,
                    std::chrono::milliseconds look_interval = std::chrono::seconds(1));
  ~MulticastReceiver();

  /// Listens at `where` from now on, or nowhere if `where` is empty. On return, the new socket receives, and
  /// the handler gets no more datagrams of the old socket. Must not be called from the handler or from two
  /// threads at the same time.
  void listen(const std::optional<GroupAddress>& where);

  /// Why nothing can be received at present; otherwise empty.
  std::string error() const;

  /// Why some or all broadcasts are not received at present; otherwise empty.
  std::string broadcast_error() const;

  /// Sets the IPv4 addresses of the named computers. Other computers cannot displace them, or this computer,
  /// from arrivals().
  void set_named(std::set<std::string> addresses);
  /// The senders of the last kForgottenAfter_s. `now_s`: monotonic.
  std::vector<Arrival> arrivals(double now_s) const;
  /// For each other network card on which packets to the group arrive, one of the senders. These packets are
  /// not passed on.
  std::vector<HeardOn> heard_elsewhere(double now_s) const;
  static constexpr double kForgottenAfter_s = 5;

 private:
  class Listener;
  struct Heard {
    double multicast_s = -1e9, broadcast_s = -1e9;
  };

  const std::string thread_name_;
  const Handler handler_;
  const std::chrono::milliseconds look_interval_;
  mutable std::mutex mutex_;  // guards the following five members
  std::string error_, broadcast_error_;
  std::set<std::string> named_;
  std::map<std::string, Heard> heard_;  // by address
  struct Elsewhere {
    std::string address;
    double time_s = -1e9;
  };
  std::map<std::string, Elsewhere> elsewhere_;  // by card
  std::unique_ptr<Listener> listener_;  // last: its thread ends before the members it uses are destroyed
};

}  // namespace sslv
