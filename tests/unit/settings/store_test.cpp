// SPDX-License-Identifier: Apache-2.0
#include "settings/store.h"

#include "settings/history.h"
#include "settings/state_folder.h"
#include "support/failing_disk.h"
#include "support/patience.h"
#include "support/temporary_folder.h"

#include <chrono>
#include <fstream>
#include <future>
#include <iterator>

#include <gmock/gmock.h>
#include <unistd.h>

namespace sslv::store_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// "a" must be a number up to 9; "b" has a default.
CheckedSettings check(const Json& settings) {
  if (!settings.contains("a") || !settings["a"].is_number() || settings["a"] > 9) {
    throw SettingsError("/a: " + (settings.contains("a") ? settings["a"].dump() : "nothing") +
                        " is not allowed");
  }
  Json complete{{"a", settings["a"]}, {"b", settings.value("b", 2)}};
  return {complete};
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
  SettingsStore open(const Migrations& migrations = {}) {
    return SettingsStore(admin_file_, folder_of_state_, check, migrations);
  }

  static SettingsStore::Version set(SettingsStore& store, const char* key, const Json& value,
                                    std::optional<std::uint64_t> if_revision = {}) {
    return store.patch(Json::array({{{"op", "replace"}, {"path", std::string("/") + key}, {"value", value}}}),
                       {"Mia", if_revision}, kNothingToDo);
  }
  static SettingsStore::Version undo(SettingsStore& store, std::uint64_t revision) {
    return store.undo(revision, {"Tom"}, kNothingToDo);
  }
  static inline const SettingsStore::GetReady kNothingToDo = [](const CheckedSettings&) { return Apply(); };
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
  StateFolder folder_of_state_{state_};
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
                store.patch(Json{{"a", 3}}, {}, kNothingToDo);
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

TEST_F(Store, ChangesTakeEffectOnlyAfterTheyAreSaved) {
  auto store = open();
  std::vector<std::string> order;
  const Json patch = Json::array({{{"op", "replace"}, {"path", "/a"}, {"value", 3}}});
  store.patch(patch, {}, [&](const CheckedSettings& next) {
    order.push_back("ready for " + next.tree["a"].dump() +
                    (std::filesystem::exists(saved_) ? " after saving" : ""));
    return [&]() noexcept {
      order.push_back(std::filesystem::exists(saved_) ? "in force after saving" : "in force unsaved");
    };
  });
  EXPECT_EQ(order, (std::vector<std::string>{"ready for 3", "in force after saving"}));
}

TEST_F(Store, ChangesThatCannotBePreparedOrSavedTakeNoEffect) {
  auto store = open();
  const Json patch = Json::array({{{"op", "replace"}, {"path", "/a"}, {"value", 3}}});
  EXPECT_EQ(error_of<SettingsError>([&] {
              store.patch(patch, {},
                          [](const CheckedSettings&) -> Apply { throw SettingsError("no such file"); });
            }),
            "no such file");
  std::filesystem::remove(state_);
  write(state_, "a file where the folder should be");
  bool in_force = false;
  EXPECT_THAT(error_of<StorageError>([&] {
                store.patch(patch, {},
                            [&](const CheckedSettings&) { return [&]() noexcept { in_force = true; }; });
              }),
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
  EXPECT_THAT(error_of<SettingsError>([&] { SettingsStore(saved_, folder_of_state_, check); }),
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
  const Json history = open().history();  // the history is saved, too
  ASSERT_EQ(history.size(), 2u);
  EXPECT_EQ(history[0]["revision"], 3);
  EXPECT_EQ(history[0]["who"], "Mia");
  EXPECT_GT(history[0]["time"], 1.7e9);
  EXPECT_EQ(history[0]["changes"],
            Json::parse(R"([{"op": "replace", "path": "/b", "before": 2, "after": 7}])"));
  EXPECT_EQ(history[1]["changes"][0]["after"], 5);
}

TEST_F(Store, AStepIsUndoneAndLaterOnesStay) {
  auto store = open();
  set(store, "a", 5);
  set(store, "b", 7);
  EXPECT_EQ(undo(store, 2).settings, (Json{{"a", 1}, {"b", 7}}));
  EXPECT_EQ(store.current().revision, 4u);
  EXPECT_EQ(store.history()[0]["what"], "undo of revision 2");
  EXPECT_EQ(store.history()[0]["who"], "Tom");
  // An undo can be undone like any other step.
  EXPECT_EQ(undo(store, 4).settings, (Json{{"a", 5}, {"b", 7}}));
}

TEST_F(Store, AnOptionalKeyIsUndone) {
  auto store = open();
  const Json patch = Json::array({{{"op", "add"}, {"path", "/b"}, {"value", 4}}});
  store.patch(patch, {}, kNothingToDo);
  EXPECT_EQ(undo(store, 2).settings, (Json{{"a", 1}, {"b", 2}}));
}

TEST_F(Store, ValuesChangedAgainAreNotUndone) {
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
    // Equal regardless of the order of keys.
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
  for (std::uint64_t i = 1; i <= SettingsHistory::kMaxSteps + 5; ++i) history.add(step(i, 10));
  EXPECT_EQ(history.newer_than(0).size(), SettingsHistory::kMaxSteps);
  EXPECT_EQ(history.find(5), nullptr);
  EXPECT_NE(history.find(6), nullptr);
  history.add(step(1000, SettingsHistory::kMaxBytes));
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
    return store.patch(Json::array({{{"op", "replace"}, {"path", "/a"}, {"value", a}}}), edit, kNothingToDo);
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
  EXPECT_THAT(error_of<StaleRevision>([&] { undo(store, revision); }), HasSubstr("have changed since"));
}

TEST_F(Store, ReadsDoNotWaitForAnEdit) {
  SettingsStore store = open();
  std::future<bool> read;  // by another thread, while the edit is prepared
  bool was_read = false;
  store.patch(
      Json::array({{{"op", "replace"}, {"path", "/a"}, {"value", 5}}}), {"Mia"}, [&](const CheckedSettings&) {
        read = std::async(std::launch::async,
                          [&] { return store.current().settings.at("a") == 1 && store.history().empty(); });
        was_read = read.wait_for(test::kPatience) == std::future_status::ready;
        return Apply();
      });
  EXPECT_TRUE(was_read);
  EXPECT_TRUE(read.get());
  EXPECT_EQ(store.current().settings.at("a"), 5);
}

TEST_F(Store, NoProblemWithoutSavedChanges) {
  EXPECT_THAT(open().problem(), IsEmpty());
}

TEST_F(Store, AChangeMayBeCheckedWithoutMakingIt) {
  auto store = open();
  int tried = 0;
  const auto check_of = [&](const char* key, const Json& value) {
    return store.check(Json::array({{{"op", "add"}, {"path", std::string("/") + key}, {"value", value}}}),
                       [&](const CheckedSettings& next) {
                         ++tried;
                         if (next.tree["b"] == 7) throw SettingsError("/b: no such file");
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

TEST_F(Store, ThePreviousFileIsKept) {
  auto store = open();
  set(store, "a", 5);
  set(store, "a", 6);
  const std::filesystem::path previous = state_ / "settings.previous.json";
  EXPECT_EQ(read_json_file(saved_)["revision"], 3);
  EXPECT_EQ(read_json_file(previous)["revision"], 2);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(state_), {}), 2) << "and nothing else is left";
}

TEST_F(Store, FilesLeftByAKillAreRemoved) {
  write(state_ / "settings.json.new", "{\"revi");
  write(state_ / "settings.json.old", "{}");
  write(state_ / "settings.previous.json.new", "{}");
  write(state_ / "notes.new", "the admin's own");
  EXPECT_EQ(open().current().revision, 1u);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(state_), {}), 1);
}

TEST_F(Store, RejectedFilesAreNotOverwritten) {
  for (const char* text : {"one", "two", "three"}) {
    write(saved_, text);
    open();
  }
  for (const char* ending : {".rejected", ".rejected.2", ".rejected.3"})
    EXPECT_TRUE(std::filesystem::exists(saved_.string() + ending)) << ending;
}

TEST_F(Store, WritesAgainOnceItCan) {
  auto store = open();
  set(store, "a", 5);
  std::filesystem::create_directories(saved_.string() + ".new");  // blocks writing the new file
  EXPECT_THAT(error_of<StorageError>([&] { set(store, "a", 6); }), HasSubstr(saved_.string()));
  EXPECT_THAT(folder_of_state_.write_problem(), HasSubstr(saved_.string()));
  EXPECT_EQ(store.current().settings["a"], 5);
  EXPECT_EQ(open().current().settings["a"], 5);
  std::filesystem::remove(saved_.string() + ".new");
  EXPECT_EQ(set(store, "a", 7).revision, 3u);
  EXPECT_THAT(folder_of_state_.write_problem(), IsEmpty());
}

TEST_F(Store, AFailedSyncIsUndoneOnTheDisk) {
  auto store = open();
  {
    const test::FailingDisk disk;
    EXPECT_THAT(error_of<StorageError>([&] { set(store, "a", 5); }), HasSubstr("Input/output error"));
    EXPECT_FALSE(std::filesystem::exists(saved_)) << "there was none";
  }
  set(store, "a", 6);
  set(store, "a", 7);
  {
    const test::FailingDisk disk;
    EXPECT_THAT(error_of<StorageError>([&] { set(store, "a", 8); }), HasSubstr(saved_.string()));
  }
  EXPECT_EQ(store.current().settings["a"], 7);
  EXPECT_EQ(open().current().settings["a"], 7) << "disk and memory agree";
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(state_), {}), 2);
  EXPECT_EQ(set(store, "a", 9).revision, 4u);
}

TEST_F(Store, ReadingAFileNamesTheFormatsOfOtherPrograms) {
  const auto error_of_text = [&](const std::string& text) {
    write(saved_, text);
    return error_of<SettingsError>([&] { read_json_file(saved_); });
  };
  const std::string xml = "\xEF\xBB\xBF<?xml version=\"1.0\"?>\n<VarXML>\n";
  EXPECT_THAT(error_of_text(xml + "<Var name=\"LUT Data\" type=\"blob\">AAAA"),
              HasSubstr(": must be JSON, but is a colour table of SSL-Vision; ssl-visionctl colours import"));
  EXPECT_THAT(error_of_text(xml + "<Var name=\"Global\" type=\"list\">"),
              HasSubstr("settings of SSL-Vision"));
  EXPECT_THAT(error_of_text("<html>"), HasSubstr(": must be JSON, but is XML"));
  EXPECT_THAT(error_of_text("# a comment\n\ncam_id: 0\n"), HasSubstr(": must be JSON, but is YAML"));
  EXPECT_THAT(error_of_text("\x1F\x8B\x08"), HasSubstr("is compressed (gzip)"));
  EXPECT_THAT(error_of_text("{\"a\": 1,\n b}"), HasSubstr(": line 2, column 2: not valid JSON"));
  for (const char* text : {"", "#", ":", "a", "{", "1 2"})
    EXPECT_THAT(error_of_text(text), HasSubstr("not valid JSON")) << text;
}

TEST(WriteFileDurably, TakesANameWithoutAFolder) {
  const test::TemporaryFolder folder;
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  EXPECT_NO_THROW(write_file_durably("here.json", "{}"));
  std::filesystem::current_path(before);
  EXPECT_EQ(read_json_file(folder.path() / "here.json"), Json::object());
}

TEST_F(Store, AnUnusableStateFolderIsNamedAndCreatedLater) {
  std::filesystem::remove(state_);
  write(state_, "a file where the folder should be");
  EXPECT_THAT(folder_of_state_.find_problem(), HasSubstr(state_.string()));
  std::filesystem::remove(state_);
  EXPECT_THAT(folder_of_state_.find_problem(), IsEmpty());
}

TEST_F(Store, ReloadsTheAdminsFileBelowThePanelsChanges) {
  auto store = open();
  set(store, "a", 5);
  write(admin_file_, R"({"a": 1, "b": 7})");
  Json next_tree;
  const auto version = store.reload([&](const CheckedSettings& next) {
    next_tree = next.tree;
    return Apply();
  });
  EXPECT_EQ(version.revision, 3u);
  EXPECT_EQ(version.settings, (Json{{"a", 5}, {"b", 7}}));
  EXPECT_EQ(next_tree, version.settings);
  EXPECT_EQ(store.history()[0]["what"], "reload of " + admin_file_.string());
  EXPECT_EQ(store.history()[0]["changes"][0]["path"], "/b");
  EXPECT_EQ(open().current().revision, 3u);
  EXPECT_EQ(open().current().settings, version.settings);
  // A reload can be undone like any other step.
  EXPECT_EQ(undo(store, 3).settings, (Json{{"a", 5}, {"b", 2}}));
  EXPECT_EQ(open().current().settings, (Json{{"a", 5}, {"b", 2}}));
}

TEST_F(Store, AReloadWithoutChangesIsNoStep) {
  auto store = open();
  const auto must_not = [](const CheckedSettings&) -> Apply { throw SettingsError("got ready"); };
  EXPECT_EQ(store.reload(must_not).revision, 1u);
  EXPECT_FALSE(std::filesystem::exists(saved_));
  set(store, "a", 5);
  write(admin_file_, R"({"a": 5})");  // the admin's file now contains the panel's change
  EXPECT_EQ(store.reload(must_not).revision, 2u);
  EXPECT_EQ(store.history().size(), 1u);
  write(admin_file_, R"({"a": 6})");
  EXPECT_EQ(store.reload(kNothingToDo).settings["a"], 6) << "it is the panel's change no more";
}

TEST_F(Store, ARefusedReloadChangesNothingAndIsReportedUntilOneSucceeds) {
  auto store = open();
  set(store, "b", 7);
  const auto reload = [&] { return error_of<SettingsError>([&] { store.reload(kNothingToDo); }); };
  for (const auto& [text, why] : {std::pair{"{\"a\": ", "line 1"}, {R"({"a": 50})", "/a: 50"}}) {
    write(admin_file_, text);
    EXPECT_THAT(reload(), AllOf(HasSubstr(admin_file_.string()), HasSubstr(why)));
    EXPECT_THAT(store.reload_problem(), HasSubstr(why));
    EXPECT_EQ(store.current().settings, (Json{{"a", 1}, {"b", 7}}));
    EXPECT_EQ(store.current().revision, 2u);
  }
  write(admin_file_, R"({"a": 2})");
  EXPECT_THAT(error_of<SettingsError>([&] {
                store.reload([](const CheckedSettings&) -> Apply { throw SettingsError("no such file"); });
              }),
              HasSubstr("no such file"));
  EXPECT_EQ(store.current().settings["a"], 1);
  EXPECT_EQ(store.reload(kNothingToDo).settings, (Json{{"a", 2}, {"b", 7}}));
  EXPECT_THAT(store.reload_problem(), IsEmpty());
}

/// Accepts any tree.
CheckedSettings anything(const Json& settings) {
  return {settings};
}

TEST_F(Store, ChangesOfACameraAreNotPutOntoAnother) {
  write(admin_file_, R"({"cameras": [{"id": 0, "x": 1}, {"id": 1, "x": 1}]})");
  const auto with_cameras = [&] { return SettingsStore(admin_file_, folder_of_state_, anything); };
  {
    auto store = with_cameras();
    set(store, "cameras/1/x", 5);
    write(admin_file_, R"({"cameras": [{"id": 1, "x": 1}, {"id": 0, "x": 1}]})");
    EXPECT_THAT(error_of<SettingsError>([&] { store.reload(kNothingToDo); }),
                AllOf(HasSubstr("/cameras/1/x"), HasSubstr("/cameras/1/id was 1, but it is now 0")));
    write(admin_file_, R"({"cameras": [{"id": 0, "x": 1}]})");
    EXPECT_THAT(error_of<SettingsError>([&] { store.reload(kNothingToDo); }),
                HasSubstr("together with the panel's changes"));
  }
  write(admin_file_, R"({"cameras": [{"id": 1, "x": 1}, {"id": 0, "x": 1}]})");
  EXPECT_THAT(with_cameras().problem(), HasSubstr("but it is now 0"));
  write(admin_file_, R"({"cameras": [{"id": 0, "x": 2}, {"id": 1, "x": 1}, {"id": 2, "x": 1}]})");
  std::filesystem::rename(saved_.string() + ".rejected", saved_);
  EXPECT_EQ(with_cameras().current().settings["cameras"],
            Json::parse(R"([{"id": 0, "x": 2}, {"id": 1, "x": 5}, {"id": 2, "x": 1}])"));
}

/// In version 1, "a" was named "old_a"; in version 2, it was counted from 1.
const Migrations kTwoMigrations{[](Json& tree) {
                                  if (!tree.is_object() || !tree.contains("old_a")) return;
                                  tree["a"] = tree["old_a"];
                                  tree.erase("old_a");
                                },
                                [](Json& tree) {
                                  if (tree.contains("a")) tree["a"] = tree["a"].get<int>() - 1;
                                }};

TEST_F(Store, AnOlderFileIsBroughtUpToDate) {
  write(admin_file_, R"({"old_a": 4})");  // from before versions existed
  EXPECT_EQ(open(kTwoMigrations).current().settings["a"], 3);
  write(admin_file_, R"({"version": 2, "a": 4})");
  EXPECT_EQ(open(kTwoMigrations).current().settings["a"], 3);
  write(admin_file_, R"({"version": 3, "a": 4})");
  EXPECT_EQ(open(kTwoMigrations).current().settings["a"], 4);
  EXPECT_EQ(read_json_file(admin_file_)["version"], 3) << "it is never written";
}

TEST_F(Store, ANewerFileIsRefused) {
  write(admin_file_, R"({"version": 4, "a": 4})");
  EXPECT_THAT(
      error_of<SettingsError>([&] { open(kTwoMigrations); }),
      AllOf(HasSubstr(admin_file_.string() + ": /version: 4 is newer"), HasSubstr("up to version 3")));
  for (const char* wrong : {"0", "-1", "1.5", "\"2\"", "null"}) {
    write(admin_file_, std::string(R"({"a": 4, "version": )") + wrong + "}");
    EXPECT_THAT(error_of<SettingsError>([&] { open(kTwoMigrations); }), HasSubstr("/version: ")) << wrong;
  }
}

/// Checks and completes settings as a program of version 1 does.
CheckedSettings check_version_1(const Json& settings) {
  return {Json{{"old_a", settings.value("old_a", 1)}, {"b", settings.value("b", 2)}}};
}

TEST_F(Store, OlderSavedChangesAreBroughtUpToDate) {
  write(admin_file_, "{}");  // so that only the saved file has the changes
  {
    SettingsStore store(admin_file_, folder_of_state_, check_version_1);
    set(store, "old_a", 8);
    set(store, "b", 3);
  }
  EXPECT_EQ(read_json_file(saved_)["version"], 1);
  for (const char* admin : {R"({"old_a": 4})", R"({"version": 3, "a": 3})"}) {
    write(admin_file_, admin);
    auto store = open(kTwoMigrations);
    EXPECT_THAT(store.problem(), IsEmpty());
    EXPECT_EQ(store.current().settings, (Json{{"a", 7}, {"b", 3}})) << admin;
    EXPECT_EQ(store.current().revision, 3u);
  }
  auto store = open(kTwoMigrations);
  EXPECT_THAT(error_of<StaleRevision>([&] { undo(store, 2); }), HasSubstr("have changed since"))
      << "a step of a key that is no more";
  set(store, "a", 9);
  EXPECT_EQ(read_json_file(saved_)["version"], 3);
  EXPECT_EQ(open(kTwoMigrations).current().settings, (Json{{"a", 9}, {"b", 3}}));
}

TEST_F(Store, SavedChangesFromBeforeVersionsGoOnWorking) {
  const char* saved = R"({"revision": 7, "history": [],
                          "changes": [{"op": "replace", "path": "/a", "value": 8}]})";
  write(saved_, saved);
  EXPECT_EQ(open().current().settings["a"], 8);
  EXPECT_EQ(open().current().revision, 7u);
  write(admin_file_, R"({"old_a": 4})");
  write(saved_, R"({"revision": 7, "changes": [{"op": "replace", "path": "/old_a", "value": 8}]})");
  EXPECT_EQ(open(kTwoMigrations).current().settings["a"], 7);
}

TEST_F(Store, NewerSavedChangesAreKeptForTheProgramThatKnowsThem) {
  write(saved_, R"({"version": 2, "revision": 7, "changes": [], "made_on": {}})");
  auto store = open();
  EXPECT_EQ(store.current().revision, 1u);
  EXPECT_THAT(store.problem(), AllOf(HasSubstr("/version: 2 is newer"), HasSubstr(".rejected")));
  EXPECT_EQ(read_json_file(saved_.string() + ".rejected")["revision"], 7);
}

TEST_F(Store, AWholeFileMayBeImported) {
  auto store = open(kTwoMigrations);  // the admin's file is of version 1: "a" is 0
  const auto import = [&](const char* text) {
    return store.patch(Json::array({{{"op", "replace"}, {"path", ""}, {"value", Json::parse(text)}}}), {},
                       kNothingToDo);
  };
  EXPECT_EQ(import(R"({"a": 5})").settings["a"], 5) << "a current one";
  EXPECT_EQ(import(R"({"old_a": 5})").settings["a"], 4) << "an export from before exports said their version";
  EXPECT_EQ(import(R"({"version": 2, "a": 5})").settings["a"], 4);
  EXPECT_THAT(error_of<SettingsError>([&] { import(R"({"version": 9, "a": 5})"); }), HasSubstr("newer"));
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

TEST_F(Store, IsReadWhileAnEditIsUnderWay) {
  std::promise<void> reached, go_on;
  SettingsStore store = open();
  const SettingsStore::GetReady slow = [&](const CheckedSettings&) {
    reached.set_value();
    go_on.get_future().wait();
    return Apply();
  };
  auto edit = std::async(std::launch::async, [&] {
    return store.patch(Json::array({{{"op", "replace"}, {"path", "/a"}, {"value", 5}}}), {"Mia"}, slow);
  });
  reached.get_future().wait();
  EXPECT_EQ(store.current().settings["a"], 1);
  EXPECT_EQ(store.history(), Json::array());
  EXPECT_EQ(store
                .check(Json::array({{{"op", "replace"}, {"path", "/a"}, {"value", 7}}}),
                       [](const CheckedSettings&) {})
                .size(),
            1U);
  go_on.set_value();
  EXPECT_EQ(edit.get().settings["a"], 5);
}

TEST_F(Store, AnEditMadeMeanwhileIsNotLost) {
  // "b" is changed during the edit of "a": its patch may already have been applied to the old tree.
  SettingsStore store = open();
  std::promise<void> reached, go_on;
  auto first = std::async(std::launch::async, [&] {
    return store.patch(Json::array({{{"op", "replace"}, {"path", "/a"}, {"value", 5}}}), {"Mia"},
                       [&](const CheckedSettings&) {
                         reached.set_value();
                         go_on.get_future().wait();
                         return Apply();
                       });
  });
  reached.get_future().wait();
  auto second = std::async(std::launch::async, [&] { return set(store, "b", 8); });
  go_on.set_value();
  first.get();
  EXPECT_EQ(second.get().settings, (Json{{"a", 5}, {"b", 8}}));
  EXPECT_EQ(store.current().revision, 3U);
}

TEST_F(Store, OtherSettingsComeWithTheirHistoryAndCanBeUndone) {
  SettingsStore first = open();
  set(first, "a", 3);
  set(first, "a", 4);
  const auto kept = first.current();
  const Json history = first.history();
  write(admin_file_, R"({"a": 7, "b": 8})");
  folder_of_state_.write(folder_of_state_.path() / "settings.json", R"({"revision": 9, "changes": []})");
  SettingsStore spare = open();
  const auto restored =
      spare.restore(kept.settings, kept.revision, history, {"Mia", {}, "backup"}, kNothingToDo);
  EXPECT_EQ(restored.revision, 10U) << "after all that either has had";
  EXPECT_EQ(restored.settings.dump(), kept.settings.dump());
  Json steps = spare.history();
  EXPECT_EQ(steps[0]["what"], "backup");
  steps.erase(0);
  EXPECT_EQ(steps, history);
  SettingsStore again = open();
  EXPECT_EQ(again.current().settings.dump(), kept.settings.dump());
  EXPECT_EQ(undo(again, 10).settings, (Json{{"a", 7}, {"b", 8}}));
}

TEST_F(Store, OtherSettingsThatAreRefusedChangeNothing) {
  SettingsStore store = open();
  set(store, "a", 3);
  const Json history = store.history();
  const auto refusal = [&](const Json& tree, const Json& steps,
                           std::optional<std::uint64_t> if_revision = {}) {
    return error_of<std::exception>([&] {
      store.restore(tree, 5, steps, {"Mia", if_revision, "backup"}, kNothingToDo);
    });
  };
  const Json good{{"a", 5}};
  EXPECT_EQ(refusal({{"a", 10}}, history), "/a: 10 is not allowed");
  EXPECT_THAT(refusal(good, history, 1), HasSubstr("made on 1"));
  EXPECT_THAT(refusal(good, {{"no", "list"}}), HasSubstr("/history"));
  for (const char* key : {"revision", "time", "who", "what", "changes"}) {
    Json steps = history;
    steps[0].erase(key);
    EXPECT_THAT(refusal(good, steps), HasSubstr("/history/0")) << key;
  }
  Json steps = history;
  steps[0]["revision"] = 6;
  EXPECT_THAT(refusal(good, steps), HasSubstr("/history/0")) << "newer than what they were at";
  steps = history;
  steps.push_back(history[0]);
  EXPECT_THAT(refusal(good, steps), HasSubstr("/history/1")) << "the same again";
  steps = history;
  steps[0]["changes"][0].erase("after");
  EXPECT_THAT(refusal(good, steps), HasSubstr("/history/0"));
  EXPECT_EQ(store.history(), history);
  EXPECT_EQ(store.current().revision, 2U);
}

TEST(ExactPatch, MakesTheSameText) {
  const auto check_text = [](const char* before, const char* after) {
    const Json from = Json::parse(before), to = Json::parse(after);
    EXPECT_EQ(from.patch(exact_patch(from, to)).dump(), to.dump()) << before << " " << after;
  };
  check_text(R"({"a": 1})", R"({"a": 1.0})");
  check_text(R"({"a": {"x": 1, "y": 2}, "b": [1]})", R"({"a": {"y": 2, "x": 1}, "b": [1.0]})");
  check_text(R"({"a": {"x": 1, "y": 2}})", R"({"a": {"y": 2, "z": [], "x": 1}})");
  check_text(R"([{"a~/b": {"x": 1, "y": 2}}])", R"([{"a~/b": {"y": 2, "x": 1}}])");
  check_text("null", R"({"a": 1})");
  EXPECT_TRUE(exact_patch({{"a", 1}}, {{"a", 1}}).empty());
}

}  // namespace
}  // namespace sslv::store_test
