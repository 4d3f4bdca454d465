// SPDX-License-Identifier: Apache-2.0
#include "web/route.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sslv::route_test {
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

TEST(Route, JsonThatTakesMuchMemoryIsRefused) {
  const auto list_of = [](const std::string& what, std::size_t bytes) {
    std::string text = "[" + what;
    while (text.size() < bytes) text += "," + what;
    return text + "]";
  };
  // Everything that fits into a request. A few bytes of JSON can take a hundred bytes of memory.
  for (const char* what : {"0", "\"\"", "[]", "{}", "{\"\":0}"})
    EXPECT_NO_THROW(parse_json(list_of(what, 300'000)));
  EXPECT_NO_THROW(parse_json(list_of("\"" + std::string(1000, 'x') + "\"", kMaxBodyBytes)));
  for (const char* what : {"0", "\"\"", "[]", "{}", "{\"\":0}"}) {
    try {
      parse_json(list_of(what, 3'000'000));
      FAIL() << what;
    } catch (const HttpError& error) {
      EXPECT_STREQ(error.what(), "JSON that takes more than 16 MiB of memory") << what;
    }
  }
}

TEST(Route, TextThatIsNotUtf8IsReplaced) {
  EXPECT_THAT(to_text({{"error", "a\xff"}}), HasSubstr("a\xEF\xBF\xBD"));
}

}  // namespace
}  // namespace sslv::route_test
