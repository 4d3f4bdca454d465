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
#include <utility>  // before Asio of Boost 1.74, which uses std::exchange without it
#include <vector>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>

namespace sslv {

/// Where packets go. The defaults are the league's.
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
             "name or IPv4 address of the network card on the field's network; empty: the system's routes "
             "choose"),
        number("ttl", &M::ttl, 1, 255, "", "routers that a packet may pass, plus one"),
        flag("loopback", &M::loopback,
             "programs on this computer receive the packets too; they always receive broadcasts"),
        number("geometry_interval_s", &M::geometry_interval_s, 0.1, 60.0, "s",
               "time between two geometry packets"),
    };
  }
};

/// Throws SettingsError, beginning with `path`, for a text that can be neither an IPv4 multicast address nor
/// a broadcast address.
void check_group(const std::string& group, const std::string& path);

/// Throws SettingsError, beginning with `path`, for addresses that packets cannot go to. A network card or
/// subnet that is not there is no such error: it may come later.
void check_multicast(const MulticastSettings& settings, const std::string& path);

struct MulticastStatus {
  std::uint64_t packets_sent = 0;  // that left, at least one of two ways
  std::uint64_t send_errors = 0;   // packets that did not leave, or failed one of two ways
  double packets_per_s = 0;        // sent, over the last second
  std::string error;               // why packets do not leave at present and what to do; empty when they do
  bool some_leave = false;         // beside an error: to the group or to the broadcast address they do
};

/// Sends datagrams to a multicast group, to a broadcast address, or to both. Any thread may send; nobody
/// waits, not even for a thread of lower priority that asks for the status: what the system does not take at
/// once is lost and counted. A socket that cannot be opened or cannot send is reopened every second. A
/// broadcast address that is not there keeps no packet from the group, and is looked for every second.
class MulticastSender {
 public:
  /// Throws as configure() does.
  explicit MulticastSender(const MulticastSettings& settings, const std::string& path = "/network");
  ~MulticastSender();
  MulticastSender(const MulticastSender&) = delete;
  MulticastSender& operator=(const MulticastSender&) = delete;

  /// Sends by new settings from now on. Throws as check_multicast() does, and then goes on with the old ones.
  void configure(const MulticastSettings& settings, const std::string& path = "/network");

  /// False when the packet did not leave, or not to both where there are two; status() says why. Takes no
  /// lock.
  bool send(std::span<const std::byte> packet) noexcept;

  /// Whether a packet with this sender's address came from here, also when the socket was reopened since.
  /// Asks the system for this computer's addresses only where this is none of those that it had, and seldom:
  /// anybody can send from a port of the same number.
  bool is_own(const boost::asio::ip::udp::endpoint& sender) const;

  /// Does not wait for a socket being opened.
  MulticastStatus status() const;

 private:
  static constexpr std::size_t kWays = 2;  // to the group and to the broadcast address

  /// What the words of a status are made of.
  struct Words {
    std::array<std::string, kWays> to;  // "224.5.23.2:10006"
    std::string open_error;             // why there is no socket, or no subnet; empty: there are
    std::string advice;                 // what to do about the wrong card or none
  };

  /// As MulticastStatus.
  struct Counts {
    std::atomic<std::uint64_t> packets_sent{0}, send_errors{0};
    std::atomic<double> packets_per_s{0};
  };

  // These three with control_mutex_ held.
  void open();
  void keep(int socket);
  void find_ways();
  void watch(const std::stop_token& stop);
  int error_of(std::size_t way) const;  // errno; 0 also where nothing goes
  std::string error_text(const Words& words) const;
  bool send_to(std::size_t way, std::uint64_t word, std::span<const std::byte> packet) noexcept;

  std::mutex control_mutex_;  // guards the five below; held while a socket is opened, and by no sender
  MulticastSettings settings_;
  boost::asio::io_context io_;
  std::size_t newest_place_ = 0;
  bool is_open_ = false;  // there is a socket in it

  // Numbers that lead to sockets as long as this lives, once they are not -1: the newest and the one before
  // it, so that a sender that was interrupted still sends by the settings that it began with.
  std::array<int, 2> sockets_{-1, -1};
  // Destination, and in which of the two places its socket is; 0: nothing goes there. See multicast.cpp.
  std::array<std::atomic<std::uint64_t>, kWays> ways_{};

  std::array<std::atomic<int>, kWays> send_errors_{};  // errno of the last packet; 0: it left
  Counts counts_;
  Snapshot<Words> words_{Words{}};

  // Local ports of the socket and, in the upper half, of the one before it, whose packets may be on their
  // way.
  std::atomic<std::uint32_t> own_ports_{0};
  // What is_own() found last, and when it may ask again (steady).
  mutable Snapshot<std::vector<boost::asio::ip::address_v4>> own_addresses_{
      std::vector<boost::asio::ip::address_v4>{}};
  mutable std::atomic<double> asks_again_s_{0};

  std::jthread watcher_;  // last, so that it ends before what it uses
};

}  // namespace sslv
