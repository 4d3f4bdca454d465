// SPDX-License-Identifier: Apache-2.0
#include "settings/store.h"

#include <fstream>

#include <gmock/gmock.h>
#include <unistd.h>

namespace sslv {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// "a" must be a number up to 9; "b" has a default.
Json check(const Json& settings) {
  if (!settings.contains("a") || !settings["a"].is_number() || settings["a"] > 9) {
    throw SettingsError("/a: " + (settings.contains("a") ? settings["a"].dump() : "nothing") +
                        " is not allowed");
  }
  Json complete{{"a", settings["a"]}, {"b", settings.value("b", 2)}};
  return complete;
}

class Store : public ::testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_);
    write(admin_file_, R"({"a": 1})");
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  static void write(const std::filesystem::path& file, const std::string& text) {
    std::ofstream(file) << text;
  }
  SettingsStore open() const { return SettingsStore(admin_file_, state_, check); }

  static SettingsStore::Version set(SettingsStore& store, const char* key, const Json& value,
                                    std::optional<std::uint64_t> if_revision = {}) {
    return store.patch(Json::array({{{"op", "replace"}, {"path", std::string("/") + key}, {"value", value}}}),
                       {"Mia", if_revision}, kNothingToPrepare);
  }
  static SettingsStore::Version undo(SettingsStore& store, std::uint64_t revision) {
    return store.undo(revision, {"Tom"}, kNothingToPrepare);
  }
  static inline const SettingsStore::Prepare kNothingToPrepare = [](const Json&) { return [] {}; };
  template <class Error, class Act>
  static std::string error_of(Act act) {
    try {
      act();
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  }

  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("store_test." + std::to_string(::getpid()));
  const std::filesystem::path admin_file_ = folder_ / "settings.json", state_ = folder_ / "state";
  const std::filesystem::path saved_ = state_ / "settings.json";
};

TEST_F(Store, FillsInDefaultsAndStartsAtRevisionOne) {
  const auto version = open().current();
  EXPECT_EQ(version.revision, 1u);
  EXPECT_EQ(version.settings, (Json{{"a", 1}, {"b", 2}}));
}

TEST_F(Store, AChangeOutlivesTheDaemon) {
  {
    auto store = open();
    EXPECT_EQ(set(store, "a", 5).revision, 2u);
  }
  const auto version = open().current();
  EXPECT_EQ(version.revision, 2u);
  EXPECT_EQ(version.settings["a"], 5);
}

TEST_F(Store, LaterEditsOfTheAdminsFileAreKeptBesideTheChanges) {
  {
    auto store = open();
    set(store, "a", 5);
  }
  write(admin_file_, R"({"a": 1, "b": 7})");
  EXPECT_EQ(open().current().settings, (Json{{"a", 5}, {"b", 7}}));
}

TEST_F(Store, ARefusedChangeLeavesEverythingAsItWas) {
  auto store = open();
  set(store, "a", 5);
  EXPECT_THAT(error_of<SettingsError>([&] { set(store, "a", 10); }), HasSubstr("/a: 10"));
  EXPECT_THAT(error_of<SettingsError>([&] { set(store, "no_such_key", 10); }), HasSubstr("no_such_key"));
  EXPECT_THAT(error_of<SettingsError>([&] {
                store.patch(Json{{"a", 3}}, {}, kNothingToPrepare);
              }),
              HasSubstr("JSON Patch"));
  EXPECT_EQ(store.current().settings["a"], 5);
  EXPECT_EQ(open().current().revision, 2u);
}

TEST_F(Store, AStaleEditIsRefused) {
  auto store = open();
  set(store, "a", 5, 1);
  EXPECT_THAT(error_of<StaleRevision>([&] { set(store, "a", 6, 1); }),
              AllOf(HasSubstr("revision 2"), HasSubstr("on 1")));
  EXPECT_EQ(store.current().settings["a"], 5);
}

TEST_F(Store, ChangesComeIntoForceOnlyAfterTheyAreSaved) {
  auto store = open();
  std::vector<std::string> order;
  const Json patch = Json::array({{{"op", "replace"}, {"path", "/a"}, {"value", 3}}});
  store.patch(patch, {}, [&](const Json& next) {
    order.push_back("prepared " + next["a"].dump() +
                    (std::filesystem::exists(saved_) ? " after saving" : ""));
    return [&] {
      order.push_back(std::filesystem::exists(saved_) ? "in force after saving" : "in force unsaved");
    };
  });
  EXPECT_EQ(order, (std::vector<std::string>{"prepared 3", "in force after saving"}));
}

TEST_F(Store, WhatCannotBePreparedOrSavedIsNotInForce) {
  auto store = open();
  const Json patch = Json::array({{{"op", "replace"}, {"path", "/a"}, {"value", 3}}});
  EXPECT_EQ(error_of<SettingsError>([&] {
              store.patch(patch, {},
                          [](const Json&) -> std::function<void()> { throw SettingsError("no such file"); });
            }),
            "no such file");
  write(state_, "a file where the folder should be");
  bool in_force = false;
  EXPECT_THAT(error_of<StorageError>(
                  [&] { store.patch(patch, {}, [&](const Json&) { return [&] { in_force = true; }; }); }),
              HasSubstr("cannot write"));
  EXPECT_FALSE(in_force);
  EXPECT_EQ(store.current().settings["a"], 1);
}

TEST_F(Store, DamagedChangesFallBackToTheLastGoodOnes) {
  {
    auto store = open();
    set(store, "a", 5);
    set(store, "a", 6);
  }
  write(saved_, "{\"revision\": 3, \"chan");
  auto store = open();
  EXPECT_EQ(store.current().settings["a"], 5);
  EXPECT_THAT(store.problem(), AllOf(HasSubstr(saved_.string()), HasSubstr("set aside")));
  EXPECT_TRUE(std::filesystem::exists(saved_.string() + ".rejected"));
}

TEST_F(Store, ChangesThatNoLongerFitAreSetAsideLoudly) {
  {
    auto store = open();
    set(store, "a", 5);
  }
  write(saved_, R"({"revision": 2, "changes": [{"op": "replace", "path": "/a", "value": 99}]})");
  auto store = open();
  EXPECT_EQ(store.current().settings["a"], 1);
  EXPECT_THAT(store.problem(), HasSubstr("/a: 99"));
}

TEST_F(Store, NamesTheAdminsFileInErrors) {
  write(admin_file_, "{\"a\": 1,\n  \"b\" 2}");
  EXPECT_THAT(error_of<SettingsError>([&] { open(); }),
              AllOf(HasSubstr(admin_file_.string()), HasSubstr("line 2, column 7")));
  write(admin_file_, R"({"a": 50})");
  EXPECT_THAT(error_of<SettingsError>([&] { open(); }),
              AllOf(HasSubstr(admin_file_.string()), HasSubstr("/a: 50")));
  std::filesystem::remove(admin_file_);
  EXPECT_THAT(error_of<SettingsError>([&] { open(); }), HasSubstr("No such file"));
}

TEST_F(Store, TheAdminsFileIsNeverTakenForSavedChanges) {
  std::filesystem::create_directories(state_);
  write(saved_, R"({"a": 4})");
  EXPECT_THAT(error_of<SettingsError>([&] { SettingsStore(saved_, state_, check); }),
              AllOf(HasSubstr(saved_.string()), HasSubstr("another folder")));
  EXPECT_EQ(read_json_file(saved_), (Json{{"a", 4}})) << "and it is left alone";
}

TEST_F(Store, TheHistorySaysWhoChangedWhat) {
  {
    auto store = open();
    EXPECT_EQ(store.history(), Json::array());
    set(store, "a", 5);
    set(store, "b", 7);
  }
  const Json history = open().history();  // it is saved too
  ASSERT_EQ(history.size(), 2u);
  EXPECT_EQ(history[0]["revision"], 3);
  EXPECT_EQ(history[0]["who"], "Mia");
  EXPECT_GT(history[0]["time"], 1.7e9);
  EXPECT_EQ(history[0]["changes"],
            Json::parse(R"([{"op": "replace", "path": "/b", "before": 2, "after": 7}])"));
  EXPECT_EQ(history[1]["changes"][0]["after"], 5);
}

TEST_F(Store, AStepIsTakenBackAndLaterOnesStay) {
  auto store = open();
  set(store, "a", 5);
  set(store, "b", 7);
  EXPECT_EQ(undo(store, 2).settings, (Json{{"a", 1}, {"b", 7}}));
  EXPECT_EQ(store.current().revision, 4u);
  EXPECT_EQ(store.history()[0]["what"], "undo of revision 2");
  EXPECT_EQ(store.history()[0]["who"], "Tom");
  // The undoing is a step like any other.
  EXPECT_EQ(undo(store, 4).settings, (Json{{"a", 5}, {"b", 7}}));
}

TEST_F(Store, AnOptionalKeyIsTakenBack) {
  auto store = open();
  const Json patch = Json::array({{{"op", "add"}, {"path", "/b"}, {"value", 4}}});
  store.patch(patch, {}, kNothingToPrepare);
  EXPECT_EQ(undo(store, 2).settings, (Json{{"a", 1}, {"b", 2}}));
}

TEST_F(Store, WhatWasChangedAgainIsNotTakenBack) {
  auto store = open();
  set(store, "a", 5);
  set(store, "a", 6);
  try {
    undo(store, 2);
    FAIL() << "taken back";
  } catch (const StaleRevision& error) {
    EXPECT_EQ(error.revision, 3u);
    ASSERT_EQ(error.changed_since.size(), 1u);
    EXPECT_EQ(error.changed_since[0]["changes"][0]["after"], 6);
  }
  EXPECT_EQ(store.current().settings["a"], 6);
  EXPECT_THAT(error_of<SettingsError>([&] { undo(store, 99); }), HasSubstr("99"));
}

TEST_F(Store, AStaleEditIsToldWhatWasChanged) {
  auto store = open();
  set(store, "a", 5);
  set(store, "b", 3);
  try {
    set(store, "a", 6, 2);
    FAIL() << "accepted";
  } catch (const StaleRevision& error) {
    ASSERT_EQ(error.changed_since.size(), 1u);
    EXPECT_EQ(error.changed_since[0]["changes"][0]["path"], "/b");
  }
}

TEST(SettingsHistory, ChangesMakeOneTreeOfAnotherAndBack) {
  const std::vector<std::pair<const char*, const char*>> trees{
      {R"({"a": 1})", R"({"a": 2})"},
      {R"({"a": 1, "b": 2})", R"({"b": 2})"},
      {R"({"list": [1, 2, 3, 4]})", R"({"list": [2, 4, 5]})"},
      {R"({"list": [{"id": 0}, {"id": 1}]})", R"({"list": []})"},
      {R"({"a": {"b": null}})", R"({"a": {"b": {"c": [1]}}, "~/x": true})"},
  };
  for (const auto& [one, two] : trees) {
    const Json before = Json::parse(one), after = Json::parse(two);
    const Json changes = changes_between(before, after);
    // Equal whatever the order of keys.
    EXPECT_EQ(Json::diff(before.patch(forward_patch(changes)), after), Json::array()) << changes;
    EXPECT_EQ(Json::diff(after.patch(backward_patch(changes)), before), Json::array()) << changes;
  }
}

TEST(SettingsHistory, ForgetsTheOldest) {
  SettingsHistory history;
  const auto step = [](std::uint64_t revision, std::size_t bytes) {
    return Json{{"revision", revision},
                {"time", 1.0},
                {"who", "Mia"},
                {"what", ""},
                {"changes", {{{"op", "add"}, {"path", "/x"}, {"after", std::string(bytes, 'x')}}}}};
  };
  for (std::uint64_t i = 1; i <= SettingsHistory::kMostSteps + 5; ++i) history.add(step(i, 10));
  EXPECT_EQ(history.newer_than(0).size(), SettingsHistory::kMostSteps);
  EXPECT_EQ(history.find(5), nullptr);
  EXPECT_NE(history.find(6), nullptr);
  history.add(step(1000, SettingsHistory::kMostBytes));
  EXPECT_EQ(history.newer_than(0).size(), 1u);
  EXPECT_EQ(SettingsHistory(history.to_json()).newer_than(0), history.newer_than(0));
  EXPECT_EQ(SettingsHistory(Json::parse(R"([7, {"revision": "x"}, {}])")).newer_than(0).size(), 0u);
  EXPECT_EQ(SettingsHistory(Json{{"no", "list"}}).newer_than(0).size(), 0u);
}

TEST_F(Store, ManySmallChangesMayBeOneStep) {
  auto store = open();
  const auto paint = [&](const char* who, const char* what, int a) {
    SettingsEdit edit{who, {}, what};
    edit.joins = true;
    return store.patch(Json::array({{{"op", "replace"}, {"path", "/a"}, {"value", a}}}), edit,
                       kNothingToPrepare);
  };
  for (int a = 3; a <= 6; ++a) paint("Mia", "colours", a);
  ASSERT_EQ(store.history().size(), 1u);
  EXPECT_EQ(store.history()[0]["changes"],
            Json::parse(R"([{"op": "replace", "path": "/a", "before": 1, "after": 6}])"));
  EXPECT_EQ(store.history()[0]["revision"], store.current().revision);
  paint("Tom", "colours", 7);
  paint("Tom", "mask", 8);
  set(store, "b", 9);
  EXPECT_EQ(store.history().size(), 4u) << "another client's, another purpose, another value";
  const auto revision = open().history()[3]["revision"].get<std::uint64_t>();
  EXPECT_THAT(error_of<StaleRevision>([&] { undo(store, revision); }), HasSubstr("changed again"));
}

TEST_F(Store, NoProblemWithoutSavedChanges) {
  EXPECT_THAT(open().problem(), IsEmpty());
}

TEST_F(Store, AChangeMayBeCheckedWithoutMakingIt) {
  auto store = open();
  int tried = 0;
  const auto check_of = [&](const char* key, const Json& value) {
    return store.check(Json::array({{{"op", "add"}, {"path", std::string("/") + key}, {"value", value}}}),
                       [&](const Json& next) {
                         ++tried;
                         if (next["b"] == 7) throw SettingsError("/b: no such file");
                       });
  };
  EXPECT_EQ(check_of("a", 5), Json::parse(R"([{"op": "replace", "path": "/a", "before": 1, "after": 5}])"));
  EXPECT_EQ(check_of("a", 1), Json::array());
  EXPECT_EQ(tried, 2);
  EXPECT_EQ(error_of<SettingsError>([&] { check_of("a", 10); }), "/a: 10 is not allowed");
  EXPECT_EQ(error_of<SettingsError>([&] { check_of("b", 7); }), "/b: no such file");
  EXPECT_EQ(error_of<SettingsError>([&] { check_of("x/y", 7); }),
            error_of<SettingsError>([&] { set(store, "x/y", 7); }));
  EXPECT_EQ(store.current().revision, 1u);
  EXPECT_EQ(store.current().settings["a"], 1);
  EXPECT_FALSE(std::filesystem::exists(saved_));
}

TEST(ChangesBelow, AreThoseAtOrBelowAPath) {
  const Json before = Json::parse(R"({"field": {"length": 9}, "fields": 1, "cameras": [{"id": 0}]})");
  const Json after =
      Json::parse(R"({"field": {"length": 12}, "fields": 2, "cameras": [{"id": 5}, {"id": 1}]})");
  const Json changes = changes_between(before, after);
  const auto below = [&](const std::vector<std::string>& paths) {
    std::vector<std::string> out;
    for (const Json& change : changes_below(changes, paths)) out.push_back(change["path"]);
    return out;
  };
  using ::testing::UnorderedElementsAre;
  EXPECT_EQ(below({""}).size(), changes.size());
  EXPECT_THAT(below({"/field"}), UnorderedElementsAre("/field/length"));
  EXPECT_THAT(below({"/fields", "/cameras/0"}), UnorderedElementsAre("/fields", "/cameras/0/id"));
  EXPECT_THAT(below({"/cameras/1"}), UnorderedElementsAre("/cameras/1"));
  EXPECT_THAT(below({"/cameras/1/id"}), IsEmpty());
  EXPECT_THAT(below({}), IsEmpty());
}

}  // namespace
}  // namespace sslv
