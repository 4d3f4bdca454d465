// SPDX-License-Identifier: Apache-2.0
#include "health/computer.h"

#include <filesystem>

#include <gtest/gtest.h>

namespace sslv::computer_test {
namespace {

TEST(CoreTicks, AreThoseOfTheCoresWithoutTheirSum) {
  const auto cores = read_core_ticks(
      "cpu  300 0 30 3000 0 0 0 0 0 0\n"
      "cpu0 100 10 20 800 50 5 5 10 77 0\n"
      "cpu11 1 0 0 9 0 0 0 0 0 0\n"
      "intr 1 2 3\n");
  ASSERT_EQ(cores.size(), 2u);
  EXPECT_EQ(cores[0].all, 1000u);
  EXPECT_EQ(cores[0].busy, 150u);
  EXPECT_EQ(cores[1].all, 10u);
}

TEST(CoreTicks, SayHowBusyACoreWasBetweenTwoReadings) {
  const auto percent = busy_percent({{100, 1000}, {0, 0}, {50, 60}}, {{125, 1100}, {0, 0}, {40, 160}});
  ASSERT_EQ(percent.size(), 3u);
  EXPECT_DOUBLE_EQ(percent[0], 25);
  EXPECT_DOUBLE_EQ(percent[1], 0);
  EXPECT_DOUBLE_EQ(percent[2], 0);
  EXPECT_TRUE(busy_percent({}, {{1, 2}}).empty());
}

TEST(Computer, ReadsTheOneItRunsOn) {
  Computer computer(std::filesystem::temp_directory_path() / "not" / "there" / "yet");
  const ComputerFigures first = computer.read();
  EXPECT_TRUE(first.cpu_percent.empty());
  EXPECT_FALSE(first.host.empty());
  EXPECT_GT(first.uptime_s, 0);
  EXPECT_GT(first.memory_bytes, first.memory_available_bytes);
  EXPECT_GT(first.memory_available_bytes, 0u);
  ASSERT_TRUE(first.disk);
  EXPECT_EQ(first.disk->folder, std::filesystem::temp_directory_path());
  EXPECT_GT(first.disk->total_bytes, first.disk->free_bytes);
  EXPECT_GE(first.process.threads, 1);
  EXPECT_GE(first.process.descriptors, 3);
  EXPECT_GT(first.process.rss_bytes, 1'000'000u);
  const ComputerFigures second = computer.read();
  EXPECT_GE(second.cpu_percent.size(), 1u);
  for (const double percent : second.cpu_percent) EXPECT_TRUE(percent >= 0 && percent <= 100) << percent;
}

}  // namespace
}  // namespace sslv::computer_test
