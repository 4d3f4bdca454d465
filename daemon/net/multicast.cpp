// SPDX-License-Identifier: Apache-2.0
#include "net/multicast.h"

#include "base/log.h"
#include "base/params_json.h"
#include "net/network_cards.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <stdexcept>

#include <boost/asio/buffer.hpp>
#include <boost/asio/error.hpp>
#include <boost/asio/ip/multicast.hpp>

namespace sslv {
namespace {

namespace asio = boost::asio;
namespace multicast = boost::asio::ip::multicast;
using asio::ip::address_v4;
using asio::ip::udp;

constexpr std::chrono::seconds kWatchInterval{1};

/// What to do about the wrong card or none, for the admin.
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
  if (!settings.interface.empty()) {
    socket.set_option(multicast::outbound_interface(find_card(settings.interface)));
  }
  socket.bind(udp::endpoint(udp::v4(), 0));  // now, so that its port is known before its first packet leaves
  return socket;
}

bool is_routing_error(const boost::system::error_code& error) {
  return error == asio::error::network_unreachable || error == asio::error::host_unreachable ||
         error == boost::system::errc::no_such_device || error == asio::error::network_down;
}

}  // namespace

void check_group(const std::string& group, const std::string& path) {
  boost::system::error_code error;
  const address_v4 address = asio::ip::make_address_v4(group, error);
  if (error || !address.is_multicast()) {
    refuse(path, group, "an IPv4 multicast address, 224.0.0.0 .. 239.255.255.255");
  }
}

void check_multicast(const MulticastSettings& settings, const std::string& path) {
  check_group(settings.group, path + "/group");
}

MulticastSender::MulticastSender(const MulticastSettings& settings, const std::string& path) {
  configure(settings, path);
  watcher_ = std::jthread([this](const std::stop_token& stop) { watch(stop); });
}

void MulticastSender::configure(const MulticastSettings& settings, const std::string& path) {
  check_multicast(settings, path);
  const std::lock_guard control(control_mutex_);
  settings_ = settings;
  open();
  const std::lock_guard lock(mutex_);
  send_error_ = {};
}

void MulticastSender::open() {
  udp::socket socket(io_);
  std::string error;
  try {
    socket = open_socket(io_, settings_);
    own_ports_ = own_ports_ << 16 | socket.local_endpoint().port();
  } catch (const std::exception& caught) {
    error = caught.what();
  }
  const std::lock_guard lock(mutex_);
  socket_ = std::move(socket);
  endpoint_ = {asio::ip::make_address_v4(settings_.group), static_cast<std::uint16_t>(settings_.port)};
  open_error_ = std::move(error);
}

bool MulticastSender::send(std::span<const std::byte> packet) noexcept {
  const std::lock_guard lock(mutex_);
  if (!socket_.is_open()) {
    ++send_errors_;
    return false;
  }
  socket_.send_to(asio::buffer(packet.data(), packet.size()), endpoint_, 0, send_error_);
  ++(send_error_ ? send_errors_ : packets_sent_);
  return !send_error_;
}

std::string MulticastSender::error_text() const {
  if (!open_error_.empty()) return open_error_;
  if (!send_error_) return {};
  std::string text = "cannot send to " + settings_.group + ":" + std::to_string(settings_.port) + ": " +
                     send_error_.message();
  if (is_routing_error(send_error_)) text += "; " + advice();
  return text;
}

bool MulticastSender::is_own(const udp::endpoint& sender) const {
  const std::uint32_t ports = own_ports_;
  if (sender.port() != (ports & 0xFFFF) && sender.port() != ports >> 16) return false;
  const std::vector<NetworkCard> cards = network_cards();
  return std::any_of(cards.begin(), cards.end(), [&](const NetworkCard& card) {
    return std::find(card.addresses.begin(), card.addresses.end(), sender.address()) != card.addresses.end();
  });
}

MulticastStatus MulticastSender::status() const {
  const std::scoped_lock lock(control_mutex_, mutex_);
  return {packets_sent_, send_errors_, packets_per_s_, error_text()};
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
    const std::lock_guard control(control_mutex_);
    bool failing = false;
    std::string error;
    {
      const std::lock_guard lock(mutex_);
      const Clock::time_point now = Clock::now();
      packets_per_s_ = static_cast<double>(packets_sent_ - sent_before) /
                       std::chrono::duration<double>(now - before).count();
      sent_before = packets_sent_;
      before = now;
      failing = !open_error_.empty() || (send_error_ && send_error_ != asio::error::would_block);
      error = error_text();
    }
    if (error != logged) {
      if (error.empty()) {
        log::info("multicast: sending to {}:{} again", settings_.group, settings_.port);
      } else {
        log::warning("multicast: {}", error);
      }
      logged = std::move(error);
    }
    if (failing) open();
  }
}

}  // namespace sslv
