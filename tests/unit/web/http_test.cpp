// SPDX-License-Identifier: Apache-2.0
#include "web/http.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sslv {
namespace {

using testing::HasSubstr;

TEST(HttpTest, AnOriginMustBeTheHost) {
  EXPECT_TRUE(is_same_origin("", "field-pc:8090"));
  EXPECT_TRUE(is_same_origin("http://Field-PC:8090", "field-pc:8090"));
  for (const char* origin : {"http://field-pc:8091", "http://evil.example",
                             "http://field-pc:8090.evil.example", "null", "http://", "field-pc:8090"}) {
    EXPECT_FALSE(is_same_origin(origin, "field-pc:8090")) << origin;
  }
  EXPECT_TRUE(is_same_origin("https://field-pc:8090", "field-pc:8090")) << "a proxy with TLS";
  for (const char* origin : {"x://field-pc:8090", "file://field-pc:8090", "chrome-extension://field-pc:8090",
                             "://field-pc:8090", "nonsense http://field-pc:8090"}) {
    EXPECT_FALSE(is_same_origin(origin, "field-pc:8090")) << origin;
  }
  EXPECT_FALSE(is_same_origin("http://", ""));
}

TEST(HttpTest, AHostIsANameOrAnAddressAndNothingElse) {
  const std::vector<std::string> names{"Panel.Example"};
  for (const char* host :
       {"", "localhost", "LOCALHOST:8090", "127.0.0.1", "192.0.2.1:8090", "[::1]", "[::1]:8090",
        "[2001:DB8::1]:80", "panel.example", "PANEL.example:8090", "panel.example:"}) {
    EXPECT_TRUE(is_own_name(host, names)) << host;
  }
  for (const std::string& host :
       {std::string("[::1]evil.com"), std::string("[::1].evil.com:80"), std::string("[::1"),
        std::string("[]"), std::string("[127.0.0.1]"), std::string("[::1%evil.com]"),
        std::string("[::1]:evil"), std::string("::1"), std::string("127.0.0.1:80:evil.com"),
        std::string("127.0.0.1:evil.com"), std::string("127.0.0.1\0.evil.com", 19),
        std::string("127.0.0.1 evil.com"), std::string("evil.com"), std::string("localhost:123456"),
        std::string("localhost@evil.com"), std::string(":8090"), std::string("localhost/"),
        std::string("localh\xc3\xb6st")}) {
    EXPECT_FALSE(is_own_name(host, names)) << host;
  }
}

TEST(HttpTest, WholeNumbersAreReadStrictly) {
  EXPECT_EQ(read_whole_number("width", "640", 1, 1000), 640);
  for (const char* text : {"", "0", "1001", "64x", " 64", "6.4", "99999999999999999999"}) {
    EXPECT_THROW(read_whole_number("width", text, 1, 1000), HttpError) << text;
  }
}

TEST(HttpTest, JsonThatIsTooDeepIsRefused) {
  const auto nested = [](std::size_t depth) { return std::string(depth, '[') + std::string(depth, ']'); };
  EXPECT_NO_THROW(parse_json(nested(60)));
  EXPECT_THROW(parse_json(nested(500'000)), HttpError);
  EXPECT_THROW(parse_json(std::string(500'000, '[')), HttpError);
  EXPECT_THROW(parse_json("[1,"), HttpError);
  EXPECT_THROW(parse_json(""), HttpError);
}

TEST(HttpTest, TextThatIsNotUtf8IsReplaced) {
  EXPECT_THAT(to_text({{"error", "a\xff"}}), HasSubstr("a\xEF\xBF\xBD"));
}

}  // namespace
}  // namespace sslv
