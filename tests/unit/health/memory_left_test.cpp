// SPDX-License-Identifier: Apache-2.0
#include "health/memory_left.h"

#include "support/temporary_folder.h"

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

namespace sslv::memory_left_test {
namespace {

/// A computer with 4 GB left, whose service is in /system.slice/x.service.
class MemoryLeftTest : public testing::Test {
 protected:
  MemoryLeftTest() {
    write("proc/meminfo", "MemTotal: 8000000 kB\nMemAvailable: 4000000 kB\n");
    write("proc/self/cgroup", "0::/system.slice/x.service\n");
  }
  void write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder_.path() / name).parent_path());
    folder_.write(name, text);
  }
  std::uint64_t left() const { return memory_left_bytes(folder_.path()); }

  test::TemporaryFolder folder_;
  const std::string group_ = "sys/fs/cgroup/system.slice/x.service/";
};

TEST_F(MemoryLeftTest, IsWhatTheComputerHas) {
  EXPECT_EQ(left(), 4'096'000'000U);
  write(group_ + "memory.high", "max\n");
  EXPECT_EQ(left(), 4'096'000'000U);
}

TEST_F(MemoryLeftTest, IsLimitedByTheGroupAndThoseAboveIt) {
  write(group_ + "memory.high", "2000000000\n");
  write(group_ + "memory.current", "700000000\n");
  write(group_ + "memory.stat", "anon 400000000\nfile 300000000\n");
  EXPECT_EQ(left(), 1'600'000'000U) << "what was read of files can be given back";
  write(group_ + "memory.stat", "anon 400000000\nfile 300000000\nkernel 5\nshmem 250000000\n");
  EXPECT_EQ(left(), 1'350'000'000U) << "memory that is a file cannot";
  write(group_ + "memory.stat", "anon 400000000\nfile 300000000\n");
  write("sys/fs/cgroup/system.slice/memory.max", "1000000000\n");
  write("sys/fs/cgroup/system.slice/memory.current", "900000000\n");
  EXPECT_EQ(left(), 100'000'000U);
  write("sys/fs/cgroup/system.slice/memory.current", "1900000000\n");
  EXPECT_EQ(left(), 0U);
}

TEST_F(MemoryLeftTest, IsLimitedByAContainer) {
  write("proc/self/cgroup", "0::/\n");
  write("sys/fs/cgroup/memory.max", "2000000000\n");
  write("sys/fs/cgroup/memory.current", "500000000\n");
  EXPECT_EQ(left(), 1'500'000'000U);
}

TEST_F(MemoryLeftTest, IsNotLimitedWhereNothingIsKnown) {
  EXPECT_GT(memory_left_bytes(folder_.path() / "nothing"), std::uint64_t{1} << 50U);
}

}  // namespace
}  // namespace sslv::memory_left_test
