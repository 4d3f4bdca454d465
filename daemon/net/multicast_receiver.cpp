// SPDX-License-Identifier: Apache-2.0
#include "net/multicast_receiver.h"

#include "base/background.h"
#include "base/log.h"
#include "net/network_cards.h"

#include <array>
#include <cstdint>
#include <exception>
#include <future>
#include <thread>

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/multicast.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <netinet/in.h>

namespace sslv {
namespace {

namespace asio = boost::asio;
namespace multicast = boost::asio::ip::multicast;
using asio::ip::udp;

constexpr int kSilentLooks = 10;  // then the group is joined again

udp::socket join(asio::io_context& io, const GroupAddress& where) {
  const auto group = asio::ip::make_address_v4(where.group);
  udp::socket socket(io, udp::v4());
  socket.set_option(udp::socket::reuse_address(true));
  // Only what comes through the card that was asked for, not what others of this computer joined elsewhere.
  const int off = 0;
  setsockopt(socket.native_handle(), IPPROTO_IP, IP_MULTICAST_ALL, &off, sizeof off);
  socket.bind({group, static_cast<std::uint16_t>(where.port)});
  if (where.interface.empty()) {
    socket.set_option(multicast::join_group(group));
  } else {
    socket.set_option(multicast::join_group(group, find_network_card(where.interface)));
  }
  return socket;
}

}  // namespace

/// What the receiver's thread works on: one group at one card, or none.
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
      socket_ = udp::socket(io_);
      ++opened_;
      where_ = where;
      {
        const std::lock_guard lock(owner_.mutex_);
        owner_.error_.clear();
      }
      if (where_) open();
      done.set_value();
    });
    done.get_future().wait();
  }

 private:
  void open() {
    std::string error;
    try {
      socket_ = join(io_, *where_);
    } catch (const std::exception& caught) {
      socket_ = udp::socket(io_);
      error = "cannot listen to " + where_->group + ":" + std::to_string(where_->port) + ": " +
              caught.what() + "; " + network_cards_text();
    }
    silent_looks_ = 0;
    ++opened_;
    if (socket_.is_open()) receive();
    const std::lock_guard lock(owner_.mutex_);
    if (error != owner_.error_) {
      if (error.empty()) {
        log::info("multicast: listening to {}:{} again", where_->group, where_->port);
      } else {
        log::warning("multicast: {}", error);
      }
      owner_.error_ = std::move(error);
    }
  }

  void receive() {
    socket_.async_receive_from(
        asio::buffer(datagram_), sender_,
        [this, opened = opened_](const boost::system::error_code& error, std::size_t size) {
          if (opened != opened_) return;  // of a socket that is no more
          if (error) {
            socket_.close();  // look() reopens it
            return;
          }
          silent_looks_ = 0;
          owner_.handler_(std::span<const std::byte>(datagram_.data(), size), sender_);
          receive();
        });
  }

  void look() {
    timer_.expires_after(owner_.look_interval_);
    timer_.async_wait([this](const boost::system::error_code&) {
      if (where_ && (!socket_.is_open() || ++silent_looks_ >= kSilentLooks)) open();
      look();
    });
  }

  MulticastReceiver& owner_;
  // All below is the thread's, once there is one.
  std::optional<GroupAddress> where_;
  asio::io_context io_{1};
  udp::socket socket_{io_};
  udp::endpoint sender_;
  std::array<std::byte, 65'536> datagram_;
  asio::steady_timer timer_{io_};
  int silent_looks_ = 0;
  std::uint64_t opened_ = 0;
  std::jthread thread_;  // last, so that it ends before what it uses
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

}  // namespace sslv
