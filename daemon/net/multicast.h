// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"
#include "base/snapshot.h"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <stop_token>
#include <string>
#include <thread>
#include <tuple>
#include <utility>  // Asio of Boost 1.74 uses std::exchange without this include
#include <vector>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>

namespace sslv {

/// The destinations of packets. The defaults are the league's.
struct MulticastSettings {
  std::string group = "224.5.23.2";
  std::string broadcast{};
  int port = 10006;
  std::string interface;
  int ttl = 32;
  bool loopback = true;
  double geometry_interval_s = 1.0;

  static constexpr auto fields() {
    using M = MulticastSettings;
    return std::tuple{
        text("group", &M::group, "IPv4 multicast or broadcast address that teams listen to"),
        text("broadcast", &M::broadcast,
             "IPv4 broadcast address that packets are sent to as well, for switches that lose multicast: "
             "255.255.255.255 or the subnet's, such as 10.0.0.255; empty: none"),
        number("port", &M::port, 1, 65535, "", "UDP port that teams listen to"),
        text("interface", &M::interface,
             "name or IPv4 address of the network card on the field's network; empty: chosen by the "
             "system's routes"),
        number("ttl", &M::ttl, 1, 255, "", "routers that a packet may pass, plus one"),
        flag("loopback", &M::loopback,
             "programs on this computer receive the packets too; they always receive broadcasts"),
        number("geometry_interval_s", &M::geometry_interval_s, 0.1, 60.0, "s",
               "time between two geometry packets"),
    };
  }
};

/// Throws SettingsError, beginning with `path`, for a text that is neither an IPv4 multicast address nor a
/// possible broadcast address.
void check_group(const std::string& group, const std::string& path);

/// Throws SettingsError, beginning with `path`, for addresses that packets cannot be sent to. A missing
/// network card or subnet is not an error: either may appear later.
void check_multicast(const MulticastSettings& settings, const std::string& path);

struct MulticastStatus {
  std::uint64_t packets_sent = 0;  // packets sent to at least one destination
  std::uint64_t send_errors = 0;   // packets not sent to all destinations
  double packets_per_s = 0;        // rate of sent packets, averaged over the last second
  std::string error;               // why packets are not sent at present, and what to do; otherwise empty
  bool some_leave = false;         // despite the error, one of the destinations still works
};

/// Sends datagrams to a multicast group, a broadcast address, or both. Any thread may call send(), which
/// never waits, not even for a thread of lower priority that calls status(). Packets that the system does not
/// accept at once are lost and counted. A socket that cannot be opened or cannot send is reopened every
/// second. A missing broadcast address does not affect packets to the group; the sender searches for it every
/// second.
class MulticastSender {
 public:
  /// Throws like configure().
  explicit MulticastSender(const MulticastSettings& settings, const std::string& path = "/network");
  ~MulticastSender();
  MulticastSender(const MulticastSender&) = delete;
  MulticastSender& operator=(const MulticastSender&) = delete;

  /// Applies new settings. Throws like check_multicast(), and then keeps the old settings.
  void configure(const MulticastSettings& settings, const std::string& path = "/network");

  /// False if the packet was not sent to all destinations; status() gives the reason. Takes no lock.
  bool send(std::span<const std::byte> packet) noexcept;

  /// Whether a packet with this sender address was sent by this object, possibly before its socket was
  /// reopened. For an unknown address, reads this computer's addresses from the system, at a limited rate,
  /// because anyone can send from a port with the same number.
  bool is_own(const boost::asio::ip::udp::endpoint& sender) const;

  /// Does not wait while a socket is being opened.
  MulticastStatus status() const;

 private:
  static constexpr std::size_t kWays = 2;  // two destinations: the group and the broadcast address

  /// Text parts for the status.
  struct Words {
    std::array<std::string, kWays> to;  // "224.5.23.2:10006"
    std::string open_error;             // why there is no socket or no subnet; empty if both exist
    std::string advice;                 // what to do about a wrong or missing card
  };

  /// See MulticastStatus.
  struct Counts {
    std::atomic<std::uint64_t> packets_sent{0}, send_errors{0};
    std::atomic<double> packets_per_s{0};
  };

  // open(), keep() and find_ways() require control_mutex_.
  void open();
  void keep(int socket);
  void find_ways();
  void watch(const std::stop_token& stop);
  int error_of(std::size_t way) const;  // errno; 0 also without a destination
  std::string error_text(const Words& words) const;
  bool send_to(std::size_t way, std::uint64_t word, std::span<const std::byte> packet) noexcept;

  std::mutex control_mutex_;  // guards the next five members; held while a socket opens, not by senders
  MulticastSettings settings_;
  boost::asio::io_context io_;
  std::size_t newest_place_ = 0;
  bool is_open_ = false;  // the newest socket is open

  // File descriptors of the newest and the previous socket. A descriptor that is not -1 stays valid for this
  // object's lifetime, so that an interrupted sender finishes with the settings with which it began.
  std::array<int, 2> sockets_{-1, -1};
  // For each destination, its address and the index of its socket, see Way in multicast.cpp; 0: no
  // destination.
  std::array<std::atomic<std::uint64_t>, kWays> ways_{};

  std::array<std::atomic<int>, kWays> send_errors_{};  // errno of the last packet; 0: the packet was sent
  Counts counts_;
  Snapshot<Words> words_{Words{}};

  // Local ports of the current socket (low 16 bits) and of the previous socket (high 16 bits), whose packets
  // may still arrive.
  std::atomic<std::uint32_t> own_ports_{0};
  // The addresses that is_own() found last; the earliest time of its next query (steady clock).
  mutable Snapshot<std::vector<boost::asio::ip::address_v4>> own_addresses_{
      std::vector<boost::asio::ip::address_v4>{}};
  mutable std::atomic<double> asks_again_s_{0};

  std::jthread watcher_;  // last: stops before the members it uses are destroyed
};

}  // namespace sslv
