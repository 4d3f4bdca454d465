// SPDX-License-Identifier: Apache-2.0
#include "base/snapshot.h"

#include <array>
#include <atomic>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace sslv::snapshot_test {
namespace {

TEST(Snapshot, IsNullBeforeTheFirstStore) {
  Snapshot<int> value;
  EXPECT_EQ(value.load(), nullptr);
  value.store(1);
  EXPECT_EQ(*value.load(), 1);
}

TEST(Snapshot, AReaderKeepsItsVersion) {
  Snapshot<int> value(1);
  const auto held = value.load();
  value.store(2);
  EXPECT_EQ(*held, 1);
  EXPECT_EQ(*value.load(), 2);
}

TEST(Snapshot, AnOldVersionGoesWithItsLastReader) {
  Snapshot<std::shared_ptr<int>> value(std::make_shared<int>(1));
  const std::weak_ptr<int> old = *value.load();
  auto held = value.load();
  value.store(std::shared_ptr<int>());
  EXPECT_FALSE(old.expired());
  held.reset();
  EXPECT_TRUE(old.expired());
}

TEST(Snapshot, ReadersNeverSeeHalfOfAChange) {
  using Wide = std::array<int, 64>;
  Snapshot<Wide> value(Wide{});
  std::atomic<bool> stop{false};
  std::atomic<int> torn{0}, backwards{0};
  std::vector<std::thread> readers;
  for (int r = 0; r < 2; ++r) {
    readers.emplace_back([&] {
      int last = 0;
      do {
        const auto seen = value.load();
        for (const int element : *seen) torn += element != seen->front();
        backwards += seen->front() < last;
        last = seen->front();
      } while (!stop);
    });
  }
  Wide next{};
  for (int i = 1; i <= 5000; ++i) {
    next.fill(i);
    value.store(next);
  }
  stop = true;
  for (auto& reader : readers) reader.join();
  EXPECT_EQ(torn, 0);
  EXPECT_EQ(backwards, 0);
  EXPECT_EQ(value.load()->back(), 5000);
}

}  // namespace
}  // namespace sslv::snapshot_test
