// SPDX-License-Identifier: Apache-2.0
#include "base/workers.h"

#include <array>
#include <atomic>

#include <gtest/gtest.h>

namespace sslv {
namespace {

TEST(Workers, DoEveryPartOnce) {
  for (const int threads : {0, 1, 3}) {
    Workers workers(threads);
    EXPECT_EQ(workers.threads(), threads);
    for (const int parts : {0, 1, 2, 7, 40}) {
      for (int job = 0; job < 100; ++job) {
        std::array<std::atomic<int>, 40> done{};
        std::array<int, 40> plain{};  // seen by the caller without a lock
        workers.run(parts, [&](int i) {
          ++done[static_cast<std::size_t>(i)];
          plain[static_cast<std::size_t>(i)] = i + 1;
        });
        for (int i = 0; i < 40; ++i) {
          ASSERT_EQ(done[static_cast<std::size_t>(i)], i < parts ? 1 : 0);
          ASSERT_EQ(plain[static_cast<std::size_t>(i)], i < parts ? i + 1 : 0);
        }
      }
    }
  }
}

}  // namespace
}  // namespace sslv
