// SPDX-License-Identifier: Apache-2.0
#include "services/calibration/calibration_history.h"

#include "settings/state_folder.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <unistd.h>

namespace sslv::calibration_history_test {
namespace {

class CalibrationHistoryTest : public testing::Test {
 protected:
  ~CalibrationHistoryTest() override { std::filesystem::remove_all(folder_); }

  static CalibrationRecord record(double focal_length_px) {
    CalibrationRecord out;
    out.time_s = 1e9 + focal_length_px;
    out.who = "192.0.2.7";
    out.figures = {{"rms_px", 0.1}};
    out.calibration.focal_length = focal_length_px;
    out.calibration.pixel_image_width = 780;
    out.calibration.pixel_image_height = 580;
    return out;
  }

  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("calibration_history_test." + std::to_string(::getpid()));
  const std::filesystem::path file_ = folder_ / "state" / "calibrations.json";
  StateFolder state_{folder_ / "state"};
};

TEST_F(CalibrationHistoryTest, IsThereAfterARestart) {
  {
    CalibrationHistory history(state_);
    EXPECT_TRUE(history.of(0).empty());
    CalibrationRecord second = record(602);
    second.replaced = record(601).calibration;
    second.reverted_s = 5;
    second.reverted_by = "::1";
    history.set(0, {record(601), second});
    history.set(3, {record(700)});
  }
  const CalibrationHistory history(state_);
  ASSERT_EQ(history.of(0).size(), 2u);
  EXPECT_EQ(history.of(0)[0].calibration.focal_length, 601);
  EXPECT_FALSE(history.of(0)[0].replaced);
  EXPECT_FALSE(history.of(0)[0].reverted_s);
  EXPECT_EQ(history.of(0)[1].replaced->focal_length, 601);
  EXPECT_EQ(history.of(0)[1].reverted_s, 5);
  EXPECT_EQ(history.of(0)[1].reverted_by, "::1");
  EXPECT_EQ(history.of(0)[1].figures["rms_px"], 0.1);
  EXPECT_EQ(history.of(3)[0].who, "192.0.2.7");
  EXPECT_TRUE(history.of(1).empty());
}

TEST_F(CalibrationHistoryTest, KeepsTheLastTwenty) {
  CalibrationHistory history(state_);
  CalibrationHistory::Records records;
  for (int i = 0; i < 25; ++i) records.push_back(record(600 + i));
  history.set(0, records);
  ASSERT_EQ(history.of(0).size(), 20u);
  EXPECT_EQ(history.of(0).front().calibration.focal_length, 605);
  EXPECT_EQ(history.of(0).back().calibration.focal_length, 624);
}

TEST_F(CalibrationHistoryTest, TheCurrentOneIsTheNewestNotReverted) {
  CalibrationHistory::Records records;
  EXPECT_EQ(newest_in_force(records), nullptr);
  records = {record(601), record(602)};
  EXPECT_EQ(newest_in_force(records), &records[1]);
  records[1].reverted_s = 5;
  EXPECT_EQ(newest_in_force(records), &records[0]);
}

TEST_F(CalibrationHistoryTest, AFileThatCannotBeUsedIsSetAside) {
  std::filesystem::create_directories(file_.parent_path());
  for (const char* text : {"no JSON", "[]", R"({"cameras": [{"records": 1}]})", R"({"others": []})"}) {
    std::ofstream(file_) << text;
    CalibrationHistory history(state_);
    EXPECT_TRUE(history.of(0).empty());
    EXPECT_FALSE(std::filesystem::exists(file_));
    EXPECT_TRUE(std::filesystem::exists(file_.string() + ".rejected"));
  }
}

TEST_F(CalibrationHistoryTest, AFailedSaveChangesNothing) {
  std::filesystem::remove(folder_ / "state");
  std::ofstream(folder_ / "state") << "no folder";
  CalibrationHistory history(state_);
  EXPECT_THROW(history.set(0, {record(601)}), StorageError);
  EXPECT_TRUE(history.of(0).empty());
}

}  // namespace
}  // namespace sslv::calibration_history_test
