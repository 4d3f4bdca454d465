// SPDX-License-Identifier: Apache-2.0
#include "vision/label.h"

#include "base/error.h"

#include <gmock/gmock.h>

namespace sslv::label_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(LabelSet, HasTheBuiltInOnes) {
  const LabelSet& labels = LabelSet::built_in();
  EXPECT_EQ(labels.all().size(), label::kCount);
  EXPECT_EQ(labels.find("pink"), label::kPink);
  EXPECT_EQ(labels.name(label::kField), "field");
  EXPECT_EQ(labels.color(label::kPink), label::kDisplayColors[label::kPink]);
  EXPECT_FALSE(labels.find("purple"));
}

TEST(LabelSet, HasOwnOnesAndANameForEveryValue) {
  const LabelSet labels({{31, "gelb 2", "#FFee01"}, {12, "purple", "#8020c0"}}, "/own_labels");
  EXPECT_EQ(labels.find("purple"), 12);
  EXPECT_EQ(labels.color(12), (Rgb{0x80, 0x20, 0xc0}));
  EXPECT_EQ(labels.color(31), (Rgb{0xff, 0xee, 1}));
  EXPECT_EQ(labels.name(31), "gelb 2");
  EXPECT_EQ(labels.name(17), "label 17");
  EXPECT_FALSE(labels.has(17));
  EXPECT_EQ(labels.all()[10].name, "purple") << "in the order of their values";
  EXPECT_THAT(labels.names(), HasSubstr("black, purple, gelb 2"));
}

std::string error_of(const std::vector<OwnLabel>& own) {
  try {
    const LabelSet labels(own, "/own_labels");
  } catch (const SettingsError& error) {
    return error.what();
  }
  return "no error";
}

TEST(LabelSet, RefusesInvalidLabels) {
  EXPECT_THAT(error_of({{9, "purple"}}), AllOf(HasSubstr("/own_labels/0/value: 9"), HasSubstr("10 .. 31")));
  EXPECT_THAT(error_of({{10, "a"}, {10, "b"}}), HasSubstr("/own_labels/1/value: 10 is \"a\" already"));
  EXPECT_THAT(error_of({{10, "a"}, {11, "a"}}), HasSubstr("/own_labels/1/name: \"a\" is taken"));
  EXPECT_THAT(error_of({{10, "pink"}}), HasSubstr("\"pink\" is taken"));
  EXPECT_THAT(error_of({{10, "a", "blue"}}), HasSubstr("/own_labels/0/color: \"blue\""));
  EXPECT_THAT(error_of({{10, "a", "#12345g"}}), HasSubstr("expected #rrggbb"));
  for (const char* name : {"", " a", "a ", "a\nb", "\x7f", "a\xC2\x85", "a\u202e", "a\xff", "label 11"}) {
    EXPECT_THAT(error_of({{10, name}}), HasSubstr("/own_labels/0/name")) << name;
  }
  EXPECT_THAT(error_of({{10, std::string(33, 'a')}}), HasSubstr("1 .. 32 bytes"));
  EXPECT_EQ(error_of({{10, "label of ours"}, {11, "vert é"}}), "no error");
}

}  // namespace
}  // namespace sslv::label_test
