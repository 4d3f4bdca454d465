// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <stop_token>
#include <string>
#include <thread>
#include <tuple>
#include <utility>  // before Asio of Boost 1.74, which uses std::exchange without it

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>

namespace sslv {

/// Where packets go. The defaults are the league's.
struct MulticastSettings {
  std::string group = "224.5.23.2";
  int port = 10006;
  std::string interface;
  int ttl = 32;
  bool loopback = true;
  double geometry_interval_s = 1.0;

  static constexpr auto fields() {
    using M = MulticastSettings;
    return std::tuple{
        text("group", &M::group, "IPv4 multicast address that teams listen to"),
        number("port", &M::port, 1, 65535, "", "UDP port that teams listen to"),
        text("interface", &M::interface,
             "name or IPv4 address of the network card on the field's network; empty: the system's routes "
             "choose"),
        number("ttl", &M::ttl, 1, 255, "", "routers that a packet may pass, plus one"),
        flag("loopback", &M::loopback, "programs on this computer receive the packets too"),
        number("geometry_interval_s", &M::geometry_interval_s, 0.1, 60.0, "s",
               "time between two geometry packets"),
    };
  }
};

/// Throws SettingsError, beginning with `path`, for a text that is no IPv4 multicast address.
void check_group(const std::string& group, const std::string& path);

/// Throws SettingsError, beginning with `path`, for a group that is not an IPv4 multicast address. A network
/// card that is not there is no such error: it may come later.
void check_multicast(const MulticastSettings& settings, const std::string& path);

struct MulticastStatus {
  std::uint64_t packets_sent = 0;
  std::uint64_t send_errors = 0;  // packets that did not leave
  double packets_per_s = 0;       // over the last second
  std::string error;              // why packets do not leave at present and what to do; empty when they do
};

/// Sends datagrams to a multicast group. Any thread may send; nobody waits: what the system does not take at
/// once is lost and counted. A socket that cannot be opened or cannot send is opened anew every second.
class MulticastSender {
 public:
  /// Throws as configure() does.
  explicit MulticastSender(const MulticastSettings& settings, const std::string& path = "/network");

  /// Sends by new settings from now on. Throws as check_multicast() does, and then goes on with the old ones.
  void configure(const MulticastSettings& settings, const std::string& path = "/network");

  /// False when the packet did not leave; status() says why.
  bool send(std::span<const std::byte> packet) noexcept;

  /// Whether a packet with this sender's address came from here, also when the socket was opened anew since.
  /// Asks the system for this computer's addresses: not meant for every packet.
  bool is_own(const boost::asio::ip::udp::endpoint& sender) const;

  MulticastStatus status() const;

 private:
  void open();  // with control_mutex_ held
  void watch(const std::stop_token& stop);
  std::string error_text() const;  // with both mutexes held

  // Taken before mutex_, and held while a socket is opened, so that senders do not wait for that.
  mutable std::mutex control_mutex_;
  MulticastSettings settings_;

  // Local ports of the socket and, in the upper half, of the one before it, whose packets may be on their
  // way.
  std::atomic<std::uint32_t> own_ports_{0};

  mutable std::mutex mutex_;  // guards all below
  boost::asio::io_context io_;
  boost::asio::ip::udp::socket socket_{io_};
  boost::asio::ip::udp::endpoint endpoint_;
  std::string open_error_;
  boost::system::error_code send_error_;  // of the last packet
  std::uint64_t packets_sent_ = 0, send_errors_ = 0;
  double packets_per_s_ = 0;

  std::jthread watcher_;  // last, so that it ends before what it uses
};

}  // namespace sslv
