// SPDX-License-Identifier: Apache-2.0
#include "net/multicast_receiver.h"

#include "base/clock.h"
#include "geometry/limits.h"
#include "support/becomes.h"
#include "support/group_listener.h"
#include "support/own_network.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/multicast.hpp>
#include <gmock/gmock.h>
#include <linux/capability.h>
#include <poll.h>
#include <sys/syscall.h>

namespace sslv::multicast_receiver_test {
namespace {

using testing::HasSubstr;

/// Sets or clears the right to open raw sockets, for this thread and those that it creates. False if it is
/// missing.
bool set_raw_sockets(bool are_permitted) {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, _LINUX_CAPABILITY_U32S_3> rights{};
  if (syscall(SYS_capget, &header, rights.data()) != 0) return false;
  constexpr std::uint32_t kRight = 1U << CAP_NET_RAW;
  if (are_permitted && !(rights[0].permitted & kRight)) return false;
  rights[0].effective = are_permitted ? rights[0].effective | kRight : rights[0].effective & ~kRight;
  return syscall(SYS_capset, &header, rights.data()) == 0;
}

/// The parameter: whether raw sockets are permitted.
class MulticastReceiverTest : public testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    if (!set_raw_sockets(GetParam())) GTEST_SKIP() << "not permitted: raw sockets";
  }
  void TearDown() override { set_raw_sockets(true); }
};

INSTANTIATE_TEST_SUITE_P(, MulticastReceiverTest, testing::Bool(),
                         [](const auto& parameter) { return parameter.param ? "Raw" : "Bound"; });

class MulticastReceiverWithoutRights : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(set_raw_sockets(false)); }
  void TearDown() override { set_raw_sockets(true); }
};

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

/// Removes this program's other socket from the listener's group, as the kernel does when the network card
/// disappears.
void lose_membership(const GroupListener& listener) {
  const ip_mreq membership{{inet_addr(GroupListener::kGroup.c_str())}, {htonl(INADDR_LOOPBACK)}};
  for (int fd = 0; fd < 1024; ++fd) {
    if (fd != listener.fd() &&
        setsockopt(fd, IPPROTO_IP, IP_DROP_MEMBERSHIP, &membership, sizeof membership) == 0)
      return;
  }
  throw std::runtime_error("nobody else has joined the group");
}

TEST_P(MulticastReceiverTest, HearsEveryDatagramFromTheMomentItListens) {
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

TEST_P(MulticastReceiverTest, ListensElsewhereOrNowhereWhenTold) {
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

TEST_P(MulticastReceiverTest, RejoinsASilentGroup) {
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

TEST_P(MulticastReceiverTest, HearsBroadcastsToThePort) {
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

TEST_P(MulticastReceiverTest, CanReceiveBroadcastsOnly) {
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

TEST_P(MulticastReceiverTest, DropsCopiesThatArriveBothWays) {
  for (const std::string& other_way : {GroupListener::kGroup, std::string("255.255.255.255")}) {
    GroupListener group;
    Heard heard;
    MulticastReceiver receiver("test", heard.handler());
    receiver.listen(at(group));
    MulticastSettings both = broadcasting(group, other_way.c_str());
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

TEST_P(MulticastReceiverTest, DropsBroadcastsFromOtherCardsThanTheGroups) {
  const int status = without_network([] {
    if (!bring_loopback_up()) return kNoNamespaces;
    MulticastSettings settings;
    settings.group = "127.255.255.255";
    settings.interface = "lo";
    Heard heard;
    MulticastReceiver receiver("test", heard.handler(), std::chrono::milliseconds(1));
    receiver.listen(GroupAddress{GroupListener::kGroup, settings.port, ""});
    if (!receiver.broadcast_error().starts_with("no network card leads to " + GroupListener::kGroup))
      return 1;
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

TEST_F(MulticastReceiverWithoutRights, SaysWhyBroadcastsAreNotHeardWhileTheGroupIs) {
  GroupListener group;
  boost::asio::io_context io;
  const boost::asio::ip::udp::socket another_program(
      io, {boost::asio::ip::make_address_v4("127.255.255.255"), group.port()});
  Heard heard;
  MulticastReceiver receiver("test", heard.handler());
  receiver.listen(at(group));
  EXPECT_EQ(receiver.error(), "");
  EXPECT_THAT(receiver.broadcast_error(),
              testing::AllOf(testing::StartsWith("127.255.255.255:"),
                             HasSubstr("another program uses this port without SO_REUSEADDR")));
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

TEST_P(MulticastReceiverTest, ManyStrangersDoNotDisplaceKnownSenders) {
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

TEST_P(MulticastReceiverTest, LosesNoBroadcastWhileRejoining) {
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

TEST_P(MulticastReceiverTest, SaysWhichCardIsNotThere) {
  GroupListener group;
  Heard heard;
  MulticastReceiver receiver("test", heard.handler());
  receiver.listen(at(group, "nocard0"));
  EXPECT_THAT(receiver.error(), HasSubstr("cannot listen to " + GroupListener::kGroup + ":"));
  EXPECT_THAT(receiver.error(), HasSubstr("no network card has the name or IPv4 address 'nocard0'"));
  EXPECT_THAT(receiver.broadcast_error(), HasSubstr("'nocard0'"));
  receiver.listen(at(group));
  EXPECT_EQ(receiver.error(), "");
  EXPECT_EQ(receiver.broadcast_error(), "");
  send(group, "heard");
  EXPECT_EQ(heard.next(), "heard");
}

/// A socket as a team's program opens it.
struct Client {
  const char* who;
  int family;
  bool binds_group;
  std::vector<int> options;
};
const std::vector<Client> kClients{
    {"Node.js, Python", AF_INET, false, {}},
    {"C++ that binds the group", AF_INET, true, {}},
    {"Java, Qt", AF_INET, false, {SO_REUSEADDR}},
    {"Java since version 9", AF_INET6, false, {SO_REUSEADDR, SO_REUSEPORT}},
    {"libraries that set SO_REUSEPORT only", AF_INET, false, {SO_REUSEPORT}},
    {"Node.js with IPv6", AF_INET6, false, {}},
};

/// The client's socket, with the group joined on the loopback interface. Throws std::system_error.
int open_client(const Client& client, int port) {
  const auto check = [](int result) {
    if (result < 0) throw std::system_error(errno, std::generic_category());
    return result;
  };
  const int fd = check(socket(client.family, SOCK_DGRAM | SOCK_NONBLOCK, 0));
  const int on = 1;
  for (const int option : client.options) check(setsockopt(fd, SOL_SOCKET, option, &on, sizeof on));
  const in_addr group{inet_addr(GroupListener::kGroup.c_str())};
  const auto port_in_order = htons(static_cast<std::uint16_t>(port));
  sockaddr_in v4{AF_INET, port_in_order, client.binds_group ? group : in_addr{}, {}};
  sockaddr_in6 v6{AF_INET6, port_in_order, 0, in6addr_any, 0};
  check(client.family == AF_INET ? bind(fd, reinterpret_cast<sockaddr*>(&v4), sizeof v4)
                                 : bind(fd, reinterpret_cast<sockaddr*>(&v6), sizeof v6));
  const ip_mreq membership{group, {htonl(INADDR_LOOPBACK)}};
  check(setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership));
  return fd;
}

std::string read_client(int fd) {
  pollfd wait{fd, POLLIN, 0};
  std::array<char, 64> text{};
  poll(&wait, 1, static_cast<int>(std::chrono::milliseconds(test::kPatience).count()));
  const ssize_t bytes = recv(fd, text.data(), text.size(), 0);
  return bytes < 0 ? "nothing" : std::string(text.data(), static_cast<std::size_t>(bytes));
}

TEST(MulticastReceiver, LetsClientsBindThePortBeforeAndAfterIt) {
  if (!set_raw_sockets(true)) GTEST_SKIP() << "not permitted: raw sockets";
  MulticastSettings settings;
  { settings = settings_for(GroupListener()); }  // a free port
  for (const bool client_is_first : {true, false}) {
    for (const Client& client : kClients) {
      SCOPED_TRACE(client.who + std::string(client_is_first ? ", first" : ", second"));
      int fd = client_is_first ? open_client(client, settings.port) : -1;
      Heard heard;
      MulticastReceiver receiver("test", heard.handler());
      receiver.listen(GroupAddress{GroupListener::kGroup, settings.port, "lo"});
      EXPECT_EQ(receiver.error(), "");
      EXPECT_EQ(receiver.broadcast_error(), "");
      if (fd < 0) fd = open_client(client, settings.port);
      MulticastSender sender(settings);
      send(sender, client.who);
      EXPECT_EQ(heard.next(), client.who);
      EXPECT_EQ(read_client(fd), client.who);
      close(fd);
    }
  }
}

TEST_F(MulticastReceiverWithoutRights, TellsWhichProgramIsInTheWay) {
  MulticastSettings settings;
  { settings = settings_for(GroupListener()); }
  const int fd = open_client(kClients[0], settings.port);
  Heard heard;
  MulticastReceiver receiver("test", heard.handler(), std::chrono::milliseconds(1));
  receiver.listen(GroupAddress{GroupListener::kGroup, settings.port, "lo"});
  EXPECT_THAT(receiver.error(), HasSubstr("another program uses this port without SO_REUSEADDR"));
  close(fd);
  EXPECT_TRUE(test::becomes([&] { return receiver.error().empty(); }));
}

/// Raw sockets receive what the kernel would not pass to others.
TEST(MulticastReceiver, IgnoresDamagedDatagrams) {
  const int status = without_network([] {
    if (!bring_loopback_up()) return kNoNamespaces;
    constexpr const char* kAddress = "239.255.77.77";  // 0xEFFF4D4D
    Heard heard;
    MulticastReceiver receiver("test", heard.handler());
    receiver.listen(GroupAddress{kAddress, 10006, "lo"});
    const int fd = socket(AF_INET, SOCK_RAW, IPPROTO_UDP);
    const in_addr card{htonl(INADDR_LOOPBACK)};
    setsockopt(fd, IPPROTO_IP, IP_MULTICAST_IF, &card, sizeof card);
    const sockaddr_in group{AF_INET, 0, {inet_addr(kAddress)}, {}};
    const auto put = [&](std::vector<unsigned char> bytes) {
      return sendto(fd, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&group),
                    sizeof group) > 0;
    };
    // Port 10006 is 0x2716. Too short, lengths that are too small and too large, a wrong sum, and two correct
    // ones.
    std::uint32_t sum = 0x7F00 + 0x0001 + 0xEFFF + 0x4D4D + IPPROTO_UDP + 9 + 1 + 0x2716 + 9 + ('f' << 8);
    sum = ~((sum & 0xFFFF) + (sum >> 16)) & 0xFFFF;
    const auto high = static_cast<unsigned char>(sum >> 8), low = static_cast<unsigned char>(sum);
    if (!put({0, 1}) || !put({0, 1, 0x27, 0x16}) || !put({0, 1, 0x27, 0x16, 0, 7, 0, 0, 'a'}) ||
        !put({0, 1, 0x27, 0x16, 0, 10, 0, 0, 'b'}) || !put({0, 1, 0x27, 0x16, 0, 9, 1, 2, 'e'}) ||
        !put({0, 1, 0x27, 0x16, 0, 9, 0, 0, 'c', 'd'}) || !put({0, 1, 0x27, 0x16, 0, 9, high, low, 'f'}))
      return kNoNamespaces;
    if (heard.next() != "c" || heard.last_sender().port() != 1) return 1;
    return heard.next() == "f" ? kPassed : 2;
  });
  if (status == kNoNamespaces) GTEST_SKIP() << "this system gives no network namespace";
  EXPECT_EQ(status, kPassed);
}

}  // namespace
}  // namespace sslv::multicast_receiver_test
