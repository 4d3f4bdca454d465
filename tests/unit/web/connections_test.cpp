// SPDX-License-Identifier: Apache-2.0
#include "web/connections.h"

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::connections_test {
namespace {

using testing::HasSubstr;

class ConnectionsTest : public testing::Test {
 protected:
  static constexpr int kMax = 64;

  /// A connection that closes when asked to. Null if it was refused.
  struct Connection {
    std::shared_ptr<Connections::Seat> seat;
    bool closed = false;
  };
  std::shared_ptr<Connection> connect(const std::string& address, bool is_trusted = false) {
    auto connection = std::make_shared<Connection>();
    connection->seat = connections_.admit(address, is_trusted, problem_);
    if (!connection->seat) return nullptr;
    connection->seat->closes_by([weak = std::weak_ptr(connection)] {
      if (const auto self = weak.lock()) self->closed = true;
    });
    return connection;
  }
  std::vector<std::shared_ptr<Connection>> connect_many(int count, const std::string& network = "198.51.") {
    std::vector<std::shared_ptr<Connection>> out;
    for (int i = 0; i < count; ++i)
      out.push_back(connect(network + std::to_string(i / 250) + "." + std::to_string(i % 250)));
    return out;
  }
  static int closed(const std::vector<std::shared_ptr<Connection>>& connections) {
    int count = 0;
    for (const auto& one : connections) count += one && one->closed ? 1 : 0;
    return count;
  }

  double now_s_ = 100;
  std::atomic<std::uint64_t> unsent_ = 0;
  Connections connections_{kMax, [this] { return now_s_; }, unsent_};
  std::string problem_;
};

TEST_F(ConnectionsTest, HalfRequestsOfManyAddressesKeepNobodyOut) {
  const auto attackers = connect_many(1000);
  EXPECT_EQ(closed(attackers), 1000 - (kMax - kMax / 8));
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(attackers[i]->closed, i < 1000 - (kMax - kMax / 8)) << i;
  const auto monitor = connect("192.0.2.1");
  ASSERT_TRUE(monitor);
  connect_many(20, "203.0.");
  EXPECT_FALSE(monitor->closed) << "its request has time to come";
  monitor->seat->works();
  connect_many(1000, "203.0.");
  EXPECT_FALSE(monitor->closed) << "it is being answered";
}

TEST_F(ConnectionsTest, TheAddressWithMostLosesFirst) {
  const auto browser = connect("192.0.2.1");  // idle for longest
  std::vector<std::shared_ptr<Connection>> attackers;
  for (int i = 0; i < 1000; ++i) attackers.push_back(connect("198.51.100." + std::to_string(i % 4)));
  EXPECT_FALSE(browser->closed);
  EXPECT_EQ(closed(attackers), 1000 - (kMax - kMax / 8 - 1));
}

TEST_F(ConnectionsTest, OneAddressHasNoMoreThanHalf) {
  std::vector<std::shared_ptr<Connection>> attackers;
  for (int i = 0; i < 100; ++i) attackers.push_back(connect("2001:db8::" + std::to_string(i)));
  EXPECT_EQ(closed(attackers), 100 - kMax / 2) << "an IPv6 network is one";
  for (const auto& one : attackers) one->seat->works();
  EXPECT_FALSE(connect("2001:db8::bad"));
  EXPECT_EQ(problem_, "too many connections from your address");
  EXPECT_TRUE(connect("2001:db8:1::1"));
  EXPECT_TRUE(connect("2001:db8::1", true)) << "an admin's in the same network";
}

TEST_F(ConnectionsTest, StrangersNeverGetAllConnections) {
  const auto busy = connect_many(kMax);  // the newest of them stay open
  for (const auto& one : busy) one->seat->works();
  EXPECT_FALSE(connect("192.0.2.1"));
  EXPECT_EQ(problem_, "too many connections; try again later");
  std::vector<std::shared_ptr<Connection>> own;
  for (int i = 0; i < 3 * kMax; ++i) {
    own.push_back(connect("127.0.0.1", true));
    ASSERT_TRUE(own.back()) << i;
  }
  own.back()->seat->works();
  EXPECT_EQ(closed(own), 3 * kMax - kMax / 8) << "its own that wait go";
}

TEST_F(ConnectionsTest, AClientThatReadsTooSlowlyIsClosed) {
  const auto slow = connect_many(kMax - kMax / 8);
  for (const auto& one : slow) one->seat->sends();
  EXPECT_FALSE(connect("192.0.2.1")) << "it may be a moment before an answer has left";
  now_s_ += Connections::kSendPatience_s + 1;
  EXPECT_TRUE(connect("192.0.2.1"));
  EXPECT_TRUE(slow.front()->closed);
  EXPECT_EQ(closed(slow), 1);
}

TEST_F(ConnectionsTest, SlowReadersKeepNobodyOut) {
  std::vector<std::shared_ptr<Connection>> attackers, newcomers;
  for (int i = 0; i < kMax - kMax / 8; ++i)
    attackers.push_back(connect("198.51.100." + std::to_string(i % 2)));
  for (int round = 0; round < 5; ++round) {
    for (const auto& one : attackers) {
      one->seat->works();
      one->seat->sends();
    }
    now_s_ += Connections::kSendPatience_s - 1;
    newcomers.push_back(connect("192.0.2." + std::to_string(round)));
    ASSERT_TRUE(newcomers.back()) << round;
    newcomers.back()->seat->works();
  }
  EXPECT_EQ(closed(attackers), 5);
  EXPECT_EQ(closed(newcomers), 0);
}

TEST_F(ConnectionsTest, ViewersStayButLeaveRoom) {
  std::vector<std::shared_ptr<Connection>> viewers;
  int staying = 0;
  for (int i = 0; i < 200; ++i) {
    viewers.push_back(connect("198.51.100." + std::to_string(i % 2)));
    staying += viewers.back()->seat->stays(false, problem_) ? 1 : 0;
  }
  EXPECT_EQ(staying, kMax / 2);
  EXPECT_EQ(problem_, "too many viewers from your address");
  EXPECT_FALSE(connect("203.0.113.1")->seat->stays(false, problem_));
  EXPECT_THAT(problem_, HasSubstr("too many viewers; try again later"));
  EXPECT_TRUE(connect("127.0.0.1", true)->seat->stays(true, problem_));
  EXPECT_TRUE(connect("203.0.113.1")->seat->stays(true, problem_)) << "the admin's since then";
  const auto monitor = connect("192.0.2.1");
  ASSERT_TRUE(monitor);
  viewers.clear();
  EXPECT_TRUE(connect("198.51.100.0")->seat->stays(false, problem_)) << "others have gone";
}

TEST_F(ConnectionsTest, ClosedConnectionsMakeRoom) {
  for (int round = 0; round < 10; ++round) {
    auto busy = connect_many(kMax - kMax / 8);
    for (const auto& one : busy) {
      ASSERT_TRUE(one) << round;
      one->seat->works();
    }
    EXPECT_FALSE(connect("192.0.2.1"));
    busy.pop_back();
    EXPECT_TRUE(connect("192.0.2.1"));
  }
}

constexpr std::size_t kMiB = 1024 * 1024;

TEST_F(ConnectionsTest, UnsentBytesOfAnAddressAreLimited) {
  std::vector<std::shared_ptr<Connection>> greedy;
  std::size_t held = 0;
  for (int i = 0; i < 20; ++i) {
    greedy.push_back(connect("198.51.100.1"));
    if (greedy.back()->seat->holds(3 * kMiB, problem_)) held += 3 * kMiB;
  }
  EXPECT_LE(held, Connections::kMaxUnsentBytesOfAddress);
  EXPECT_GE(held, Connections::kMaxUnsentBytesOfAddress / 2);
  EXPECT_EQ(problem_, "too much data is waiting for slow clients; try again in a moment");
  EXPECT_EQ(unsent_, 20 - held / (3 * kMiB));
  EXPECT_TRUE(greedy.back()->seat->holds(Connections::kAlwaysSentBytes, problem_)) << "whether all is well";
  EXPECT_TRUE(connect("192.0.2.1")->seat->holds(3 * kMiB, problem_)) << "another address";
  greedy.front()->seat->holds(0, problem_);
  EXPECT_TRUE(greedy.back()->seat->holds(kMiB, problem_)) << "it was taken";
}

TEST_F(ConnectionsTest, OneAnswerIsSentHoweverLargeItIs) {
  const auto one = connect("192.0.2.1");
  EXPECT_TRUE(one->seat->holds(100 * kMiB, problem_));
  EXPECT_FALSE(connect("192.0.2.1")->seat->holds(kMiB, problem_));
  EXPECT_TRUE(one->seat->holds(50 * kMiB, problem_)) << "some of it was taken";
  const auto small = connect("192.0.2.2"), another = connect("192.0.2.2");
  EXPECT_TRUE(small->seat->holds(Connections::kAlwaysSentBytes, problem_));
  one->seat->holds(0, problem_);
  EXPECT_TRUE(another->seat->holds(100 * kMiB, problem_)) << "beside a small one";
}

TEST_F(ConnectionsTest, UnsentBytesOfAllAreLimited) {
  std::size_t held = 0;
  std::vector<std::shared_ptr<Connection>> all = connect_many(kMax - kMax / 8);
  for (const auto& one : all) held += one->seat->holds(2 * kMiB, problem_) ? 2 * kMiB : 0;
  EXPECT_EQ(held, Connections::kMaxUnsentBytes);
  const auto own = connect("127.0.0.1", true);
  EXPECT_TRUE(own->seat->holds(10 * kMiB, problem_)) << "strangers take no room of this computer's own";
  EXPECT_TRUE(own->seat->holds(20 * kMiB, problem_));
  EXPECT_FALSE(connect("127.0.0.1", true)->seat->holds(10 * kMiB, problem_)) << "which has an end, too";
}

TEST_F(ConnectionsTest, AClientThatReadsNothingIsClosedForOthers) {
  const auto slow = connect_many(static_cast<int>(Connections::kMaxUnsentBytes / (2 * kMiB)));
  for (const auto& one : slow) ASSERT_TRUE(one->seat->holds(2 * kMiB, problem_));
  const auto other = connect("192.0.2.1");
  EXPECT_FALSE(other->seat->holds(kMiB, problem_)) << "it may be a moment before an answer has left";
  now_s_ += Connections::kSendPatience_s - 1;
  for (const auto& one : slow) {
    if (one != slow[3]) one->seat->makes_progress();
  }
  now_s_ += 2;
  EXPECT_TRUE(other->seat->holds(kMiB, problem_));
  EXPECT_TRUE(slow[3]->closed);
  EXPECT_EQ(closed(slow), 1);
  EXPECT_EQ(unsent_, 2U);
}

TEST_F(ConnectionsTest, TheSlowestOfAGreedyAddressIsClosedSooner) {
  const auto greedy = connect("198.51.100.1");
  ASSERT_TRUE(greedy->seat->holds(7 * kMiB, problem_));
  greedy->seat->sends();
  const auto next = connect("198.51.100.1");
  EXPECT_FALSE(next->seat->holds(2 * kMiB, problem_));
  now_s_ += 2 * Connections::kSendPatienceWithMany_s;
  greedy->seat->makes_progress();
  EXPECT_FALSE(next->seat->holds(2 * kMiB, problem_)) << "it is slow, but takes its answer";
  now_s_ += 2 * Connections::kSendPatienceWithMany_s;
  EXPECT_TRUE(next->seat->holds(2 * kMiB, problem_));
  EXPECT_TRUE(greedy->closed);
}

TEST_F(ConnectionsTest, SlowViewersOfAnAddressStayAndSkipImages) {
  std::vector<std::shared_ptr<Connection>> viewers;
  for (int i = 0; i < 8; ++i) {
    viewers.push_back(connect("198.51.100.1"));
    ASSERT_TRUE(viewers.back()->seat->stays(false, problem_));
    ASSERT_TRUE(viewers.back()->seat->holds(kMiB, problem_));
  }
  for (int second = 0; second < 60; ++second) {
    now_s_ += 1;
    for (const auto& one : viewers) {
      if (one != viewers[3] || second % 4 == 0) one->seat->makes_progress();
    }
    EXPECT_FALSE(viewers[5]->seat->holds(2 * kMiB, problem_)) << "skipped";
  }
  EXPECT_EQ(closed(viewers), 0);
  now_s_ += Connections::kSendPatience_s + 1;
  EXPECT_TRUE(viewers[5]->seat->holds(2 * kMiB, problem_));
  EXPECT_EQ(closed(viewers), 1) << "one that takes nothing";
}

TEST_F(ConnectionsTest, ARequestInProgressIsNotClosedAsSlow) {
  const auto busy = connect("198.51.100.1");
  ASSERT_TRUE(busy->seat->holds(7 * kMiB, problem_));
  busy->seat->works();
  now_s_ += 2 * Connections::kSendPatience_s;
  const auto next = connect("198.51.100.1");
  EXPECT_FALSE(next->seat->holds(2 * kMiB, problem_));
  busy->seat->sends();
  EXPECT_FALSE(next->seat->holds(2 * kMiB, problem_)) << "its answer has just begun";
  EXPECT_FALSE(busy->closed);
}

TEST_F(ConnectionsTest, UnsentBytesCountForTheClientsCurrentShare) {
  const auto one = connect("192.0.2.1");
  ASSERT_TRUE(one->seat->holds(7 * kMiB, problem_));
  ASSERT_TRUE(one->seat->stays(true, problem_));
  const auto stranger = connect("192.0.2.1");
  EXPECT_TRUE(stranger->seat->holds(7 * kMiB, problem_)) << "the other one is an admin's now";
  const auto own = connect("127.0.0.1", true);
  EXPECT_FALSE(own->seat->holds(18 * kMiB, problem_));
  one->seat->holds(6 * kMiB, problem_);
  EXPECT_TRUE(own->seat->holds(18 * kMiB, problem_));
}

}  // namespace
}  // namespace sslv::connections_test
