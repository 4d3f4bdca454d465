// SPDX-License-Identifier: Apache-2.0
#include "net/multicast_receiver.h"

#include "base/background.h"
#include "base/clock.h"
#include "base/log.h"
#include "geometry/limits.h"
#include "net/network_cards.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <functional>
#include <future>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <thread>

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/multicast.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>

namespace sslv {
namespace {

namespace asio = boost::asio;
namespace multicast = boost::asio::ip::multicast;
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

/// Binds to `address`, which excludes packets of other groups and unicast. Broadcasts are received from one
/// card only, and a group from the cards on which it is joined, whatever other programs join.
udp::socket open_at(asio::io_context& io, const address_v4& address, const GroupAddress& where,
                    const std::string& card) {
  udp::socket socket(io, udp::v4());
  socket.set_option(udp::socket::reuse_address(true));
  const int off = 0;
  setsockopt(socket.native_handle(), IPPROTO_IP, IP_MULTICAST_ALL, &off, sizeof off);
  const int on = 1;
  setsockopt(socket.native_handle(), IPPROTO_IP, IP_PKTINFO, &on, sizeof on);
  if (!address.is_multicast() && setsockopt(socket.native_handle(), SOL_SOCKET, SO_BINDTODEVICE, card.c_str(),
                                            static_cast<socklen_t>(card.size())) != 0)
    throw std::system_error(errno, std::generic_category(), card);
  socket.bind({address, static_cast<std::uint16_t>(where.port)});
  if (address.is_multicast() && where.interface.empty()) {
    socket.set_option(multicast::join_group(address));
  } else if (address.is_multicast()) {
    socket.set_option(multicast::join_group(address, find_network_card(where.interface)));
  }
  socket.non_blocking(true);
  return socket;
}

/// Joins the group on all cards that are up, so that computers on a card other than the chosen one are
/// noticed.
void join_on_all_cards(udp::socket& socket, const address_v4& group, const std::vector<NetworkCard>& cards) {
  for (const NetworkCard& card : cards) {
    if (!card.is_up || !card.has_multicast || card.addresses.empty()) continue;
    boost::system::error_code ignored;  // it may have been joined before
    socket.set_option(multicast::join_group(group, card.addresses.front()), ignored);
  }
}

struct Datagram {
  std::size_t size = 0;
  udp::endpoint sender;
  unsigned card = 0;  // the system's number of the card that it arrived on
};

/// Like udp::socket::receive_from(), with the card.
Datagram receive_from(udp::socket& socket, std::span<std::byte> buffer, boost::system::error_code& error) {
  sockaddr_in from{};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(in_pktinfo))> control;
  iovec part{buffer.data(), buffer.size()};
  msghdr message{};
  message.msg_name = &from;
  message.msg_namelen = sizeof from;
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  const ssize_t size = ::recvmsg(socket.native_handle(), &message, 0);
  if (size < 0) {
    error.assign(errno, boost::system::system_category());
    return {};
  }
  Datagram out{
      static_cast<std::size_t>(size), {address_v4(ntohl(from.sin_addr.s_addr)), ntohs(from.sin_port)}, 0};
  for (const cmsghdr* one = CMSG_FIRSTHDR(&message); one != nullptr;
       one = CMSG_NXTHDR(&message, const_cast<cmsghdr*>(one))) {
    if (one->cmsg_level != IPPROTO_IP || one->cmsg_type != IP_PKTINFO) continue;
    in_pktinfo info{};
    std::memcpy(&info, CMSG_DATA(one), sizeof info);
    out.card = static_cast<unsigned>(info.ipi_ifindex);
  }
  return out;
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
  // More entries than a socket's buffer has datagrams, because the sockets are read in turn.
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
      where_ = where;
      {
        const std::lock_guard lock(owner_.mutex_);
        owner_.error_.clear();
        owner_.broadcast_error_.clear();
        owner_.heard_.clear();
        owner_.heard_on_s_.clear();
      }
      if (where_) open();
      done.set_value();
    });
    done.get_future().wait();
  }

 private:
  /// A socket bound to one address. The pending asynchronous wait keeps it alive.
  struct Ear {
    udp::socket socket;
    address_v4 address;
    std::string card;    // card that broadcasts arrive on
    unsigned only_card;  // number of the chosen card; 0: any
  };

  bool has_ear(const address_v4& address) const {
    return std::ranges::any_of(
        ears_, [&](const auto& ear) { return ear->address == address && ear->socket.is_open(); });
  }

  template <class Which>
  void close_ears(Which which) {
    std::erase_if(ears_, [&](const auto& ear) {
      if (!which(*ear)) return false;
      boost::system::error_code ignored;
      ear->socket.close(ignored);  // the pending wait fails and releases the ear
      return true;
    });
  }

  void open_ear(const address_v4& address, const std::string& card) {
    close_ears([&](const Ear& one) { return one.address == address; });
    const unsigned only_card =
        address.is_multicast() && !where_->interface.empty() ? if_nametoindex(card.c_str()) : 0;
    ears_.push_back(
        std::make_shared<Ear>(Ear{open_at(io_, address, *where_, card), address, card, only_card}));
    receive(ears_.back());
  }

  /// Opens the missing sockets for the group and the current broadcast addresses.
  void open() {
    const std::vector<NetworkCard> cards = network_cards();
    own_.clear();
    card_names_.clear();
    for (const NetworkCard& one : cards) {
      for (const address_v4& address : one.addresses) own_.insert(address.to_string());
      card_names_[if_nametoindex(one.name.c_str())] = one.name;
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
      if (ear.address.is_multicast())  // a card that was removed and restored has another number
        return ear.only_card != 0 && !card.empty() && ear.only_card != if_nametoindex(card.c_str());
      return ear.card != card ||
             (ear.address != group && std::ranges::find(broadcasts, ear.address) == broadcasts.end());
    });
    try {
      if (card.empty() && !group.is_multicast()) throw std::runtime_error(broadcast_error);
      if (!has_ear(group)) open_ear(group, card);
      for (const auto& ear : ears_) {
        if (ear->address.is_multicast()) join_on_all_cards(ear->socket, group, cards);
      }
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

  void receive(const std::shared_ptr<Ear>& ear) {
    ear->socket.async_wait(udp::socket::wait_read, [this, ear](const boost::system::error_code& error) {
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
      const Datagram datagram = receive_from(ear.socket, datagram_, error);
      if (error == asio::error::would_block) return true;
      if (error) {
        ear.socket.close(error);
        return false;
      }
      hear(datagram, ear);
    }
    return true;
  }

  void hear(const Datagram& datagram, const Ear& ear) {
    const double now_s = steady_s();
    const std::string sender = datagram.sender.address().to_string();
    const bool is_multicast = ear.address.is_multicast();
    if (is_multicast) note_card(sender, datagram.card, now_s);
    if (ear.only_card != 0 && datagram.card != ear.only_card) return;
    if (is_multicast) silent_looks_ = 0;
    note(sender, !is_multicast, now_s);
    const std::span<const std::byte> bytes(datagram_.data(), datagram.size);
    if (!copies_.is_copy(bytes, datagram.sender, ear.address, now_s)) owner_.handler_(bytes, datagram.sender);
  }

  void note_card(const std::string& address, unsigned card, double now_s) {
    const auto name = card_names_.find(card);
    if (name == card_names_.end()) return;
    const std::lock_guard lock(owner_.mutex_);
    auto& heard = owner_.heard_on_s_;
    std::erase_if(heard, [&](const auto& one) { return now_s - one.second > kForgottenAfter_s; });
    const std::pair key(address, name->second);
    if (heard.contains(key) || heard.size() < limits::kMaxComputers) heard[key] = now_s;
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
  std::array<std::byte, 65'536> datagram_;
  Copies copies_;
  std::set<std::string> own_;                   // addresses of this computer
  std::map<unsigned, std::string> card_names_;  // by the system's numbers
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

std::vector<HeardOn> MulticastReceiver::heard_on_cards(double now_s) const {
  std::vector<HeardOn> out;
  const std::lock_guard lock(mutex_);
  for (const auto& [key, heard_s] : heard_on_s_) {
    if (now_s - heard_s <= kForgottenAfter_s) out.push_back({key.first, key.second});
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
