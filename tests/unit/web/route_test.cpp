// SPDX-License-Identifier: Apache-2.0
#include "web/route.h"

#include <fmt/format.h>
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
  const auto with_keys = [](int count) {
    std::string text = "{\"a\": {";
    for (int i = 0; i < count; ++i) text += fmt::format("{}\"{}\": {{\"x\": 1}}", i == 0 ? "" : ", ", i);
    return text + "}, \"b\": {\"c\": 1}}";
  };
  EXPECT_NO_THROW(parse_json(with_keys(1000)));
  EXPECT_THROW(parse_json(with_keys(1001)), HttpError);
  try {
    parse_json("[\"" + std::string(500'000, 'x'));
  } catch (const HttpError& error) {
    EXPECT_LT(std::string(error.what()).size(), 400U);
  }
}

TEST(Route, TextThatIsNotUtf8IsReplaced) {
  EXPECT_THAT(to_text({{"error", "a\xff"}}), HasSubstr("a\xEF\xBF\xBD"));
}

}  // namespace
}  // namespace sslv
