// SPDX-License-Identifier: Apache-2.0
#include "base/base64.h"

#include <random>

#include <gmock/gmock.h>

namespace sslv::base64_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes bytes_of(std::string_view text) {
  return {text.begin(), text.end()};
}

TEST(Base64, IsThatOfTheRfc) {
  const std::pair<const char*, const char*> pairs[] = {{"", ""},
                                                       {"f", "Zg=="},
                                                       {"fo", "Zm8="},
                                                       {"foo", "Zm9v"},
                                                       {"foob", "Zm9vYg=="},
                                                       {"fooba", "Zm9vYmE="},
                                                       {"foobar", "Zm9vYmFy"}};
  for (const auto& [plain, coded] : pairs) {
    EXPECT_EQ(to_base64(bytes_of(plain)), coded);
    EXPECT_EQ(from_base64(coded), bytes_of(plain));
  }
}

TEST(Base64, EveryByteComesBack) {
  std::mt19937 random(1);
  for (std::size_t size = 0; size < 300; ++size) {
    Bytes bytes(size);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    ASSERT_EQ(from_base64(to_base64(bytes)), bytes);
  }
}

TEST(Base64, WhiteSpaceMayBeAnywhere) {
  EXPECT_EQ(from_base64("\n\t Zm9v\r\nYm Fy\n"), bytes_of("foobar"));
}

TEST(Base64, RefusesTruncatedAndInvalidText) {
  for (const char* bad : {"Z", "Zm9", "Zg=", "Zg===", "Z===", "Zg==Zg==", "Zm9v!", "Zm=9", "====", "Zm9vä"}) {
    EXPECT_FALSE(from_base64(bad)) << bad;
  }
}

}  // namespace
}  // namespace sslv::base64_test
