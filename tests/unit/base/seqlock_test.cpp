// SPDX-License-Identifier: Apache-2.0
#include "base/seqlock.h"

#include "support/held_thread.h"

#include <array>
#include <atomic>
#include <optional>
#include <thread>

#include <gtest/gtest.h>

namespace sslv::seqlock_test {
namespace {

struct Figures {
  std::array<int, 7> counts{};
  std::optional<double> share = 0.5;
};

TEST(Seqlock, HoldsADefaultAndThenWhatWasStored) {
  Seqlock<Figures> value;
  EXPECT_EQ(value.load().share, 0.5);
  Figures figures;
  figures.counts = {1, 2, 3, 4, 5, 6, 7};
  figures.share.reset();
  value.store(figures);
  EXPECT_EQ(value.load().counts, figures.counts);
  EXPECT_FALSE(value.load().share);
}

TEST(Seqlock, ReadersSeeAWholeValue) {
  Seqlock<Figures> value;
  std::atomic<bool> ending{false};
  std::thread writer([&] {
    Figures figures;
    for (int i = 1; !ending; ++i) {
      figures.counts.fill(i);
      value.store(figures);
    }
  });
  int last = 0;
  for (int reads = 0; reads < 20'000; ++reads) {
    const Figures seen = value.load();
    for (const int count : seen.counts) ASSERT_EQ(count, seen.counts[0]);
    ASSERT_GE(seen.counts[0], last);
    last = seen.counts[0];
  }
  ending = true;
  writer.join();
}

TEST(Seqlock, APausedReaderDelaysNoWriter) {
  Seqlock<Figures> value;
  expect_never_waits([&] { (void)value.load(); }, [&] { value.store(Figures{}); });
}

TEST(Seqlock, APausedWriterDelaysNoTryLoad) {
  Seqlock<Figures> value;
  expect_never_waits([&] { value.store(Figures{}); }, [&] { (void)value.try_load(); });
}

}  // namespace
}  // namespace sslv::seqlock_test
