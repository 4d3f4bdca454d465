// SPDX-License-Identifier: Apache-2.0
#include "base/json.h"

#include <gtest/gtest.h>

namespace sslv {
namespace {

TEST(JsonText, IsOneLineOrIndented) {
  const Json value{{"b", 1}, {"a", {0.5, "x"}}};
  EXPECT_EQ(json_text(value), R"({"b":1,"a":[0.5,"x"]})");
  EXPECT_EQ(json_text({{"a", 1}}, 2), "{\n  \"a\": 1\n}");
  EXPECT_EQ(parse_own_json(json_text(value)), value);
}

TEST(JsonText, ReplacesWhatIsNotUtf8) {
  EXPECT_EQ(json_text(Json("gr\xfcn")), "\"gr\xef\xbf\xbdn\"");
  EXPECT_TRUE(is_utf8(Json("gr\xc3\xbcn")));
  EXPECT_FALSE(is_utf8(Json("gr\xfcn")));
  EXPECT_FALSE(is_utf8(Json{{"list", {1, {{"gr\xfcn", 2}}}}})) << "keys too";
}

TEST(JsonReason, NamesNoExceptionOfTheLibrary) {
  try {
    parse_own_json("[1,");
    FAIL();
  } catch (const Json::exception& error) {
    EXPECT_EQ(reason_of(error).rfind("parse error at line 1, column 4: ", 0), 0U) << reason_of(error);
  }
}

}  // namespace
}  // namespace sslv
