// SPDX-License-Identifier: Apache-2.0
#include "settings/bounded_patch.h"

#include "base/error.h"

#include <iterator>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::bounded_patch_test {
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
  for (const Json& patch : {Json(7), Json::object(), Json::array({1})})
    EXPECT_THAT(refusal_of({{"a", 1}}, patch), HasSubstr("expected a list of objects")) << patch;
}

TEST(BoundedPatch, CopiesThatDoubleEndBeforeMemoryDoes) {
  // A patch of 900 bytes that would grow to more than 10 GB.
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
  // Each operation moves or compares all of a long list.
  EXPECT_THAT(refusal_of(settings, Json(std::vector<Json>(20'000, op("add", "/big/0", 1)))),
              HasSubstr("more work than"));
  EXPECT_THAT(refusal_of(settings, Json(std::vector<Json>(
                                       20'000, {{"op", "move"}, {"from", "/big"}, {"path", "/big"}}))),
              HasSubstr("more work than"));
}

TEST(BoundedPatch, RepeatedReplacementsDoNotGrow) {
  const std::string text(1000, 't');
  const PatchLimits limits{.operations = 1000, .size = 5000, .work = 1'000'000, .depth = 8};
  const Json patch(std::vector<Json>(50, op("replace", "/a", text)));
  EXPECT_EQ(apply_patch({{"a", 1}}, patch, limits).at("a"), text);
}

TEST(BoundedPatch, KeyLookupsAreBounded) {
  // Objects keep the order of their keys, so a lookup compares all earlier keys.
  Json wide = Json::object();
  for (int i = 0; i < 5000; ++i) wide.push_back({"key" + std::to_string(i), 0});
  const Json test = op("test", "/wide/key4999", 0);
  EXPECT_EQ(refusal_of({{"wide", wide}}, Json(std::vector<Json>(1000, test))), "not refused");
  EXPECT_THAT(refusal_of({{"wide", wide}}, Json(std::vector<Json>(20'000, test))),
              HasSubstr("more work than"));
  Json growing = Json::array();
  for (int i = 0; i < 20'000; ++i) growing.push_back(op("add", "/x" + std::to_string(i), 0));
  EXPECT_THAT(refusal_of(Json::object(), growing), HasSubstr("more work than"));
}

TEST(BoundedPatch, LongPathsAreRefusedCheaply) {
  std::string path;
  for (int i = 0; i < 300'000; ++i) path += "/a";
  EXPECT_THAT(refusal_of({{"a", 1}}, Json::array({op("add", path, 1)})), HasSubstr("nested deeper"));
  EXPECT_LT(refusal_of({{"a", 1}}, Json::array({op("test", path, 1)})).size(), 500U);
}

TEST(BoundedPatch, NothingIsAddedToANumber) {
  for (const char* path : {"/a/b", "/a/0", "/a/b/c"}) {
    EXPECT_THAT(refusal_of({{"a", 1}}, Json::array({op("add", path, 1)})),
                HasSubstr("not in a list or an object"))
        << path;
    EXPECT_THAT(refusal_of({{"a", 1}}, Json::array({{{"op", "remove"}, {"path", path}}})),
                HasSubstr("not in a list or an object"))
        << path;
  }
}

TEST(BoundedPatch, UnusedMembersOfAnOperationAreIgnored) {
  Json add = op("add", "/b", 1);
  add["from"] = "no pointer";
  add["comment"] = 5;
  EXPECT_EQ(apply_patch({{"a", 1}}, Json::array({add})), Json({{"a", 1}, {"b", 1}}));
}

/// Generates small documents, and patches whose paths mostly exist in them.
class Chance {
 public:
  explicit Chance(unsigned seed) : random_(seed) {}

  Json value(int depth = 0) {
    switch (below(depth < 3 ? 7 : 5)) {
      case 0: return nullptr;
      case 1: return below(100);
      case 2: return below(2) == 0;
      case 3: return -0.5;
      case 4: return text();
      case 5: {
        Json list = Json::array();
        for (int i = below(4); i > 0; --i) list.push_back(value(depth + 1));
        return list;
      }
      default: {
        Json object = Json::object();
        for (int i = below(4); i > 0; --i) object[text()] = value(depth + 1);
        return object;
      }
    }
  }

  /// A path to a value that exists, or nearly exists.
  std::string path(const Json& document) {
    std::string out;
    const Json* at = &document;
    while (at->is_structured() && below(4) != 0) {
      if (at->is_array()) {
        if (at->empty() || below(5) == 0) return out + odd_end();
        const int i = below(static_cast<int>(at->size()));
        out += "/" + std::to_string(i);
        at = &(*at)[static_cast<std::size_t>(i)];
      } else {
        if (at->empty() || below(5) == 0) return out + odd_end();
        const auto one = std::next(at->begin(), below(static_cast<int>(at->size())));
        out += "/" + escaped(one.key());
        at = &*one;
      }
    }
    return out;
  }

  Json operation(const Json& document) {
    static const std::vector<std::string> kOps{"add", "remove", "replace", "move", "copy", "test"};
    Json out{{"op", kOps[static_cast<std::size_t>(below(6))]}};
    if (below(20) != 0) out["path"] = path(document);
    if (below(8) != 0) out["from"] = path(document);
    if (below(8) != 0) out["value"] = below(3) == 0 ? document : value();
    if (below(50) == 0) out["op"] = value();
    return out;
  }

  int below(int end) { return static_cast<int>(random_() % static_cast<unsigned>(end)); }

 private:
  std::string text() {
    static const std::vector<std::string> kTexts{"a", "b", "",    "0",  "1", "-",
                                                 "~", "/", "a/b", "~1", "ä", "01"};
    return kTexts[static_cast<std::size_t>(below(static_cast<int>(kTexts.size())))];
  }
  std::string odd_end() {
    static const std::vector<std::string> kEnds{
        "/-", "/0", "/9", "/01", "/x", "/", "/~0", "/~", "x", "/-1", "/99999999999999999999"};
    return kEnds[static_cast<std::size_t>(below(static_cast<int>(kEnds.size())))];
  }
  static std::string escaped(const std::string& key) {
    std::string out;
    for (const char c : key) out += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
    return out;
  }

  std::mt19937 random_;
};

TEST(BoundedPatch, EqualsTheLibrarysWithinTheLimits) {
  int applied = 0;
  for (unsigned seed = 0; seed < 20'000; ++seed) {
    Chance chance(seed);
    const Json document = chance.value();
    Json patch = Json::array();
    Json now = document;
    for (int i = chance.below(4); i >= 0; --i) patch.push_back(chance.operation(now));
    std::optional<Json> expected, got;
    try {
      got = apply_patch(document, patch);
    } catch (const SettingsError& error) {
      // The library has an assertion here, or does nothing.
      if (std::string(error.what()).find("not in a list or an object") != std::string::npos) continue;
    }
    try {
      expected = document.patch(patch);
    } catch (const Json::exception&) {  // refused
    }
    ASSERT_EQ(got, expected) << document << "\n" << patch;
    if (got) ++applied;
  }
  EXPECT_GT(applied, 2000) << "most were refused, which tests little";
}

}  // namespace
}  // namespace sslv::bounded_patch_test
