// SPDX-License-Identifier: Apache-2.0
#include "base/workers.h"

#include <array>
#include <atomic>
#include <system_error>
#include <thread>

#include <gtest/gtest.h>

namespace sslv::workers_test {
namespace {

TEST(Workers, DoEveryPartOnce) {
  for (const int threads : {0, 1, 3}) {
    Workers workers(threads);
    EXPECT_EQ(workers.threads(), threads);
    for (const int parts : {0, 1, 2, 7, 40}) {
      for (int job = 0; job < 100; ++job) {
        std::array<std::atomic<int>, 40> done{};
        std::array<int, 40> plain{};  // the caller must see the writes without a lock
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

TEST(Workers, ContinueWithFewerThreads) {
  for (const int given : {0, 1, 2}) {
    int asked = 0;
    Workers workers(3, [&](auto serve) {
      if (asked++ == given)
        throw std::system_error(std::make_error_code(std::errc::resource_unavailable_try_again));
      return std::jthread(std::move(serve));
    });
    EXPECT_EQ(workers.threads(), given);
    std::atomic<int> done{0};
    workers.run(40, [&](int) { ++done; });
    EXPECT_EQ(done, 40);
  }
}

}  // namespace
}  // namespace sslv::workers_test
