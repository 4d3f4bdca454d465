// SPDX-License-Identifier: Apache-2.0
#include "base/handover.h"

#include <atomic>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace sslv::handover_test {
namespace {

TEST(Handover, TheUserSeesTheNewestValue) {
  Handover<int> value(1);
  EXPECT_EQ(*value.use(), 1);
  value.store(2);
  EXPECT_EQ(*value.use(), 2);
  EXPECT_EQ(*value.load(), 2);
}

TEST(Handover, AValueInUseIsFreedByTheNextReaderAfterItsUserLeft) {
  auto first = std::make_shared<int>(1);
  const std::weak_ptr<int> seen = first;
  Handover<std::shared_ptr<int>> value(std::move(first));
  {
    const auto use = value.use();
    value.store(std::make_shared<int>(2));
    value.store(std::make_shared<int>(3));
    EXPECT_EQ(**value.load(), 3);
    EXPECT_EQ(**use, 1);
  }
  EXPECT_FALSE(seen.expired()) << "the user frees nothing";
  (void)value.load();
  EXPECT_TRUE(seen.expired());
}

TEST(Handover, AValueThatNobodyUsesGoesAtOnce) {
  auto first = std::make_shared<int>(1);
  const std::weak_ptr<int> seen = first;
  Handover<std::shared_ptr<int>> value(std::move(first));
  value.store(nullptr);
  EXPECT_TRUE(seen.expired());
}

TEST(Handover, AReaderHoldsAVersionForAsLongAsItLikes) {
  Handover<int> value(1);
  const auto held = value.load();
  for (int i = 2; i < 10; ++i) value.store(i);
  EXPECT_EQ(*held, 1);
}

/// Both members are equal until the pair is destroyed.
struct Pair {
  explicit Pair(int value) : a(value), b(value) {}
  ~Pair() { a = -1, b = -2; }
  Pair(const Pair&) = default;
  Pair& operator=(const Pair&) = delete;
  int a, b;
};

TEST(Handover, WritersNeverFreeWhatIsInUse) {
  Handover<Pair> value(Pair(0));
  std::atomic<bool> ending{false};
  std::vector<std::thread> others;
  for (int w = 0; w < 2; ++w) {
    others.emplace_back([&] {
      for (int i = 0; !ending; ++i) {
        value.store(Pair(i));
        const auto now = value.load();
        ASSERT_EQ(now->a, now->b);
      }
    });
  }
  for (int i = 0; i < 50'000; ++i) {
    const auto use = value.use();
    ASSERT_EQ(use->a, use->b);
  }
  ending = true;
  for (auto& other : others) other.join();
}

}  // namespace
}  // namespace sslv::handover_test
