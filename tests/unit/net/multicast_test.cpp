// SPDX-License-Identifier: Apache-2.0
#include "net/multicast.h"

#include "base/error.h"
#include "support/becomes.h"
#include "support/group_listener.h"
#include "support/held_thread.h"
#include "support/own_network.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::multicast_test {
namespace {

using testing::HasSubstr;
using testing::Optional;
using testing::StartsWith;

TEST(Multicast, ReachesAListenerThroughAnInterfaceGivenByAddressOrName) {
  GroupListener listener;
  MulticastSettings settings = settings_for(listener);
  for (const char* interface : {"127.0.0.1", "lo"}) {
    settings.interface = interface;
    MulticastSender sender(settings);
    EXPECT_TRUE(send(sender, interface));
    EXPECT_THAT(listener.receive(), Optional(std::string(interface)));
    EXPECT_EQ(sender.status().packets_sent, 1U);
    EXPECT_EQ(sender.status().send_errors, 0U);
    EXPECT_EQ(sender.status().error, "");
  }
}

TEST(Multicast, SetsTheTtl) {
  GroupListener listener;
  MulticastSettings settings = settings_for(listener);
  settings.ttl = 7;
  MulticastSender sender(settings);
  EXPECT_TRUE(send(sender, "x"));
  EXPECT_TRUE(listener.receive());
  EXPECT_EQ(listener.last_ttl(), 7);
}

TEST(Multicast, TwoProcessesSendAndTwoProgramsListenOnOnePort) {
  GroupListener first;
  GroupListener second(first.port());
  // Fork before this process has threads: otherwise a sanitizer does not allow the child to start any.
  const int status = in_child([&] {
    MulticastSender there(settings_for(first));
    return send(there, "there") ? 0 : 1;
  });
  EXPECT_EQ(status, 0);
  MulticastSender here(settings_for(first));
  EXPECT_TRUE(send(here, "here"));
  for (GroupListener* listener : {&first, &second}) {
    EXPECT_THAT(listener->receive(), Optional(std::string("there")));
    EXPECT_THAT(listener->receive(), Optional(std::string("here")));
  }
}

TEST(Multicast, NewSettingsApplyToTheNextPacket) {
  GroupListener before, after;
  MulticastSender sender(settings_for(before));
  EXPECT_TRUE(send(sender, "1"));
  sender.configure(settings_for(after));
  EXPECT_TRUE(send(sender, "2"));
  EXPECT_THAT(before.receive(), Optional(std::string("1")));
  EXPECT_THAT(after.receive(), Optional(std::string("2")));
}

TEST(Multicast, RefusesInvalidGroupsAndContinues) {
  GroupListener listener;
  MulticastSender sender(settings_for(listener));
  for (const char* group : {"192.168.1.20", "240.0.0.1", "field.local", "", "ff02::1", "224.5.23.2 "}) {
    MulticastSettings wrong = settings_for(listener);
    wrong.group = group;
    try {
      sender.configure(wrong, "/network");
      ADD_FAILURE() << "'" << group << "' was accepted";
    } catch (const SettingsError& error) {
      EXPECT_EQ(std::string(error.what()),
                "/network/group: \"" + std::string(group) +
                    "\" is not allowed; expected an IPv4 multicast address, 224.0.0.0 .. "
                    "239.255.255.255, or a broadcast address, such as 255.255.255.255 or 10.0.0.255");
    }
  }
  EXPECT_TRUE(send(sender, "still"));
  EXPECT_THAT(listener.receive(), Optional(std::string("still")));
}

TEST(Multicast, RefusesInvalidBroadcastAddresses) {
  GroupListener listener;
  MulticastSettings settings = settings_for(listener);
  for (const char* good : {"", "255.255.255.255", "127.255.255.255", "10.0.0.3"}) {
    settings.broadcast = good;
    EXPECT_NO_THROW(check_multicast(settings, "/network/vision")) << good;
  }
  for (const char* bad :
       {"10.0.0.20", "0.0.0.0", "239.255.77.79", "243.0.0.3", "field.local", "ff02::1", " "}) {
    settings.broadcast = bad;
    EXPECT_THAT([&] { check_multicast(settings, "/network/vision"); },
                testing::ThrowsMessage<SettingsError>(AllOf(
                    StartsWith("/network/vision/broadcast: \"" + std::string(bad) + "\" is not allowed"),
                    HasSubstr("255.255.255.255 or 10.0.0.255, or nothing"))))
        << bad;
  }
  settings.group = settings.broadcast = "10.0.0.255";
  EXPECT_THROW(check_multicast(settings, ""), SettingsError) << "twice to the same";
}

TEST(Multicast, AnInvalidBroadcastAddressIsReportedAndMulticastContinues) {
  GroupListener listener;
  MulticastSettings settings = settings_for(listener);
  settings.broadcast = "203.0.113.255";
  MulticastSender sender(settings);
  EXPECT_TRUE(send(sender, "to the group"));
  EXPECT_THAT(listener.receive(), Optional(std::string("to the group")));
  EXPECT_EQ(sender.status().error,
            "no subnet of network card 127.0.0.1 has the broadcast address 203.0.113.255; there are "
            "255.255.255.255, 127.255.255.255");
  EXPECT_TRUE(sender.status().some_leave);
  settings.broadcast = "127.255.255.255";
  sender.configure(settings);
  EXPECT_EQ(sender.status().error, "");
  EXPECT_TRUE(send(sender, "both ways"));
  EXPECT_THAT(listener.receive(), Optional(std::string("both ways")));
  EXPECT_EQ(sender.status().packets_sent, 2U) << "one packet counts once, whichever ways it goes";
  settings.group = "203.0.113.255";
  settings.broadcast = "";
  sender.configure(settings);
  EXPECT_FALSE(send(sender, "nowhere"));
  EXPECT_FALSE(sender.status().some_leave);
}

TEST(Multicast, AMissingInterfaceIsReportedUntilItIsCorrected) {
  GroupListener listener;
  for (const char* interface : {"nocard0", "203.0.113.7"}) {
    MulticastSettings settings = settings_for(listener);
    settings.interface = interface;
    MulticastSender sender(settings);
    EXPECT_FALSE(send(sender, "lost"));
    EXPECT_FALSE(send(sender, "lost"));
    EXPECT_EQ(sender.status().packets_sent, 0U);
    EXPECT_EQ(sender.status().send_errors, 2U);
    EXPECT_THAT(sender.status().error,
                StartsWith("no network card has the name or IPv4 address '" + std::string(interface) +
                           "': set network/vision/interface"));
    EXPECT_THAT(sender.status().error, HasSubstr("lo (127.0.0.1)"));

    sender.configure(settings_for(listener));
    EXPECT_EQ(sender.status().error, "");
    EXPECT_TRUE(send(sender, "found"));
    EXPECT_THAT(listener.receive(), Optional(std::string("found")));
  }
}

TEST(Multicast, AFailedPacketIsCountedAndTheNextClearsTheError) {
  GroupListener listener;
  MulticastSender sender(settings_for(listener));
  EXPECT_FALSE(send(sender, std::string(70'000, 'x')));
  EXPECT_EQ(sender.status().send_errors, 1U);
  EXPECT_THAT(sender.status().error, AllOf(HasSubstr(listener.kGroup), HasSubstr("Message too long")));
  EXPECT_TRUE(send(sender, "fits"));
  EXPECT_EQ(sender.status().error, "");
}

TEST(Multicast, AnInvalidBroadcastAddressHidesNoMulticastError) {
  GroupListener listener;
  MulticastSettings settings = settings_for(listener);
  settings.broadcast = "203.0.113.255";
  MulticastSender sender(settings);
  EXPECT_FALSE(send(sender, std::string(70'000, 'x')));
  EXPECT_THAT(
      sender.status().error,
      AllOf(StartsWith("no subnet of network card 127.0.0.1 has the broadcast address 203.0.113.255"),
            HasSubstr("; cannot send to " + GroupListener::kGroup + ":"), HasSubstr("Message too long")));
}

TEST(Multicast, WithoutARouteTheErrorSaysToSetTheInterface) {
  const int status = without_network([] {
    MulticastSender sender(MulticastSettings{});
    if (send(sender, "x")) return 1;
    const std::string error = sender.status().error;
    if (error.find("cannot send to 224.5.23.2:10006: Network is unreachable") != 0) return 2;
    return error.find("set network/vision/interface") == std::string::npos ? 3 : kPassed;
  });
  if (status == kNoNamespaces) GTEST_SKIP() << "this system gives no network namespace";
  EXPECT_EQ(status, kPassed);
}

TEST(Multicast, ComesBackByItselfWhenTheInterfaceAppears) {
  const int status = without_network([] {
    MulticastSettings settings;
    settings.group = GroupListener::kGroup;
    settings.interface = "127.0.0.1";
    MulticastSender sender(settings);
    if (send(sender, "x") || sender.status().error.empty()) return 1;
    if (!bring_loopback_up()) return kNoNamespaces;
    GroupListener listener(static_cast<std::uint16_t>(settings.port));
    const bool is_back = test::becomes([&] {
      send(sender, "back");
      return listener.receive(20) == "back";
    });
    if (!is_back) return 3;
    return sender.status().error.empty() ? kPassed : 2;
  });
  if (status == kNoNamespaces) GTEST_SKIP() << "this system gives no network namespace";
  EXPECT_EQ(status, kPassed);
}

TEST(Multicast, AChangingBroadcastAddressDoesNotAffectMulticast) {
  const int status = without_network([] {
    if (!bring_loopback_up() || !set_loopback(SIOCSIFNETMASK, "255.255.255.0")) return kNoNamespaces;
    GroupListener listener;
    MulticastSettings settings = settings_for(listener);
    settings.broadcast = "127.255.255.255";  // the broadcast address of a /8
    MulticastSender sender(settings);
    if (!send(sender, "x") || !listener.receive() || sender.status().error.empty()) return 1;
    const std::uint16_t port = listener.last_sender_port();
    if (!set_loopback(SIOCSIFNETMASK, "255.0.0.0")) return kNoNamespaces;
    if (!test::becomes([&] { return sender.status().error.empty(); })) return 2;
    if (!send(sender, "x") || !listener.receive()) return 3;
    if (listener.last_sender_port() != port) return 4;  // otherwise the packet is from an earlier sender
    if (!set_loopback(SIOCSIFNETMASK, "255.255.255.0")) return kNoNamespaces;
    if (send(sender, "x") || !listener.receive()) return 5;
    const MulticastStatus now = sender.status();
    return now.packets_sent == 3 && now.send_errors == 1 && now.some_leave ? kPassed : 6;
  });
  if (status == kNoNamespaces) GTEST_SKIP() << "this system gives no network namespace";
  EXPECT_EQ(status, kPassed);
}

TEST(Multicast, TellsTheRateOfPackets) {
  GroupListener listener;
  MulticastSender sender(settings_for(listener));
  EXPECT_TRUE(test::becomes([&] {
    send(sender, "x");
    listener.receive();
    return sender.status().packets_per_s > 0;
  }));
}

TEST(Multicast, ThreadsSendWhileSettingsChange) {
  GroupListener listener;
  constexpr int kThreads = 4, kPackets = 500;
  MulticastSender sender(settings_for(listener));
  {
    std::vector<std::jthread> threads;
    threads.reserve(kThreads);
    for (int i = 0; i < kThreads; ++i) {
      threads.emplace_back([&] {
        for (int packet = 0; packet < kPackets; ++packet) send(sender, "x");
      });
    }
    for (int i = 0; i < 50; ++i) {
      sender.configure(settings_for(listener));
      EXPECT_EQ(sender.status().error.substr(0, 11), sender.status().error.empty() ? "" : "cannot send");
    }
  }
  EXPECT_EQ(sender.status().packets_sent + sender.status().send_errors, kThreads * kPackets);
  EXPECT_GT(sender.status().packets_sent, 0U);
}

/// True if the packet was sent, or was not sent only because the kernel's queue was full, which happens on a
/// busy computer.
bool goes(MulticastSender& sender, std::span<const std::byte> packet) {
  return sender.send(packet) || errno == EWOULDBLOCK;
}

TEST(Multicast, APausedStatusReaderDelaysNoPacket) {
  GroupListener listener;
  MulticastSender sender(settings_for(listener));
  const std::array<std::byte, 4> packet{};
  expect_never_waits([&] { (void)sender.status(); }, [&] { EXPECT_TRUE(goes(sender, packet)); });
}

TEST(Multicast, APausedSettingsChangeDelaysNoPacket) {
  GroupListener before, after;
  MulticastSender sender(settings_for(before));
  const std::array<std::byte, 4> packet{};
  const std::array settings{settings_for(before), settings_for(after)};
  int changes = 0;
  expect_never_waits([&] { sender.configure(settings[static_cast<std::size_t>(++changes % 2)]); },
                     [&] { EXPECT_TRUE(goes(sender, packet)); }, 300);
}

TEST(Multicast, NoPacketIsLostWhileSettingsChange) {
  GroupListener listener;
  MulticastSender sender(settings_for(listener));
  std::atomic<bool> ending{false};
  const std::array<std::byte, 4> packet{};
  std::jthread camera([&] {
    while (!ending) EXPECT_TRUE(goes(sender, packet));
  });
  for (int i = 0; i < 200; ++i) sender.configure(settings_for(listener));
  ending = true;
}

}  // namespace
}  // namespace sslv::multicast_test
