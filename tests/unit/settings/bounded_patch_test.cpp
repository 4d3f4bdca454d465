// SPDX-License-Identifier: Apache-2.0
#include "settings/bounded_patch.h"

#include "base/error.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace sslv {
namespace {

using ::testing::HasSubstr;

Json op(const char* name, const std::string& path, const Json& value) {
  return {{"op", name}, {"path", path}, {"value", value}};
}
Json copy(const std::string& from, const std::string& path) {
  return {{"op", "copy"}, {"from", from}, {"path", path}};
}

std::string refusal_of(const Json& document, const Json& patch, const PatchLimits& limits = {}) {
  try {
    apply_patch(document, patch, limits);
    return "not refused";
  } catch (const SettingsError& error) {
    return error.what();
  }
}

TEST(BoundedPatch, DoesWhatThePatchSays) {
  const Json before{{"a", 1}, {"list", {1, 2, 3}}, {"x", {{"y", "text"}}}};
  const Json patch{op("replace", "/a", 2),   op("add", "/list/1", 9),
                   op("test", "/list/1", 9), {{"op", "remove"}, {"path", "/list/0"}},
                   copy("/x", "/z"),         {{"op", "move"}, {"from", "/x/y"}, {"path", "/moved"}}};
  EXPECT_EQ(apply_patch(before, patch), before.patch(patch));
  EXPECT_EQ(apply_patch(before, Json::array()), before);
  EXPECT_EQ(apply_patch(before, Json::array({op("replace", "", 7)})), 7) << "the whole of it";
}

TEST(BoundedPatch, SaysWhatDoesNotFit) {
  for (const Json& patch :
       {Json(7), Json::object(), Json::array({1}), Json::array({{{"op", "add"}}}),
        Json::array({op("jump", "/a", 1)}), Json::array({op("replace", "/none", 1)}),
        Json::array({op("test", "/a", 3)}), Json::array({copy("/none", "/b")}),
        Json::array({op("add", "no pointer", 1)}), Json::array({{{"op", 1}, {"path", 2}}})}) {
    EXPECT_THAT(refusal_of({{"a", 1}}, patch), HasSubstr("not a JSON Patch that fits")) << patch;
  }
}

TEST(BoundedPatch, CopiesThatDoubleEndBeforeMemoryDoes) {
  // 900 bytes, and more than 10 GB were it applied.
  Json patch = Json::array({op("add", "/x", Json::array())});
  for (int i = 0; i < 40; ++i) patch.push_back(copy("", "/x/-"));
  Json settings{{"cameras", std::string(2000, 'c')}};
  EXPECT_THAT(refusal_of(settings, patch), HasSubstr("is not allowed"));
}

TEST(BoundedPatch, CopiesThatNestEndBeforeTheStackDoes) {
  Json patch = Json::array({op("add", "/x", Json::object())});
  for (int i = 0; i < 1900; ++i) patch.push_back(copy("/x", "/x/x"));
  EXPECT_THAT(refusal_of(Json::object(), patch), HasSubstr("nested deeper than 64"));
  Json deep = 1;
  for (int i = 0; i < 70; ++i) deep = Json{{"x", std::move(deep)}};
  EXPECT_THAT(refusal_of(Json::object(), Json::array({op("add", "/deep", deep)})),
              HasSubstr("nested deeper"));
}

TEST(BoundedPatch, ManyOperationsAreBounded) {
  const Json settings{{"big", Json(std::vector<int>(100'000, 1))}};
  EXPECT_THAT(refusal_of(settings, Json(std::vector<Json>(30'000, op("test", "/big/0", 1)))),
              HasSubstr("more operations than 20000"));
  // Each moves all of a long list, or compares it.
  EXPECT_THAT(refusal_of(settings, Json(std::vector<Json>(20'000, op("add", "/big/0", 1)))),
              HasSubstr("more to do than"));
  EXPECT_THAT(refusal_of(settings, Json(std::vector<Json>(
                                       20'000, {{"op", "move"}, {"from", "/big"}, {"path", "/big"}}))),
              HasSubstr("more to do than"));
}

TEST(BoundedPatch, WhatIsReplacedAgainAndAgainDoesNotGrow) {
  const std::string text(1000, 't');
  const PatchLimits limits{.operations = 1000, .size = 5000, .work = 1'000'000, .depth = 8};
  const Json patch(std::vector<Json>(50, op("replace", "/a", text)));
  EXPECT_EQ(apply_patch({{"a", 1}}, patch, limits).at("a"), text);
}

}  // namespace
}  // namespace sslv
