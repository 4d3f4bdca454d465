// SPDX-License-Identifier: Apache-2.0
#include "services/colors/saved_tables.h"

#include "base/error.h"
#include "config/config.h"
#include "settings/state_folder.h"
#include "support/temporary_folder.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sslv::saved_tables_test {
namespace {

using test::TemporaryFolder;
using testing::HasSubstr;

std::shared_ptr<const Lut> table_with(Label label) {
  ColorTable table;
  table.labels[4711] = label;
  return std::make_shared<const Lut>(std::move(table));
}

/// The tables of a service that has started.
struct Running : SavedTables {
  explicit Running(StateFolder& folder) : SavedTables(folder) { end_start(); }
};

std::string refusal(const SavedTables& tables, const std::string& name) {
  try {
    tables.load(name, "/cameras/0/colors/table", LabelSet::built_in());
  } catch (const SettingsError& error) {
    return error.what();
  }
  return "";
}

TEST(SavedTables, OutliveTheDaemon) {
  const TemporaryFolder folder;
  StateFolder state(folder.path());
  std::string name;
  {
    Running tables(state);
    name = tables.save(table_with(label::kPink), LabelSet::built_in());
  }
  const Running tables(state);
  const auto loaded = tables.load(name, "", LabelSet::built_in());
  EXPECT_EQ(loaded->color_table(), table_with(label::kPink)->color_table());
  EXPECT_EQ(tables.load(name, "", LabelSet::built_in()), loaded) << "one in memory is enough";
}

TEST(SavedTables, TheSameTableHasTheSameName) {
  const TemporaryFolder folder;
  StateFolder state(folder.path());
  Running tables(state);
  const std::string name = tables.save(table_with(label::kPink), LabelSet::built_in());
  EXPECT_NE(tables.save(table_with(label::kBlue), LabelSet::built_in()), name);
  EXPECT_EQ(tables.save(table_with(label::kPink), LabelSet::built_in()), name);
}

TEST(SavedTables, ATableOfAnEarlierVersionIsFound) {
  const TemporaryFolder folder;
  StateFolder state(folder.path());
  const std::string name = SavedTables(state).save(table_with(label::kPink), LabelSet::built_in());
  // The earlier version named it by another hash.
  const std::filesystem::path earlier = "c0ffee0123456789";
  std::filesystem::rename(folder.path() / "tables" / (name + ".lut"),
                          folder.path() / "tables" / (earlier.string() + ".lut"));
  EXPECT_EQ(Running(state).load(earlier.string(), "", LabelSet::built_in())->color_table(),
            table_with(label::kPink)->color_table());
}

TEST(SavedTables, RefuseUnknownOrDamagedTables) {
  const TemporaryFolder folder;
  StateFolder state(folder.path());
  std::ofstream(folder.path() / "secret.lut") << "secret";
  Running tables(state);
  const std::string name = tables.save(table_with(label::kPink), LabelSet::built_in());
  for (const std::string wrong : {"0123456789abcdef", "../secret", "", "x", "/etc/passwd"})
    EXPECT_THAT(refusal(tables, wrong), testing::StartsWith("/cameras/0/colors/table: ")) << wrong;

  const std::filesystem::path file = folder.path() / "tables" / (name + ".lut");
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  const Running later(state);
  EXPECT_THAT(refusal(later, name), HasSubstr(file.string())) << "damaged";
  SavedTables again(state);
  EXPECT_EQ(again.save(table_with(label::kPink), LabelSet::built_in()), name);
  EXPECT_EQ(SavedTables(state).load(name, "", LabelSet::built_in())->color_table(),
            table_with(label::kPink)->color_table())
      << "repaired";
}

TEST(SavedTables, TheOldestThatNobodyUsesGo) {
  const TemporaryFolder folder;
  StateFolder state(folder.path());
  Running tables(state);
  const std::string used = tables.save(table_with(label::kPink), LabelSet::built_in());
  const std::string unused = tables.save(table_with(label::kBlue), LabelSet::built_in());
  const auto long_ago = std::filesystem::file_time_type::clock::now() - std::chrono::hours(1);
  for (const std::string& name : {used, unused})
    std::filesystem::last_write_time(folder.path() / "tables" / (name + ".lut"), long_ago);
  for (std::size_t i = 0; i < SavedTables::kMax; ++i)
    std::ofstream(folder.path() / "tables" / (std::to_string(i) + ".lut")) << "newer";
  tables.tidy({used});
  EXPECT_EQ(refusal(tables, used), "");
  EXPECT_THAT(refusal(tables, unused), HasSubstr("expected a table that this service has saved"));
}

TEST(SavedTables, ReportATableThatIsMissingAtTheStart) {
  const TemporaryFolder folder;
  StateFolder state(folder.path());
  SavedTables tables(state);
  EXPECT_EQ(tables.load("0123456789abcdef", "/cameras/0/colors/table", LabelSet::built_in()), nullptr);
  EXPECT_THAT(tables.lost("0123456789abcdef"), ::testing::HasSubstr("/cameras/0/colors/table: "));
  EXPECT_EQ(tables.lost(""), "");
  tables.end_start();
  EXPECT_THROW(tables.load("0123456789abcdef", "", LabelSet::built_in()), SettingsError);
}

TEST(SavedTables, FromABackupAreUsableBeforeSaving) {
  const TemporaryFolder first_folder, folder;
  StateFolder first_state(first_folder.path()), state(folder.path());
  Running first(first_state), tables(state);
  Config config;
  config.cameras.resize(1);
  const std::string name = config.cameras[0].colors.table =
      first.save(table_with(label::kPink), LabelSet::built_in());
  const BackupFiles files = first.files(config);
  ASSERT_EQ(files.size(), 1U);
  const auto file = folder.path() / files.begin()->first;
  {
    const auto offered = tables.prepare(files);
    EXPECT_EQ(tables.load(name, "", LabelSet::built_in())->color_table(),
              table_with(label::kPink)->color_table());
    EXPECT_FALSE(std::filesystem::exists(file));
  }
  EXPECT_THAT(refusal(tables, name), HasSubstr("is not allowed"));
  {
    const auto offered = tables.prepare(files);
    offered->save();
    EXPECT_TRUE(std::filesystem::exists(file));
    offered->take_back();
    EXPECT_FALSE(std::filesystem::exists(file));
    offered->save();
  }
  EXPECT_EQ(tables.files(config), files);
}

TEST(SavedTables, FromABackupMustMatchTheirNames) {
  const TemporaryFolder folder;
  StateFolder state(folder.path());
  Running tables(state);
  EXPECT_THROW(tables.prepare({{"tables/0123456789abcdef.lut", "SSLVLUT2"}}), SettingsError);
  for (const char* name : {"tables/../../0123456789abcdef.lut", "tables/0123456789ABCDEF.lut", "tables/x.lut",
                           "0123456789abcdef.lut", "tables/.lut", "tables/"})
    EXPECT_FALSE(tables.has(name)) << name;
  EXPECT_TRUE(tables.has("tables/0123456789abcdef.lut"));
}

TEST(SavedTables, ADamagedTableIsNotBackedUp) {
  const TemporaryFolder folder;
  StateFolder state(folder.path());
  Running tables(state);
  Config config;
  config.cameras.resize(1);
  config.cameras[0].colors.table = tables.save(table_with(label::kPink), LabelSet::built_in());
  std::ofstream(folder.path() / tables.files(config).begin()->first) << "x";
  EXPECT_TRUE(tables.files(config).empty());
}

}  // namespace
}  // namespace sslv::saved_tables_test
