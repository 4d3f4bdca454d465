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
#include <utility>  // before Asio of Boost 1.74, which uses std::exchange without it
#include <vector>

#include <boost/asio/ip/udp.hpp>

namespace sslv {

/// Where to listen. Broadcasts to the port are heard as well, by the same network card.
struct GroupAddress {
  std::string group;  // IPv4 multicast address, or a broadcast address
  int port = 0;
  std::string interface;  // name or IPv4 address of the network card; empty: the system's routes choose

  bool operator==(const GroupAddress&) const = default;
};

/// Which way the packets of a computer come.
struct Arrival {
  std::string address;
  bool by_multicast = false, by_broadcast = false;
};

/// Hears a multicast group, and broadcasts to its port, in a thread of its own, which yields to the cameras'
/// threads. What comes both ways is handed on once. Looks every second: a group that cannot be joined is
/// tried again; one that was silent at ten looks is joined again, as its card may have gone and come back.
class MulticastReceiver {
 public:
  /// Called with every datagram and who sent it, from the receiver's thread.
  using Handler =
      std::function<void(std::span<const std::byte> datagram, const boost::asio::ip::udp::endpoint& sender)>;

  /// `thread_name` has at most 15 characters. Throws std::system_error when the thread cannot be had.
  MulticastReceiver(std::string thread_name, Handler handler,
                    std::chrono::milliseconds look_interval = std::chrono::seconds(1));
  ~MulticastReceiver();

  /// Listens there from now on, or nowhere. When it returns, what comes now is heard, and the handler has
  /// seen the last datagram of the place before. Not for the handler, nor for two threads at once.
  void listen(const std::optional<GroupAddress>& where);

  /// Why nothing can be heard at present; empty when it can.
  std::string error() const;

  /// Why broadcasts, or some of them, are not heard at present; empty when they are.
  std::string broadcast_error() const;

  /// IPv4 addresses of computers that others leave room for in arrivals(), as they do for this one.
  void set_named(std::set<std::string> addresses);
  /// Who was heard in the last kForgottenAfter_s, at a monotonic time.
  std::vector<Arrival> arrivals(double now_s) const;
  static constexpr double kForgottenAfter_s = 5;

 private:
  class Listener;
  struct Heard {
    double multicast_s = -1e9, broadcast_s = -1e9;
  };

  const std::string thread_name_;
  const Handler handler_;
  const std::chrono::milliseconds look_interval_;
  mutable std::mutex mutex_;  // guards the next four
  std::string error_, broadcast_error_;
  std::set<std::string> named_;
  std::map<std::string, Heard> heard_;  // by address
  std::unique_ptr<Listener> listener_;  // last, so that its thread ends before what it uses
};

}  // namespace sslv
