// SPDX-License-Identifier: Apache-2.0
#include "net/multicast_receiver.h"

#include "base/background.h"
#include "base/clock.h"
#include "base/log.h"
#include "geometry/limits.h"
#include "net/group_socket.h"
#include "net/network_cards.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <future>
#include <stdexcept>
#include <string_view>
#include <thread>

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <net/if.h>

namespace sslv {
namespace {

namespace asio = boost::asio;
using asio::ip::address_v4;
using asio::ip::udp;

constexpr int kSilentLooks = 10;  // silent intervals before the group is rejoined

/// The name of the configured card, or of the card that the system's routes select. Throws
/// std::runtime_error.
std::string card_of(const GroupAddress& where) {
  if (!where.interface.empty()) return network_card_name(where.interface);
  const address_v4 from = address_towards(asio::ip::make_address_v4(where.group));
  if (from.is_unspecified()) throw std::runtime_error("no network card leads to " + where.group);
  return network_card_name(from.to_string());
}

/// Receives from one card only: neither groups that other programs joined on other cards, nor broadcasts sent
/// to other cards.
GroupSocket open_at(asio::io_context& io, const address_v4& address, const GroupAddress& where,
                    const std::string& card) {
  if (!address.is_multicast()) return {io, address, where.port, card};
  GroupSocket socket(io, address, where.port);
  boost::system::error_code error;
  socket.join(where.interface.empty() ? address_v4() : find_network_card(where.interface), error);
  if (error) throw boost::system::system_error(error, "cannot join the group");
  return socket;
}

/// The other cards on which a computer of the field may be.
std::vector<NetworkCard> other_cards(std::vector<NetworkCard> cards, const std::string& card) {
  const bool is_loopback =
      std::ranges::any_of(cards, [&](const NetworkCard& one) { return one.name == card && one.is_loopback; });
  if (is_loopback) return {};  // a trial
  std::erase_if(cards, [&](const NetworkCard& one) {
    return one.name == card || !one.is_up || !one.has_multicast || one.is_loopback || one.addresses.empty();
  });
  return cards;
}

/// Detects the second copy of a datagram that was sent to two addresses.
class Copies {
 public:
  bool is_copy(std::span<const std::byte> datagram, const udp::endpoint& sender, const address_v4& to,
               double now_s) {
    const std::string_view text(reinterpret_cast<const char*>(datagram.data()), datagram.size());
    const std::size_t hash = std::hash<std::string_view>()(text) ^ sender.address().to_v4().to_uint();
    constexpr double kLater_s = 1;
    for (Seen& one : seen_) {
      if (one.hash != hash || one.to == to || now_s - one.heard_s > kLater_s) continue;
      one = {};
      return true;
    }
    seen_[next_] = {hash, now_s, to};
    next_ = (next_ + 1) % seen_.size();
    return false;
  }

 private:
  struct Seen {
    std::size_t hash = 0;
    double heard_s = -1e9;
    address_v4 to{};
  };
  // Exceeds the number of datagrams in a socket's buffer: the sockets are read in turn.
  std::array<Seen, 512> seen_{};
  std::size_t next_ = 0;
};

}  // namespace

/// The receiver thread's state: the sockets for one group on one card and for broadcasts to its port, if any.
class MulticastReceiver::Listener {
 public:
  explicit Listener(MulticastReceiver& owner) : owner_(owner) {
    look();
    thread_ = std::jthread([this] {
      become_background_thread(owner_.thread_name_.c_str());
      io_.run();
    });
  }
  ~Listener() { io_.stop(); }

  void listen(const std::optional<GroupAddress>& where) {
    std::promise<void> done;
    asio::post(io_, [&] {
      close_ears([](const Ear&) { return true; });
      close_elsewhere();
      where_ = where;
      {
        const std::lock_guard lock(owner_.mutex_);
        owner_.error_.clear();
        owner_.broadcast_error_.clear();
        owner_.heard_.clear();
        owner_.elsewhere_.clear();
      }
      if (where_) open();
      done.set_value();
    });
    done.get_future().wait();
  }

 private:
  /// A socket bound to one address. The pending asynchronous wait keeps it alive.
  struct Ear {
    GroupSocket socket;
    address_v4 address;
    std::string card;  // card that broadcasts arrive on
  };

  bool has_ear(const address_v4& address) const {
    return std::ranges::any_of(
        ears_, [&](const auto& ear) { return ear->address == address && ear->socket.is_open(); });
  }

  template <class Which>
  void close_ears(Which which) {
    std::erase_if(ears_, [&](const auto& ear) {
      if (!which(*ear)) return false;
      ear->socket.close();  // the pending wait fails and releases the ear
      return true;
    });
  }

  void open_ear(const address_v4& address, const std::string& card) {
    close_ears([&](const Ear& one) { return one.address == address; });
    ears_.push_back(std::make_shared<Ear>(Ear{open_at(io_, address, *where_, card), address, card}));
    receive(ears_.back());
  }

  /// Opens the missing sockets for the group and the current broadcast addresses.
  void open() {
    const std::vector<NetworkCard> cards = network_cards();
    own_.clear();
    for (const NetworkCard& one : cards) {
      for (const address_v4& address : one.addresses) own_.insert(address.to_string());
    }
    const address_v4 group = asio::ip::make_address_v4(where_->group);
    std::string card, error, broadcast_error;
    std::vector<address_v4> broadcasts;
    try {
      card = card_of(*where_);
      broadcasts = broadcast_addresses(card);
    } catch (const std::exception& caught) {
      broadcast_error = caught.what();
    }
    close_ears([&](const Ear& ear) {
      return !ear.address.is_multicast() &&
             (ear.card != card ||
              (ear.address != group && std::ranges::find(broadcasts, ear.address) == broadcasts.end()));
    });
    try {
      if (card.empty() && !group.is_multicast()) throw std::runtime_error(broadcast_error);
      if (!has_ear(group)) open_ear(group, card);
    } catch (const std::exception& caught) {
      error = "cannot listen to " + where_->group + ":" + std::to_string(where_->port) + ": " +
              caught.what() + "; " + network_cards_text();
    }
    for (const address_v4& address : broadcasts) {
      try {
        if (!has_ear(address)) open_ear(address, card);
      } catch (const std::exception& caught) {
        broadcast_error = address.to_string() + ":" + std::to_string(where_->port) + ": " + caught.what();
      }
    }
    if (group.is_multicast() && !card.empty()) watch(group, other_cards(cards, card));
    const std::lock_guard lock(owner_.mutex_);
    if (error != owner_.error_) {
      if (error.empty()) {
        log::info("multicast: listening to {}:{} again", where_->group, where_->port);
      } else {
        log::warning("multicast: {}", error);
      }
      owner_.error_ = std::move(error);
    }
    if (broadcast_error != owner_.broadcast_error_) {
      if (!broadcast_error.empty())
        log::warning("multicast: broadcasts are not received: {}", broadcast_error);
      owner_.broadcast_error_ = std::move(broadcast_error);
    }
  }

  /// Watches these cards for computers of the field. The socket is reopened if they have changed.
  void watch(const address_v4& group, const std::vector<NetworkCard>& cards) {
    std::map<unsigned, std::string> names;
    for (const NetworkCard& one : cards)
      names[if_nametoindex(one.name.c_str())] = one.name + " " + one.addresses.front().to_string();
    if (names == watched_ && (elsewhere_ || names.empty())) return;
    watched_ = std::move(names);
    close_elsewhere();
    if (watched_.empty()) return;
    try {
      elsewhere_ = std::make_shared<GroupSocket>(io_, group, where_->port);
      for (const NetworkCard& one : cards) {
        boost::system::error_code ignored;  // the card may be gone
        elsewhere_->join(one.addresses.front(), ignored);
      }
      watch_on(elsewhere_);
    } catch (const std::runtime_error&) {
      close_elsewhere();  // the group's own socket fails as well, and its error is reported
    }
  }

  void close_elsewhere() {
    if (elsewhere_) elsewhere_->close();  // the pending wait fails and releases the socket
    elsewhere_.reset();
  }

  void watch_on(const std::shared_ptr<GroupSocket>& socket) {
    socket->async_wait([this, socket](const boost::system::error_code& failed) {
      if (failed || socket != elsewhere_) return;
      constexpr int kMost = 8;
      for (int i = 0; i < kMost; ++i) {
        boost::system::error_code error;
        const auto datagram = socket->read(buffer_, error);
        if (error) break;
        if (!datagram) continue;
        const auto card = watched_.find(datagram->card);
        const std::string address = datagram->sender.address().to_string();
        if (card == watched_.end() || own_.contains(address)) continue;
        const std::lock_guard lock(owner_.mutex_);
        owner_.elsewhere_[card->second.substr(0, card->second.find(' '))] = {address, steady_s()};
      }
      watch_on(socket);
    });
  }

  void receive(const std::shared_ptr<Ear>& ear) {
    ear->socket.async_wait([this, ear](const boost::system::error_code& error) {
      if (error || std::ranges::find(ears_, ear) == ears_.end()) return;  // the socket was closed
      if (read(*ear)) receive(ear);
    });
  }

  /// Reads at most kMost datagrams, so that the other sockets get their turn. False if the socket failed;
  /// look() then reopens it.
  bool read(Ear& ear) {
    constexpr int kMost = 64;
    for (int i = 0; i < kMost; ++i) {
      boost::system::error_code error;
      const auto datagram = ear.socket.read(buffer_, error);
      if (error == asio::error::would_block) return true;
      if (error) {
        ear.socket.close();
        return false;
      }
      if (datagram) hear(datagram->payload, datagram->sender, ear.address);
    }
    return true;
  }

  void hear(std::span<const std::byte> datagram, const udp::endpoint& sender, const address_v4& to) {
    const double now_s = steady_s();
    if (to.is_multicast()) silent_looks_ = 0;
    note(sender.address().to_string(), !to.is_multicast(), now_s);
    if (!copies_.is_copy(datagram, sender, to, now_s)) owner_.handler_(datagram, sender);
  }

  void note(const std::string& address, bool is_broadcast, double now_s) {
    const std::lock_guard lock(owner_.mutex_);
    auto& heard = owner_.heard_;
    std::erase_if(heard, [&](const auto& one) {
      return now_s - std::max(one.second.multicast_s, one.second.broadcast_s) > kForgottenAfter_s;
    });
    const auto is_stranger = [&](const std::string& who) {
      return !own_.contains(who) && !owner_.named_.contains(who);
    };
    if (!heard.contains(address) && is_stranger(address) &&
        std::ranges::count_if(heard, [&](const auto& one) { return is_stranger(one.first); }) >=
            std::ptrdiff_t{limits::kMaxComputers})
      return;
    (is_broadcast ? heard[address].broadcast_s : heard[address].multicast_s) = now_s;
  }

  void look() {
    timer_.expires_after(owner_.look_interval_);
    timer_.async_wait([this](const boost::system::error_code&) {
      if (where_) {
        if (++silent_looks_ >= kSilentLooks) {
          silent_looks_ = 0;
          close_ears([](const Ear& ear) { return ear.address.is_multicast(); });
        }
        open();
      }
      look();
    });
  }

  MulticastReceiver& owner_;
  // Once the thread runs, only it uses the following members.
  std::optional<GroupAddress> where_;
  asio::io_context io_{1};
  std::vector<std::shared_ptr<Ear>> ears_;
  std::array<std::byte, 65'536> buffer_;
  Copies copies_;
  std::set<std::string> own_;                // addresses of this computer
  std::shared_ptr<GroupSocket> elsewhere_;   // receives the group on other cards
  std::map<unsigned, std::string> watched_;  // these cards' names and addresses, by the system's numbers
  asio::steady_timer timer_{io_};
  int silent_looks_ = 0;
  std::jthread thread_;  // last: ends before the members it uses are destroyed
};

MulticastReceiver::MulticastReceiver(std::string thread_name, Handler handler,
                                     std::chrono::milliseconds look_interval)
    : thread_name_(std::move(thread_name)),
      handler_(std::move(handler)),
      look_interval_(look_interval),
      listener_(std::make_unique<Listener>(*this)) {}

MulticastReceiver::~MulticastReceiver() = default;

void MulticastReceiver::listen(const std::optional<GroupAddress>& where) {
  listener_->listen(where);
}

std::string MulticastReceiver::error() const {
  const std::lock_guard lock(mutex_);
  return error_;
}

std::string MulticastReceiver::broadcast_error() const {
  const std::lock_guard lock(mutex_);
  return broadcast_error_;
}

void MulticastReceiver::set_named(std::set<std::string> addresses) {
  const std::lock_guard lock(mutex_);
  named_ = std::move(addresses);
}

std::vector<HeardOn> MulticastReceiver::heard_elsewhere(double now_s) const {
  std::vector<HeardOn> out;
  const std::lock_guard lock(mutex_);
  for (const auto& [card, heard] : elsewhere_) {
    if (now_s - heard.time_s <= kForgottenAfter_s) out.push_back({heard.address, card});
  }
  return out;
}

std::vector<Arrival> MulticastReceiver::arrivals(double now_s) const {
  std::vector<Arrival> out;
  const std::lock_guard lock(mutex_);
  for (const auto& [address, heard] : heard_) {
    const Arrival one{address, now_s - heard.multicast_s <= kForgottenAfter_s,
                      now_s - heard.broadcast_s <= kForgottenAfter_s};
    if (one.by_multicast || one.by_broadcast) out.push_back(one);
  }
  return out;
}

}  // namespace sslv
