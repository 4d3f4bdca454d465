// SPDX-License-Identifier: Apache-2.0
#include "web/tar_file.h"

#include <stdexcept>

#include <gmock/gmock.h>
#include <zlib.h>

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

/// The reader takes packed ones only.
std::vector<TarEntry> read_tar(const std::string& tar) {
  std::string packed(::compressBound(tar.size()) + 64, '\0');
  z_stream stream{};
  EXPECT_EQ(::deflateInit2(&stream, 1, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY), Z_OK);
  std::string from = tar;
  stream.next_in = reinterpret_cast<Bytef*>(from.data());
  stream.avail_in = static_cast<uInt>(from.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  EXPECT_EQ(::deflate(&stream, Z_FINISH), Z_STREAM_END);
  packed.resize(stream.total_out);
  ::deflateEnd(&stream);
  return read_tar_gz(packed, kPlenty);
}

TEST(TarFile, IsReadAsItWasWritten) {
  const auto read = read_tar_gz(tar_gz(kFiles, 1'700'000'000), kPlenty);
  ASSERT_EQ(read.size(), kFiles.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].name, kFiles[i].name);
    EXPECT_EQ(read[i].content, kFiles[i].content);
  }
}

TEST(TarFile, GoesAroundAFileThatNobodyHolds) {
  for (const std::string& content :
       {std::string(), std::string("x"), std::string(512, 'y'), std::string(100'001, 'z')}) {
    const std::string name = "folder/" + std::string(200, 'n');
    const TarAround around = tar_around(kFiles, name, content.size(), 1'700'000'000);
    const auto read = read_tar(around.before + content + around.after);
    ASSERT_EQ(read.size(), kFiles.size() + 1);
    EXPECT_EQ(read.front().content, kFiles.front().content);
    EXPECT_EQ(read.back().name, name);
    EXPECT_EQ(read.back().content, content);
  }
  // Above what the old format's twelve digits can say.
  EXPECT_LT(tar_around(kFiles, "large", 1'000'000'000'000, 0).before.size(), 200'000U);
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
