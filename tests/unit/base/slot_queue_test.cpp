// SPDX-License-Identifier: Apache-2.0
#include "base/slot_queue.h"

#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace sslv::slot_queue_test {
namespace {

TEST(SlotQueue, GivesValuesInTheirOrderAndTakesNoMoreThanItHasRoomFor) {
  SlotQueue<int, 3> queue;
  EXPECT_EQ(queue.to_read(), nullptr);
  for (int i = 1; i <= 3; ++i) {
    ASSERT_NE(queue.to_write(), nullptr);
    *queue.to_write() = i;
    queue.write();
  }
  EXPECT_EQ(queue.to_write(), nullptr);
  EXPECT_EQ(*queue.to_read(), 1);
  EXPECT_EQ(*queue.to_read(), 1) << "until it was read";
  queue.read();
  ASSERT_NE(queue.to_write(), nullptr);
  *queue.to_write() = 4;
  queue.write();
  for (int i = 2; i <= 4; ++i) {
    EXPECT_EQ(*queue.to_read(), i);
    queue.read();
  }
  EXPECT_EQ(queue.to_read(), nullptr);
}

TEST(SlotQueue, SlotsKeepTheirMemory) {
  SlotQueue<std::vector<int>, 2> queue;
  queue.prepare([](std::vector<int>& slot) { slot.reserve(100); });
  for (int i = 0; i < 5; ++i) {
    EXPECT_GE(queue.to_write()->capacity(), 100U);
    queue.write();
    queue.read();
  }
}

TEST(SlotQueue, AThreadReadsWhatAnotherWrites) {
  SlotQueue<std::vector<int>, 4> queue;
  constexpr int kCount = 20'000;
  std::thread writer([&] {
    for (int i = 0; i < kCount;) {
      std::vector<int>* const slot = queue.to_write();
      if (!slot) {
        std::this_thread::yield();
        continue;
      }
      slot->assign({i, -i});
      queue.write();
      ++i;
    }
  });
  for (int i = 0; i < kCount;) {
    const std::vector<int>* const value = queue.to_read();
    if (!value) {
      std::this_thread::yield();
      continue;
    }
    ASSERT_EQ(*value, (std::vector<int>{i, -i}));
    queue.read();
    ++i;
  }
  writer.join();
}

}  // namespace
}  // namespace sslv::slot_queue_test
