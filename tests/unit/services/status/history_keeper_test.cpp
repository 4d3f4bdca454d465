// SPDX-License-Identifier: Apache-2.0
#include "services/status/history_keeper.h"

#include "base/log.h"
#include "settings/state_folder.h"
#include "support/becomes.h"
#include "support/temporary_folder.h"

#include <algorithm>
#include <fstream>

#include <gmock/gmock.h>

namespace sslv::test::history_keeper_test {
namespace {

using ::testing::ElementsAre;

const Alert kLost{.id = "camera_lost",
                  .check = "cameras",
                  .severity = Severity::kBad,
                  .title = "Camera 0 is lost",
                  .fix = "",
                  .camera = 0};

std::vector<std::string> ids(const HistoryKeeper& keeper) {
  std::vector<std::string> out;
  const Json events = keeper.to_json();
  for (const Json& entry : events.at("entries")) out.push_back(entry.at("id").get<std::string>());
  return out;
}

std::size_t warnings_since(std::uint64_t seen) {
  return log::recent().newer_than(seen, log::Level::kWarning).lines.size();
}

std::uint64_t newest_line() {
  return log::recent().newer_than(0, log::Level::kDebug).newest;
}

class HistoryKeeperFiles : public ::testing::Test {
 protected:
  std::filesystem::path file() const { return folder_.path() / HistoryKeeper::kFileName; }
  void write(const std::string& text) const { std::ofstream(file()) << text; }

  TemporaryFolder folder_;
};

TEST_F(HistoryKeeperFiles, IsThereAgainAfterAStop) {
  {
    HistoryKeeper keeper(folder_.path());
    keeper.look({kLost}, {{"settings_changed", "Settings changed: /site", "10.0.0.7"}});
    EXPECT_THAT(ids(keeper), ElementsAre("settings_changed", "camera_lost", "service_started"));
  }
  HistoryKeeper keeper(folder_.path());
  keeper.look({}, {});
  EXPECT_THAT(ids(keeper), ElementsAre("service_started", "service_stopped", "settings_changed",
                                       "camera_lost", "service_started"));
  EXPECT_EQ(keeper.to_json()["entries"][3]["ended_by"], "the service ended");
  EXPECT_EQ(keeper.to_json()["save_problem"], "");
}

TEST_F(HistoryKeeperFiles, AServiceThatNeverRanLeavesNothing) {
  { const HistoryKeeper keeper(folder_.path()); }
  EXPECT_FALSE(std::filesystem::exists(file()));
}

TEST_F(HistoryKeeperFiles, SaysThatTheRunBeforeDied) {
  std::string as_it_died;
  {
    HistoryKeeper keeper(folder_.path());
    keeper.look({kLost}, {});
    // The first entry after a quiet time is saved at once, by another thread: wait for that.
    ASSERT_TRUE(becomes([&] { return std::filesystem::exists(file()); }));
    as_it_died = read_json_file(file()).dump();
  }
  write(as_it_died);
  HistoryKeeper keeper(folder_.path());
  keeper.look({}, {});
  EXPECT_THAT(ids(keeper), ElementsAre("service_restarted", "camera_lost", "service_started"));
  EXPECT_EQ(keeper.to_json()["entries"][1]["ended_by"], "the service ended");
  EXPECT_FALSE(keeper.to_json()["entries"][1]["end"].is_null());
}

TEST_F(HistoryKeeperFiles, ADamagedFileIsOneLineAndAnEmptyHistory) {
  for (const char* text :
       {"", "{\"version\": 1, \"entries\": [", "[]", "7", "{\"version\": 2, \"entries\": []}",
        "{\"version\": \"x\", \"entries\": []}", "{\"version\": 1, \"entries\": 7}", "\xff"}) {
    write(text);
    const auto seen = newest_line();
    HistoryKeeper keeper(folder_.path());
    EXPECT_EQ(warnings_since(seen), 1U) << text;
    keeper.look({}, {});
    EXPECT_THAT(ids(keeper), ElementsAre("service_started")) << text;
  }
}

TEST_F(HistoryKeeperFiles, StartsDespiteAFolderInItsPlace) {
  std::filesystem::create_directory(file());
  const auto seen = newest_line();
  HistoryKeeper keeper(folder_.path());
  EXPECT_EQ(warnings_since(seen), 1U);
  keeper.look({kLost}, {});
  ASSERT_TRUE(becomes([&] { return keeper.to_json().at("save_problem") != ""; }));
  EXPECT_EQ(warnings_since(seen), 2U) << "that it is not saved";
  EXPECT_THAT(ids(keeper), ElementsAre("camera_lost", "service_started"));
}

TEST_F(HistoryKeeperFiles, WithoutAFolderItIsKeptInMemory) {
  HistoryKeeper keeper(folder_.path() / "missing");
  keeper.look({kLost}, {});
  ASSERT_TRUE(becomes([&] { return keeper.to_json().at("save_problem") != ""; }));
  EXPECT_THAT(ids(keeper), ElementsAre("camera_lost", "service_started"));
}

}  // namespace
}  // namespace sslv::test::history_keeper_test
