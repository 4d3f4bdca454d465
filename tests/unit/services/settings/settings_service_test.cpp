// SPDX-License-Identifier: Apache-2.0
#include "services/settings/settings_service.h"

#include "support/temporary_folder.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sslv::settings_service_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// Logs every call.
class Recorder : public Service {
 public:
  Recorder(std::string name, std::vector<std::string>& log) : name_(std::move(name)), log_(log) {}
  Plan plan(const SettingsChange& change) const override {
    if (change.next.site == refused) throw SettingsError("/site: refused by " + name_);
    log_.push_back(name_ + " plans " + change.now.site + " -> " + change.next.site);
    return {
        .get_ready =
            [this, site = change.next.site] {
              if (site == lacks) throw SettingsError("/site: " + name_ + " has no room");
              log_.push_back(name_ + " is ready");
            },
        .apply = [this, site = change.next.site]() noexcept { log_.push_back(name_ + " applies " + site); },
        .outcome = [this] { return not_taken; }};
  }
  std::string refused, lacks;
  std::vector<std::string> not_taken;

 private:
  const std::string name_;
  std::vector<std::string>& log_;
};

class Attached : public SavedWith {
 public:
  void save() override { saved = true; }
  void take_back() noexcept override { saved = false; }
  bool saved = false;
};

class Transaction : public testing::Test {
 protected:
  Transaction() { service_.start({&first_, &second_}); }

  static std::filesystem::path write_settings(const std::filesystem::path& folder) {
    std::ofstream(folder / "settings.json") << R"({"site": "a"})";
    return folder / "settings.json";
  }
  static Json site(const std::string& name) {
    return Json{{{"op", "replace"}, {"path", "/site"}, {"value", name}}};
  }
  /// Makes the state folder unwritable, as on a full disk.
  void break_folder() {
    std::filesystem::remove_all(state_.path());
    std::ofstream(state_.path()) << "a file where the folder should be";
  }

  const test::TemporaryFolder folder_;
  StateFolder state_{folder_.path() / "state"};
  SettingsService service_{write_settings(folder_.path()), state_, {}};
  std::vector<std::string> log_;
  Recorder first_{"first", log_}, second_{"second", log_};
};

TEST_F(Transaction, AllPlanThenAllAreReadyThenAllApplyInOrder) {
  log_.clear();
  service_.patch(site("b"), {});
  EXPECT_THAT(log_, ElementsAre("first plans a -> b", "second plans a -> b", "first is ready",
                                "second is ready", "first applies b", "second applies b"));
  EXPECT_EQ(service_.config().load()->site, "b");
  EXPECT_EQ(service_.current().settings["site"], "b");
}

TEST_F(Transaction, AChangeThatOneRefusesTakesNoEffect) {
  log_.clear();
  second_.refused = "b";
  EXPECT_THROW(service_.patch(site("b"), {}), SettingsError);
  EXPECT_THAT(log_, ElementsAre("first plans a -> b"));
  EXPECT_EQ(service_.config().load()->site, "a");
  EXPECT_EQ(service_.current().revision, 1u);
}

TEST_F(Transaction, AChangeThatCannotBePreparedTakesNoEffect) {
  second_.lacks = "b";
  log_.clear();
  EXPECT_THROW(service_.patch(site("b"), {}), SettingsError);
  EXPECT_THAT(log_, testing::Not(testing::Contains(testing::HasSubstr("applies"))));
  EXPECT_EQ(service_.current().revision, 1u);
}

TEST_F(Transaction, ADryRunOnlyPlans) {
  log_.clear();
  EXPECT_EQ(service_.check(site("b")).size(), 1u);
  EXPECT_THAT(log_, ElementsAre("first plans a -> b", "second plans a -> b"));
  second_.refused = "c";
  EXPECT_THROW(service_.check(site("c")), SettingsError);
  EXPECT_EQ(service_.current().revision, 1u);
}

TEST_F(Transaction, ValuesRefusedByADeviceAreReportedAndSaved) {
  second_.not_taken = {"/cameras/0/source/controls/Gain: locked"};
  EXPECT_THAT(service_.patch(site("b"), {}).refused, ElementsAre("/cameras/0/source/controls/Gain: locked"));
  EXPECT_EQ(service_.current().settings["site"], "b");
  EXPECT_THAT(service_.current().refused, IsEmpty()) << "of that change alone";
}

TEST_F(Transaction, AnEditOfAnOlderRevisionIsTheClientsMistake) {
  service_.patch(site("b"), {});
  try {
    service_.patch(site("c"), {"Mia", 1});
    FAIL() << "not refused";
  } catch (const HttpError& error) {
    EXPECT_EQ(error.status, 409);
    EXPECT_EQ(error.more["revision"], 2);
    EXPECT_EQ(error.more["changed_since"].size(), 1u);
  }
}

TEST_F(Transaction, AFileThatBelongsToItIsSavedWithItOrNotAtAll) {
  Attached file;
  second_.refused = "b";
  EXPECT_THROW(service_.patch(site("b"), {}, &file), SettingsError);
  EXPECT_FALSE(file.saved);
  service_.patch(site("c"), {}, &file);
  EXPECT_TRUE(file.saved);
  file.saved = false;
  break_folder();
  log_.clear();
  EXPECT_THROW(service_.patch(site("d"), {}, &file), StorageError);
  EXPECT_FALSE(file.saved) << "taken back";
  EXPECT_THAT(log_, testing::Not(testing::Contains(testing::HasSubstr("applies"))));
  EXPECT_EQ(service_.config().load()->site, "c");
}

TEST_F(Transaction, ReportsDoNotAccessTheFolder) {
  HealthReport before;
  service_.report(before);
  EXPECT_THAT(before.alerts, IsEmpty());
  break_folder();
  HealthReport asked;
  service_.report(asked);
  EXPECT_THAT(asked.alerts, IsEmpty()) << "a disk that hangs must not hang the service";
  service_.each_second();
  HealthReport after;
  service_.report(after);
  ASSERT_EQ(after.alerts.size(), 1u);
  EXPECT_EQ(after.alerts[0].id, "state_not_writable");
}

}  // namespace
}  // namespace sslv::settings_service_test
