// SPDX-License-Identifier: Apache-2.0
#include "net/multicast_receiver.h"

#include "base/clock.h"
#include "geometry/limits.h"
#include "support/becomes.h"
#include "support/group_listener.h"
#include "support/own_network.h"

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <stdexcept>
#include <string>
#include <vector>

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/multicast.hpp>
#include <gmock/gmock.h>

namespace sslv::multicast_receiver_test {
namespace {

using testing::HasSubstr;

/// Passes what a receiver heard to the test's thread.
class Heard {
 public:
  MulticastReceiver::Handler handler() {
    return [this](std::span<const std::byte> datagram, const boost::asio::ip::udp::endpoint& sender) {
      const std::lock_guard lock(mutex_);
      texts_.emplace_back(reinterpret_cast<const char*>(datagram.data()), datagram.size());
      last_sender_ = sender;
      came_.notify_one();
    };
  }
  std::string next(std::chrono::milliseconds patience = test::kPatience) {
    std::unique_lock lock(mutex_);
    if (!came_.wait_for(lock, patience, [this] { return !texts_.empty(); })) return "nothing";
    std::string text = std::move(texts_.front());
    texts_.pop_front();
    return text;
  }
  boost::asio::ip::udp::endpoint last_sender() {
    const std::lock_guard lock(mutex_);
    return last_sender_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable came_;
  std::deque<std::string> texts_;
  boost::asio::ip::udp::endpoint last_sender_;
};

GroupAddress at(const GroupListener& listener, const std::string& interface = "lo") {
  return {GroupListener::kGroup, listener.port(), interface};
}

void send(const GroupListener& to, const std::string& text) {
  MulticastSender sender(settings_for(to));
  send(sender, text);
}

/// Removes this program's socket (not the listener's own) from its group, as the kernel does when the network
/// card disappears.
void lose_membership(const GroupListener& listener) {
  const ip_mreq membership{{inet_addr(GroupListener::kGroup)}, {htonl(INADDR_LOOPBACK)}};
  for (int fd = 0; fd < 1024; ++fd) {
    sockaddr_in local{};
    socklen_t length = sizeof local;
    if (getsockname(fd, reinterpret_cast<sockaddr*>(&local), &length) == 0 && local.sin_family == AF_INET &&
        local.sin_port == htons(listener.port()) && fd != listener.fd() &&
        setsockopt(fd, IPPROTO_IP, IP_DROP_MEMBERSHIP, &membership, sizeof membership) == 0)
      return;
  }
  throw std::runtime_error("nobody else has joined the group");
}

TEST(MulticastReceiver, HearsEveryDatagramFromTheMomentItListens) {
  GroupListener group;
  Heard heard;
  MulticastReceiver receiver("test", heard.handler());
  receiver.listen(at(group));
  EXPECT_EQ(receiver.error(), "");
  const std::string large(65'507, 'x');
  for (const std::string& text : {std::string("one"), std::string(), large}) {
    send(group, text);
    EXPECT_EQ(heard.next(), text);
  }
  EXPECT_TRUE(heard.last_sender().address().is_loopback());
}

TEST(MulticastReceiver, ListensElsewhereOrNowhereWhenTold) {
  GroupListener first, second;
  Heard heard;
  MulticastReceiver receiver("test", heard.handler());
  receiver.listen(at(first));
  receiver.listen(at(second));
  send(first, "not heard");
  send(second, "second");
  EXPECT_EQ(heard.next(), "second");
  receiver.listen(std::nullopt);
  send(second, "not heard");
  receiver.listen(at(first));
  send(first, "first");
  EXPECT_EQ(heard.next(), "first");
}

TEST(MulticastReceiver, RejoinsASilentGroup) {
  GroupListener group;
  Heard heard;
  MulticastReceiver receiver("test", heard.handler(), std::chrono::milliseconds(20));
  receiver.listen(at(group));
  lose_membership(group);
  EXPECT_TRUE(test::becomes([&] {
    send(group, "again");
    return heard.next(std::chrono::milliseconds(10)) == "again";
  }));
  EXPECT_EQ(receiver.error(), "");
}

/// Sends to a broadcast address: a switch that loses multicast lets it through.
MulticastSettings broadcasting(const GroupListener& listener, const char* address) {
  MulticastSettings settings = settings_for(listener);
  settings.group = address;
  return settings;
}

TEST(MulticastReceiver, HearsBroadcastsToThePort) {
  GroupListener group;
  Heard heard;
  MulticastReceiver receiver("test", heard.handler());
  receiver.listen(at(group));
  for (const char* address : {"127.255.255.255", "255.255.255.255"}) {
    MulticastSender sender(broadcasting(group, address));
    EXPECT_TRUE(send(sender, address));
    EXPECT_EQ(heard.next(), address);
  }
  const auto arrivals = receiver.arrivals(steady_s());
  ASSERT_EQ(arrivals.size(), 1U);
  EXPECT_EQ(arrivals[0].address, "127.0.0.1");
  EXPECT_FALSE(arrivals[0].by_multicast);
  EXPECT_TRUE(arrivals[0].by_broadcast);
  EXPECT_TRUE(receiver.arrivals(steady_s() + 10).empty());
}

TEST(MulticastReceiver, CanReceiveBroadcastsOnly) {
  GroupListener group;
  Heard heard;
  MulticastReceiver receiver("test", heard.handler());
  receiver.listen(GroupAddress{"127.255.255.255", group.port(), "lo"});
  EXPECT_EQ(receiver.error(), "");
  send(group, "not heard");
  MulticastSender sender(broadcasting(group, "127.255.255.255"));
  EXPECT_TRUE(send(sender, "heard"));
  EXPECT_EQ(heard.next(), "heard");
}

TEST(MulticastReceiver, DropsCopiesThatArriveBothWays) {
  for (const char* other_way : {GroupListener::kGroup, "255.255.255.255"}) {
    GroupListener group;
    Heard heard;
    MulticastReceiver receiver("test", heard.handler());
    receiver.listen(at(group));
    MulticastSettings both = broadcasting(group, other_way);
    both.broadcast = "127.255.255.255";
    MulticastSender sender(both);
    std::vector<std::string> sent;
    for (int i = 0; i < 50; ++i) {
      sent.push_back(std::to_string(i));
      EXPECT_TRUE(send(sender, sent.back()));
    }
    std::vector<std::string> came;
    for (int i = 0; i < 50; ++i) came.push_back(heard.next());
    EXPECT_THAT(came, testing::UnorderedElementsAreArray(sent)) << other_way;
    EXPECT_TRUE(test::becomes([&] {
      const auto arrivals = receiver.arrivals(steady_s());
      return arrivals.size() == 1 && arrivals[0].by_broadcast &&
             arrivals[0].by_multicast == (other_way == GroupListener::kGroup);
    }));
    // A packet that arrives in only one of the two ways is also delivered: it is not a duplicate.
    MulticastSender alone(settings_for(group));
    send(alone, "the last");
    EXPECT_EQ(heard.next(), "the last") << "a copy came first";
  }
}

TEST(MulticastReceiver, DropsBroadcastsFromOtherCardsThanTheGroups) {
  const int status = without_network([] {
    if (!bring_loopback_up()) return kNoNamespaces;
    MulticastSettings settings;
    settings.group = "127.255.255.255";
    settings.interface = "lo";
    Heard heard;
    MulticastReceiver receiver("test", heard.handler(), std::chrono::milliseconds(1));
    receiver.listen(GroupAddress{GroupListener::kGroup, settings.port, ""});
    if (receiver.broadcast_error().find("no network card leads to 239.255.77.77") != 0) return 1;
    MulticastSender sender(settings);
    if (!send(sender, "no route leads to this card")) return 2;
    // A route needs an address that other computers could reach, not only 127.0.0.1.
    if (!set_loopback(SIOCSIFADDR, "10.9.9.1") || !route_to_loopback("239.0.0.0", "255.0.0.0"))
      return kNoNamespaces;
    if (!test::becomes([&] { return receiver.broadcast_error().empty() && receiver.error().empty(); }))
      return 3;
    settings.group = "10.255.255.255";
    sender.configure(settings);
    if (!send(sender, "now one does")) return 4;
    return heard.next() == "now one does" ? kPassed : 5;
  });
  if (status == kNoNamespaces) GTEST_SKIP() << "this system gives no network namespace";
  EXPECT_EQ(status, kPassed);
}

TEST(MulticastReceiver, SaysWhyBroadcastsAreNotHeardWhileTheGroupIs) {
  GroupListener group;
  boost::asio::io_context io;
  const boost::asio::ip::udp::socket another_program(
      io, {boost::asio::ip::make_address_v4("127.255.255.255"), group.port()});
  Heard heard;
  MulticastReceiver receiver("test", heard.handler());
  receiver.listen(at(group));
  EXPECT_EQ(receiver.error(), "");
  EXPECT_THAT(receiver.broadcast_error(),
              testing::AllOf(testing::StartsWith("127.255.255.255:"), HasSubstr("Address already in use")));
  send(group, "heard");
  EXPECT_EQ(heard.next(), "heard");
  receiver.listen(std::nullopt);
  EXPECT_EQ(receiver.broadcast_error(), "");
}

/// Sends `address` to the group from that address, as another computer would.
void send_from(const std::string& address, const GroupListener& to) {
  namespace ip = boost::asio::ip;
  boost::asio::io_context io;
  ip::udp::socket socket(io, {ip::make_address_v4(address), 0});
  socket.set_option(ip::multicast::outbound_interface(ip::address_v4::loopback()));
  socket.send_to(boost::asio::buffer(address), {ip::make_address_v4(GroupListener::kGroup), to.port()});
}

TEST(MulticastReceiver, ManyStrangersDoNotDisplaceKnownSenders) {
  GroupListener group;
  Heard heard;
  MulticastReceiver receiver("test", heard.handler());
  receiver.set_named({"127.0.1.1"});
  receiver.listen(at(group));
  std::vector<std::string> senders;
  for (std::size_t i = 0; i < limits::kMaxComputers + 3; ++i)
    senders.push_back("127.0.2." + std::to_string(i + 1));
  senders.insert(senders.end(), {"127.0.1.1", "127.0.0.1"});
  for (const std::string& address : senders) {
    send_from(address, group);
    EXPECT_EQ(heard.next(), address);
  }
  senders.erase(senders.begin() + std::ptrdiff_t{limits::kMaxComputers}, senders.end() - 2);
  std::vector<std::string> listed;
  for (const Arrival& one : receiver.arrivals(steady_s())) listed.push_back(one.address);
  EXPECT_THAT(listed, testing::UnorderedElementsAreArray(senders));
}

TEST(MulticastReceiver, LosesNoBroadcastWhileRejoining) {
  GroupListener group;
  Heard heard;
  MulticastReceiver receiver("test", heard.handler(), std::chrono::milliseconds(1));
  receiver.listen(at(group));
  MulticastSender sender(broadcasting(group, "127.255.255.255"));
  for (int i = 0; i < 300; ++i) {
    EXPECT_TRUE(send(sender, std::to_string(i)));
    EXPECT_EQ(heard.next(), std::to_string(i));
  }
}

TEST(MulticastReceiver, SaysWhichCardIsNotThere) {
  GroupListener group;
  Heard heard;
  MulticastReceiver receiver("test", heard.handler());
  receiver.listen(at(group, "nocard0"));
  EXPECT_THAT(receiver.error(), HasSubstr("cannot listen to 239.255.77.77:"));
  EXPECT_THAT(receiver.error(), HasSubstr("no network card has the name or IPv4 address 'nocard0'"));
  EXPECT_THAT(receiver.broadcast_error(), HasSubstr("'nocard0'"));
  receiver.listen(at(group));
  EXPECT_EQ(receiver.error(), "");
  EXPECT_EQ(receiver.broadcast_error(), "");
  send(group, "heard");
  EXPECT_EQ(heard.next(), "heard");
}

}  // namespace
}  // namespace sslv::multicast_receiver_test
