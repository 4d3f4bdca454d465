// SPDX-License-Identifier: Apache-2.0
#include "web/route.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sslv {
namespace {

using testing::HasSubstr;

TEST(Route, WholeNumbersAreReadStrictly) {
  EXPECT_EQ(read_whole_number("width", "640", 1, 1000), 640);
  for (const char* text : {"", "0", "1001", "64x", " 64", "6.4", "99999999999999999999"}) {
    EXPECT_THROW(read_whole_number("width", text, 1, 1000), HttpError) << text;
  }
}

TEST(Route, JsonThatIsTooDeepIsRefused) {
  const auto nested = [](std::size_t depth) { return std::string(depth, '[') + std::string(depth, ']'); };
  EXPECT_NO_THROW(parse_json(nested(60)));
  EXPECT_THROW(parse_json(nested(500'000)), HttpError);
  EXPECT_THROW(parse_json(std::string(500'000, '[')), HttpError);
  EXPECT_THROW(parse_json("[1,"), HttpError);
  EXPECT_THROW(parse_json(""), HttpError);
}

TEST(Route, TextThatIsNotUtf8IsReplaced) {
  EXPECT_THAT(to_text({{"error", "a\xff"}}), HasSubstr("a\xEF\xBF\xBD"));
}

}  // namespace
}  // namespace sslv
