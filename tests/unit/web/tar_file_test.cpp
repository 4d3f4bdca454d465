// SPDX-License-Identifier: Apache-2.0
#include "web/tar_file.h"

#include <stdexcept>

#include <gmock/gmock.h>

namespace sslv {
namespace {

using ::testing::HasSubstr;

constexpr std::size_t kPlenty = 1024 * 1024;
const std::vector<TarEntry> kFiles{
    {"a.txt", "one"}, {"folder/b.bin", std::string(100'000, '\0')}, {"empty", ""}};

std::string refusal(const std::string& bytes, std::size_t max_bytes = kPlenty) {
  try {
    read_tar_gz(bytes, max_bytes);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "none";
}

TEST(TarFile, IsReadAsItWasWritten) {
  const auto read = read_tar_gz(tar_gz(kFiles, 1'700'000'000), kPlenty);
  ASSERT_EQ(read.size(), kFiles.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].name, kFiles[i].name);
    EXPECT_EQ(read[i].content, kFiles[i].content);
  }
}

TEST(TarFile, EveryCutIsFound) {
  const std::string bytes = tar_gz(kFiles, 1'700'000'000);
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_NE(refusal(bytes.substr(0, size)), "none") << size;
}

TEST(TarFile, WhatIsNoneIsRefused) {
  EXPECT_NE(refusal("no archive"), "none");
  EXPECT_NE(refusal(std::string(100'000, '\0')), "none");
}

TEST(TarFile, IsNotUnpackedBeyondItsLimit) {
  const std::string bytes = tar_gz({{"large", std::string(8 * kPlenty, 'x')}}, 0);
  EXPECT_LT(bytes.size(), kPlenty);
  EXPECT_EQ(refusal(bytes), "unpacked, it is larger than 1 MiB");
}

}  // namespace
}  // namespace sslv
