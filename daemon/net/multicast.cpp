// SPDX-License-Identifier: Apache-2.0
#include "net/multicast.h"

#include "base/clock.h"
#include "base/log.h"
#include "base/params_json.h"
#include "net/network_cards.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <stdexcept>
#include <system_error>

#include <boost/asio/ip/multicast.hpp>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace sslv {
namespace {

namespace asio = boost::asio;
namespace multicast = boost::asio::ip::multicast;
using asio::ip::address_v4;
using asio::ip::udp;

constexpr std::chrono::seconds kWatchInterval{1};

/// Advice to the admin about a wrong or missing card.
std::string advice() {
  return "set network/vision/interface to the card on the field's network; " + network_cards_text();
}

address_v4 find_card(const std::string& name_or_address) {
  try {
    return find_network_card(name_or_address);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(error.what() + (": " + advice()));
  }
}

udp::socket open_socket(asio::io_context& io, const MulticastSettings& settings) {
  udp::socket socket(io, udp::v4());
  socket.non_blocking(true);
  socket.set_option(multicast::hops(settings.ttl));
  socket.set_option(multicast::enable_loopback(settings.loopback));
  socket.set_option(udp::socket::broadcast(true));
  // Broadcasts are sent on the card to which the socket is bound.
  address_v4 card;
  if (!settings.interface.empty()) {
    card = find_card(settings.interface);
    socket.set_option(multicast::outbound_interface(card));
  }
  socket.bind(udp::endpoint(card, 0));  // bind now, so that the port is known before the first packet is sent
  return socket;
}

/// Why nothing may be sent to this destination; empty if sending is permitted. If no subnet has the broadcast
/// address, it is the address of a single computer.
std::string why_not_sent_to(const address_v4& destination, const std::string& interface) {
  if (destination.is_multicast()) return {};
  const std::vector<address_v4> there = broadcast_addresses(interface);
  if (std::ranges::find(there, destination) != there.end()) return {};
  std::string known;
  for (const address_v4& one : there) known += (known.empty() ? "" : ", ") + one.to_string();
  return "no subnet of " + (interface.empty() ? std::string("this computer") : "network card " + interface) +
         " has the broadcast address " + destination.to_string() + "; there are " + known;
}

void add_clause(std::string& text, const std::string& clause) {
  text += (text.empty() ? "" : "; ") + clause;
}

bool is_routing_error(int error) {
  return error == ENETUNREACH || error == EHOSTUNREACH || error == ENODEV || error == ENETDOWN;
}

/// Destination and socket index packed into one word, so that senders read them atomically.
struct Way {
  static constexpr std::uint64_t kOpen = 2;  // makes every word nonzero

  Way(std::uint32_t to_address, std::uint16_t to_port, std::size_t at)
      : address(to_address), port(to_port), place(at) {}
  explicit Way(std::uint64_t word)
      : address(static_cast<std::uint32_t>(word >> 32)),
        port(static_cast<std::uint16_t>(word >> 16)),
        place(word & 1) {}
  std::uint64_t word() const {
    return std::uint64_t{address} << 32 | std::uint64_t{port} << 16 | kOpen | place;
  }

  std::uint32_t address;
  std::uint16_t port;
  std::size_t place;
};

}  // namespace

void check_group(const std::string& group, const std::string& path) {
  boost::system::error_code error;
  const address_v4 address = asio::ip::make_address_v4(group, error);
  if (error || !(address.is_multicast() || may_be_broadcast(address))) {
    refuse(path, group,
           "an IPv4 multicast address, 224.0.0.0 .. 239.255.255.255, or a broadcast address, such as "
           "255.255.255.255 or 10.0.0.255");
  }
}

void check_multicast(const MulticastSettings& settings, const std::string& path) {
  check_group(settings.group, path + "/group");
  if (settings.broadcast.empty()) return;
  boost::system::error_code error;
  const address_v4 address = asio::ip::make_address_v4(settings.broadcast, error);
  if (error || !may_be_broadcast(address) || settings.broadcast == settings.group) {
    refuse(path + "/broadcast", settings.broadcast,
           "a broadcast address besides the group, such as 255.255.255.255 or 10.0.0.255, or nothing");
  }
}

MulticastSender::MulticastSender(const MulticastSettings& settings, const std::string& path) {
  configure(settings, path);
  watcher_ = std::jthread([this](const std::stop_token& stop) { watch(stop); });
}

MulticastSender::~MulticastSender() {
  watcher_ = {};
  for (const int socket : sockets_) {
    if (socket >= 0) ::close(socket);
  }
}

void MulticastSender::configure(const MulticastSettings& settings, const std::string& path) {
  check_multicast(settings, path);
  const std::lock_guard control(control_mutex_);
  settings_ = settings;
  open();
  for (auto& error : send_errors_) error = 0;
}

void MulticastSender::open() {
  is_open_ = false;
  try {
    udp::socket socket = open_socket(io_, settings_);
    own_ports_ = own_ports_ << 16 | socket.local_endpoint().port();
    keep(socket.native_handle());
    is_open_ = true;
    find_ways();
  } catch (const std::exception& caught) {
    for (auto& way : ways_) way = 0;
    words_.store(Words{{}, caught.what(), advice()});
  }
}

/// Duplicates the socket into the older of the two slots.
void MulticastSender::keep(int socket) {
  const std::size_t place = 1 - newest_place_;
  const int number =
      sockets_[place] < 0 ? ::fcntl(socket, F_DUPFD_CLOEXEC, 0) : ::dup3(socket, sockets_[place], O_CLOEXEC);
  if (number < 0) throw std::system_error(errno, std::generic_category(), "cannot open a socket");
  // A slot is written only once, before any sender uses it, because senders read it without a lock.
  if (sockets_[place] < 0) sockets_[place] = number;
  newest_place_ = place;
}

/// Switches senders to the newest socket, for destinations that this computer's subnets permit.
void MulticastSender::find_ways() {
  Words words{{}, {}, advice()};
  std::array<std::uint64_t, kWays> found{};  // 0: no destination
  const std::array<const std::string*, kWays> to{&settings_.group, &settings_.broadcast};
  for (std::size_t way = 0; way < kWays; ++way) {
    if (to[way]->empty()) continue;
    words.to[way] = *to[way] + ":" + std::to_string(settings_.port);
    const address_v4 address = asio::ip::make_address_v4(*to[way]);
    const std::string why = why_not_sent_to(address, settings_.interface);
    if (why.empty()) {
      found[way] = Way{address.to_uint(), static_cast<std::uint16_t>(settings_.port), newest_place_}.word();
    } else {
      add_clause(words.open_error, why);
    }
  }
  for (std::size_t way = 0; way < kWays; ++way) ways_[way] = found[way];
  words_.store(std::move(words));
}

bool MulticastSender::send(std::span<const std::byte> packet) noexcept {
  bool is_sent = false, is_lost = false;
  for (std::size_t way = 0; way < kWays; ++way) {
    const std::uint64_t word = ways_[way].load(std::memory_order_acquire);
    if (word != 0) (send_to(way, word, packet) ? is_sent : is_lost) = true;
  }
  const bool is_whole = is_sent && !is_lost;
  if (is_sent) counts_.packets_sent.fetch_add(1, std::memory_order_relaxed);
  if (!is_whole) counts_.send_errors.fetch_add(1, std::memory_order_relaxed);
  return is_whole;
}

bool MulticastSender::send_to(std::size_t way, std::uint64_t word,
                              std::span<const std::byte> packet) noexcept {
  const Way where(word);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_addr.s_addr = htonl(where.address);
  to.sin_port = htons(where.port);
  ssize_t sent = 0;
  do {
    sent = ::sendto(sockets_[where.place], packet.data(), packet.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                    reinterpret_cast<const sockaddr*>(&to), sizeof to);
  } while (sent < 0 && errno == EINTR);
  send_errors_[way].store(sent < 0 ? errno : 0, std::memory_order_relaxed);
  return sent >= 0;
}

int MulticastSender::error_of(std::size_t way) const {
  return ways_[way] == 0 ? 0 : send_errors_[way].load();
}

std::string MulticastSender::error_text(const Words& words) const {
  std::string text = words.open_error;
  for (std::size_t way = 0; way < kWays; ++way) {
    const int error = error_of(way);
    if (error == 0) continue;
    add_clause(text, "cannot send to " + words.to[way] + ": " + std::generic_category().message(error));
    if (is_routing_error(error)) add_clause(text, words.advice);
  }
  return text;
}

bool MulticastSender::is_own(const udp::endpoint& sender) const {
  const std::uint32_t ports = own_ports_;
  if (sender.port() != (ports & 0xFFFF) && sender.port() != ports >> 16) return false;
  if (!sender.address().is_v4()) return false;
  const auto is_in = [address = sender.address().to_v4()](const auto& addresses) {
    return std::find(addresses.begin(), addresses.end(), address) != addresses.end();
  };
  if (is_in(*own_addresses_.load())) return true;
  constexpr double kPause_s = 0.05;
  const double now_s = steady_s();
  if (now_s < asks_again_s_) return false;
  asks_again_s_ = now_s + kPause_s;
  std::vector<boost::asio::ip::address_v4> addresses;
  for (const NetworkCard& card : network_cards())
    addresses.insert(addresses.end(), card.addresses.begin(), card.addresses.end());
  const bool is_own = is_in(addresses);
  own_addresses_.store(std::move(addresses));
  return is_own;
}

MulticastStatus MulticastSender::status() const {
  bool leaves = false;
  for (std::size_t way = 0; way < kWays; ++way) leaves = leaves || (ways_[way] != 0 && error_of(way) == 0);
  return {counts_.packets_sent, counts_.send_errors, counts_.packets_per_s, error_text(*words_.load()),
          leaves};
}

void MulticastSender::watch(const std::stop_token& stop) {
  using Clock = std::chrono::steady_clock;
  std::mutex idle;
  std::condition_variable_any alarm;
  std::unique_lock idle_lock(idle);
  std::uint64_t sent_before = 0;
  Clock::time_point before = Clock::now();
  std::string logged;
  while (!alarm.wait_for(idle_lock, stop, kWatchInterval, [&] { return stop.stop_requested(); })) {
    const Clock::time_point now = Clock::now();
    const std::uint64_t sent = counts_.packets_sent;
    counts_.packets_per_s =
        static_cast<double>(sent - sent_before) / std::chrono::duration<double>(now - before).count();
    sent_before = sent;
    before = now;

    const std::lock_guard control(control_mutex_);
    const auto words = words_.load();
    bool is_failing = !is_open_;
    for (std::size_t way = 0; way < kWays; ++way)
      is_failing = is_failing || (error_of(way) != 0 && error_of(way) != EWOULDBLOCK);
    std::string error = error_text(*words);
    if (error != logged) {
      if (error.empty()) {
        log::info("multicast: sending to {} again", words->to[0]);
      } else {
        log::warning("multicast: {}", error);
      }
      logged = std::move(error);
    }
    if (is_failing) {
      open();
    } else if (!words->open_error.empty()) {
      find_ways();  // keep the socket, because is_own() knows only two ports
    }
  }
}

}  // namespace sslv
