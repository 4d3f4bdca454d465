// SPDX-License-Identifier: Apache-2.0
#include "base/plain_text.h"

#include "base/error.h"
#include "base/json.h"

#include <string>

#include <gmock/gmock.h>

namespace sslv::plain_text_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

const std::string kNotPlain[] = {
    std::string("\0", 1),
    "\n",
    "\t",
    "\x1b",
    "\x7f",
    "\u0085",
    "\u009b",
    "\u061c",
    "\u200e",
    "\u200f",
    "\u202a",
    "\u202e",
    "\u2028",
    "\u2029",
    "\u2066",
    "\u2069",
};

TEST(PlainText, IsAnyWritingInOneLine) {
  for (const char* text :
       {"", " ", "Field 1", "Größe", "日本", "שלום", "نقش‌جهان", "CMμs", "👩‍🔧", "a\\b"})
    EXPECT_TRUE(is_plain_text(text)) << text;
}

TEST(PlainText, HasNoControlOrDirectionCharacters) {
  for (const std::string& bad : kNotPlain) {
    EXPECT_FALSE(is_plain_text("a" + bad + "b")) << escaped_text(bad);
    EXPECT_TRUE(is_plain_text(escaped_text("a" + bad + "b"))) << escaped_text(bad);
    EXPECT_EQ(plain_part("a" + bad + "b"), "ab") << escaped_text(bad);
  }
  for (const char* broken : {"\xff", "\xc3", "\xc0\x80", "\xed\xa0\x80", "a\x80z"}) {
    EXPECT_FALSE(is_plain_text(broken));
    EXPECT_TRUE(is_plain_text(escaped_text(broken)));
  }
}

TEST(PlainText, EscapesNameTheCharacter) {
  EXPECT_EQ(escaped_text(std::string_view("lo\0;\x1b[31m\u009b\u202e\xffü\n", 18)),
            "lo\\u0000;\\u001b[31m\\u009b\\u202e\\xffü\\u000a");
  EXPECT_EQ(escaped_lines("a\nb\x1b\n"), "a\nb\\u001b\n");
}

TEST(PlainText, EscapedJsonIsTheSameJson) {
  Json json;
  for (const std::string& bad : kNotPlain) json["key" + bad] = "a" + bad + "\\" + bad;
  EXPECT_EQ(Json::parse(escaped_text(json.dump())), json);
}

TEST(PlainText, IsRefusedInOneClearLine) {
  EXPECT_NO_THROW(check_plain_text("Field", "/site"));
  const auto refusal = [](const std::string& text) -> std::string {
    try {
      check_plain_text(text, "/site");
    } catch (const SettingsError& error) {
      return error.what();
    }
    return "not refused";
  };
  EXPECT_EQ(refusal("a\u202eb"),
            "/site: \"a\\u202eb\" is not allowed; expected a text without control characters and without "
            "characters that change the direction of writing");
  EXPECT_THAT(refusal(std::string(59, 'x') + "ü\n" + std::string(500'000, 'x')),
              AllOf(StartsWith("/site: \"xxx"), HasSubstr("\"... is not allowed")));
  EXPECT_TRUE(is_plain_text(refusal(std::string(59, 'x') + "ü\n")));
}

}  // namespace
}  // namespace sslv::plain_text_test
