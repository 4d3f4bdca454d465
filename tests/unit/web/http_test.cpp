// SPDX-License-Identifier: Apache-2.0
#include "web/http.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sslv {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;

TEST(HttpTest, SplitsAndDecodesATarget) {
  Request request;
  ASSERT_TRUE(parse_target("/api/a%20b/c+d?width=64&name=x%3Dy+z&flag&width=1", request));
  EXPECT_THAT(request.path, ElementsAre("api", "a b", "c+d"));
  EXPECT_THAT(request.query, ElementsAre(Pair("flag", ""), Pair("name", "x=y z"), Pair("width", "64")));
}

TEST(HttpTest, TheRootIsAnEmptyPath) {
  Request request;
  ASSERT_TRUE(parse_target("/?x=1", request));
  EXPECT_TRUE(request.path.empty());
}

TEST(HttpTest, RefusesTargetsThatLeadElsewhere) {
  for (const char* target : {"", "*", "example.org:80", "http://example.org/", "/..", "/a/../b", "/%2e%2e/b",
                             "/./a", "/a%2fb", "/a%00", "/%", "/%4", "/%zz", "/%+1", "/?a=%g0"}) {
    Request request;
    EXPECT_FALSE(parse_target(target, request)) << target;
  }
}

TEST(HttpTest, AnOriginMustBeTheHost) {
  Request request;
  request.headers = {{"host", "field-pc:8090"}};
  EXPECT_TRUE(is_same_origin(request));
  request.headers["origin"] = "http://Field-PC:8090";
  EXPECT_TRUE(is_same_origin(request));
  for (const char* origin : {"http://field-pc:8091", "http://evil.example",
                             "http://field-pc:8090.evil.example", "null", "", "http://"}) {
    request.headers["origin"] = origin;
    EXPECT_FALSE(is_same_origin(request)) << origin;
  }
  request.headers = {{"origin", "http://"}};
  EXPECT_FALSE(is_same_origin(request));
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
