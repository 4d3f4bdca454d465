// SPDX-License-Identifier: Apache-2.0
#include "ctl/settings_edit.h"

#include "config/config.h"

#include <gmock/gmock.h>

namespace sslv::settings_edit_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
using testing::ThrowsMessage;

TEST(SettingsEdit, AWordIsJsonOrElseAText) {
  EXPECT_EQ(json_or_text("-3.5"), Json(-3.5));
  EXPECT_EQ(json_or_text("[0, 1]"), Json::parse("[0, 1]"));
  EXPECT_EQ(json_or_text("null"), Json(nullptr));
  EXPECT_EQ(json_or_text("\"1\""), Json("1"));
  EXPECT_EQ(json_or_text("192.168.10.20"), Json("192.168.10.20"));
  EXPECT_EQ(json_or_text("Field 2"), Json("Field 2"));
  EXPECT_EQ(json_or_text(""), Json(""));
}

TEST(SettingsEdit, ReplacesWhatIsThereAndAddsWhatIsNot) {
  const Json tree = Json::parse(R"({"list": [{"a": 1}, 2], "a/b": 3})");
  const Json patch =
      patch_that_sets(tree, {{"/list/1", "5"}, {"/list/-", "x"}, {"/list/0/b", "7"}, {"/a~1b", "8"}});
  EXPECT_EQ(tree.patch(patch), Json::parse(R"({"list": [{"a": 1, "b": 7}, 5, "x"], "a/b": 8})")) << patch;
  EXPECT_THAT(
      [&] {
        patch_that_sets(tree, {{"list", "1"}});
      },
      ThrowsMessage<std::runtime_error>(HasSubstr("\"list\" is not a place in the settings")));
}

TEST(SettingsEdit, ListsTheExistingKeysForAnUnknownOne) {
  const Json tree = Json::parse(R"({"field": {"length": 1, "width": 2}, "cameras": [1, 2]})");
  EXPECT_EQ(value_at(tree, "/field/width"), 2);
  EXPECT_EQ(value_at(tree, ""), tree);
  EXPECT_THAT([&] { value_at(tree, "/field/wide/x"); },
              ThrowsMessage<std::runtime_error>("/field/wide/x: no such setting; /field has length, width"));
  EXPECT_THAT([&] { value_at(tree, "/cameras/2"); },
              ThrowsMessage<std::runtime_error>("/cameras/2: no such setting; /cameras has a list of 2"));
  EXPECT_THAT([&] { value_at(tree, "/sit"); },
              ThrowsMessage<std::runtime_error>("/sit: no such setting; the tree has field, cameras"));
}

TEST(SettingsEdit, TellsWhatChanged) {
  const Json before{{"revision", 6}, {"settings", {{"site", "A"}, {"ids", {1, 2}}}}};
  const Json after{{"revision", 7}, {"settings", {{"site", "B"}, {"ids", {1}}}}};
  EXPECT_EQ(edit_text(edit_between(before, after)),
            "/site: \"A\" -> \"B\"\n/ids/1: 2 -> nothing\nsaved, revision 7\n");
  EXPECT_EQ(edit_text(edit_between(after, after)), "nothing changes\nsaved, revision 7\n");
  EXPECT_EQ(edit_text({{"changes", Json::array()}}), "nothing changes\nonly checked, nothing was saved\n");
}

TEST(SettingsSchema, IsATableOfWhatCanBeSet) {
  const Json schema = settings_schema();
  EXPECT_EQ(
      schema_text(schema, "/field/field_length"),
      "key                  type     range          unit  help\n"
      "/field/field_length  integer  100 .. 100000  mm    distance between the centres of the goal lines\n");
  EXPECT_THAT(schema_text(schema, "/teams"),
              AllOf(HasSubstr("/teams/yellow/ids "), HasSubstr("array of integer  0 .. 255"),
                    Not(HasSubstr("/field"))));
  // An entry of a list, and a key that only one of several backends has.
  EXPECT_THAT(schema_text(schema, "/cameras/3/source/exposure_us"),
              AllOf(HasSubstr("/cameras/*/source/exposure_us  number|null"), HasSubstr(" us "),
                    HasSubstr("aravis: ")));
  EXPECT_THAT(schema_text(schema, "/cameras/0/source"), HasSubstr("simulator: "));
  EXPECT_THAT(schema_text(schema, ""),
              AllOf(StartsWith("key "), HasSubstr("\n/site "), HasSubstr("\n/ball_models "),
                    HasSubstr("\n/cameras/*/colors/classes/*/hue_deg ")));
  EXPECT_THAT([&] { schema_text(schema, "/field/length"); },
              ThrowsMessage<std::runtime_error>(HasSubstr("/field/length: no such setting")));
}

}  // namespace
}  // namespace sslv::settings_edit_test
