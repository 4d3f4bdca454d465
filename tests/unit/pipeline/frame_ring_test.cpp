// SPDX-License-Identifier: Apache-2.0
#include "pipeline/frame_ring.h"

#include "pipeline/latest_frame.h"
#include "support/patience.h"

#include <array>
#include <atomic>
#include <set>
#include <thread>

#include <gtest/gtest.h>

namespace sslv::frame_ring_test {
namespace {

/// A driver that counts the buffers it has lent.
struct Driver {
  std::atomic<int> lent{0};

  Image lend() {
    lent.fetch_add(1);
    return {{}, this, nullptr, [](void* owner, void*) noexcept {
              static_cast<Driver*>(owner)->lent.fetch_sub(1);
            }};
  }
};

TEST(FrameRing, GivesTheImageBackThatNobodyHoldsAnyMore) {
  Driver driver;
  FrameRing ring(2);
  FrameRef first = ring.acquire();
  first->image = driver.lend();
  FrameRef second = first;
  first.reset();
  EXPECT_EQ(ring.give_back(), 1U);
  EXPECT_EQ(driver.lent, 1);
  second.reset();
  EXPECT_EQ(driver.lent, 1) << "not by who lets go, which may be a viewer's thread";
  EXPECT_EQ(ring.give_back(), 0U);
  EXPECT_EQ(driver.lent, 0);
  second.reset();
  EXPECT_EQ(ring.give_back(), 0U);
  EXPECT_EQ(driver.lent, 0);
}

TEST(FrameRing, GivesTheImageBackOfAFrameThatIsUsedAgain) {
  Driver driver;
  FrameRing ring(1);
  FrameRef frame = ring.acquire();
  frame->image = driver.lend();
  frame.reset();
  frame = ring.acquire();
  EXPECT_EQ(driver.lent, 0);
  frame->image = driver.lend();
  EXPECT_EQ(driver.lent, 1);
}

TEST(FrameRing, AHeldFrameIsNotReused) {
  FrameRing ring(3);
  const FrameRef held = ring.acquire();
  for (int i = 0; i < 10; ++i) {
    const FrameRef other = ring.acquire();
    ASSERT_TRUE(other);
    ASSERT_NE(&*other, &*held);
  }
}

TEST(FrameRing, IsEmptyWhenAllAreHeld) {
  FrameRing ring(2);
  FrameRef first = ring.acquire();
  const FrameRef second = ring.acquire();
  EXPECT_NE(&*first, &*second);
  EXPECT_FALSE(ring.acquire());
  Frame* freed = &*first;
  first.reset();
  EXPECT_EQ(&*ring.acquire(), freed);
}

TEST(FrameRing, ListsKeepTheirCapacity) {
  FrameRing ring(1);
  FrameRef frame = ring.acquire();
  frame->runs.runs.resize(1000);
  frame.reset();
  EXPECT_EQ(ring.acquire()->runs.runs.capacity(), 1000U);
}

TEST(FrameRef, CopiesMovesAndAssignmentsCountOnce) {
  Driver driver;
  FrameRing ring(2);
  FrameRef a = ring.acquire();
  a->image = driver.lend();
  FrameRef b = a;
  FrameRef c = std::move(b);
  EXPECT_FALSE(b);  // NOLINT(bugprone-use-after-move): a moved-from FrameRef is empty
  const FrameRef& same = a;
  a = same;
  EXPECT_TRUE(a);
  a = FrameRef();
  ring.give_back();
  EXPECT_EQ(driver.lent, 1);
  b = ring.acquire();
  c = b;  // releases the last reference to the first frame
  ring.give_back();
  EXPECT_EQ(driver.lent, 0);
  EXPECT_EQ(&*b, &*c);
}

// One thread fills frames while two read the newest: no frame may change while it is read.
TEST(FrameRing, ViewersNeverSeeAFrameBeingReused) {
  Driver driver;
  FrameRing ring(5);
  LatestFrame latest(ring);
  std::atomic<int> changed{0};
  std::array<std::thread, 2> viewers;
  for (auto& viewer : viewers) {
    viewer = std::thread([&] {
      std::uint64_t version = 0;
      while (const auto seen = latest.wait_newer(version, test::kPatience)) {
        version = seen->version;
        const Frame& frame = *seen->value;
        for (const Robot& robot : frame.robots.robots)
          changed += robot.id != static_cast<int>(frame.info.number);
      }
    });
  }
  int processed = 0;
  while (processed < 5000) {
    FrameRef frame = ring.acquire();
    if (!frame) {
      std::this_thread::yield();
      continue;
    }
    frame->image = driver.lend();
    frame->info.number = static_cast<std::uint32_t>(++processed);
    frame->robots.robots.assign(8, Robot{});
    for (Robot& robot : frame->robots.robots) robot.id = processed;
    latest.put(std::move(frame));
  }
  latest.close();
  for (auto& viewer : viewers) viewer.join();
  ring.give_back();
  EXPECT_EQ(changed, 0);
  EXPECT_EQ(driver.lent, 0);
}

}  // namespace
}  // namespace sslv::frame_ring_test
