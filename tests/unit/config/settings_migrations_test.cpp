// SPDX-License-Identifier: Apache-2.0
#include "base/error.h"
#include "config/config.h"
#include "settings/migrations.h"

#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::settings_migrations_test {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

Json current(Json file) {
  return up_to_date(std::move(file), settings_migrations());
}

TEST(SettingsMigrations, KeepTheLimitsOfFollowLight) {
  const Json old = Json::parse(R"({
    "site": "Hall",
    "cameras": [
      {"id": 0, "follow_light": {"enabled": true, "most_brightness": 3, "most_balance": 1.2,
                                 "most_brightness_per_min": 5, "most_balance_per_min": 1.1,
                                 "min_confidence": 0.8, "least_robots": 4}},
      {"id": 1, "follow_light": {"least_robots": 3}},
      {"id": 2}
    ]})");
  const Json expected = Json::parse(R"({
    "max_brightness": 3, "max_balance": 1.2, "max_brightness_per_min": 5, "max_balance_per_min": 1.1,
    "min_confidence": 0.8, "min_robots": 4})");
  for (const bool says_version : {false, true}) {
    Json file = old;
    if (says_version) file["version"] = 1;
    const Json migrated = current(file);
    EXPECT_EQ(migrated["site"], "Hall");
    const Json& light = migrated["cameras"][0]["follow_light"];
    EXPECT_EQ(light["enabled"], true);
    EXPECT_EQ(light.size(), expected.size() + 1);
    for (const auto& [key, value] : expected.items()) EXPECT_EQ(light.at(key), value) << key;
    EXPECT_EQ(migrated["cameras"][1]["follow_light"], (Json{{"min_robots", 3}}));
    EXPECT_EQ(migrated["cameras"][2], (Json{{"id", 2}}));
  }
}

TEST(SettingsMigrations, OldKeysGiveTheSameSettingsAsNewOnes) {
  const auto complete = [](const char* light) {
    const std::string file = R"({"cameras": [{"id": 0, "follow_light": )" + std::string(light) + "}]}";
    return complete_settings(current(Json::parse(file)));
  };
  EXPECT_EQ(complete(R"({"most_brightness": 2, "least_robots": 5})"),
            complete(R"({"max_brightness": 2, "min_robots": 5})"));
  EXPECT_THAT([&] { complete(R"({"most_brightness": 2, "max_brightness": 3})"); },
              ThrowsMessage<SettingsError>(HasSubstr("most_brightness")));
}

TEST(SettingsMigrations, KeepOldKeysInVersion2) {
  const Json file = Json::parse(R"({"version": 2, "cameras": [{"follow_light": {"least_robots": 3}}]})");
  EXPECT_EQ(current(file)["cameras"][0]["follow_light"], (Json{{"least_robots", 3}}));
}

TEST(SettingsMigrations, ReplaceTheSwitchForOtherComputersByAnEmptyList) {
  for (const char* before : {"true", "false"}) {
    for (const char* version : {"", R"("version": 2, )"}) {
      const std::string file = "{" + std::string(version) +
                               R"("field": {"field_length": 12000, "other_computers": )" + before + "}}";
      const Json migrated = current(Json::parse(file));
      EXPECT_EQ(migrated.at("field"), Json::parse(R"({"field_length": 12000, "other_computers": []})"));
      EXPECT_NO_THROW(complete_settings(migrated));
    }
  }
  const Json named = Json::parse(R"({"version": 3, "field": {"other_computers": ["10.0.0.2"]}})");
  EXPECT_EQ(current(named)["field"]["other_computers"], Json::array({"10.0.0.2"}));
}

TEST(OtherComputers, AreNamedByTheirAddresses) {
  const auto complete = [](const Json& computers) {
    return complete_settings({{"field", {{"other_computers", computers}}}});
  };
  EXPECT_NO_THROW(complete({"10.0.0.2", "127.0.0.1"}));
  for (const char* bad : {"", "field-pc", "fe80::1", "224.5.23.2", "0.0.0.0", "10.0.0", "10.0.0.2 "}) {
    EXPECT_THAT(
        [&] {
          complete({"10.0.0.1", bad});
        },
        ThrowsMessage<SettingsError>(
            testing::AllOf(testing::StartsWith("/field/other_computers/1: \"" + std::string(bad)),
                           HasSubstr("expected the IPv4 address of a computer, such as 10.0.0.2"))))
        << bad;
  }
  EXPECT_THAT([&] { complete(Json(std::vector<std::string>(17, "10.0.0.1"))); },
              ThrowsMessage<SettingsError>(HasSubstr("/field/other_computers: 17 entries are not allowed")));
}

TEST(SettingsMigrations, ImagesInPartsBecomeWholeOnes) {
  for (const int version : {1, 2}) {
    const auto images = [&](const char* value) {
      const Json file{{"version", version},
                      {"recording", {{"last_seconds", {{"images", value}, {"memory_mb", 7}}}}}};
      return current(file)["recording"]["last_seconds"];
    };
    EXPECT_EQ(images("found"), (Json{{"images", "whole"}, {"memory_mb", 7}}));
    EXPECT_EQ(images("every_nth"), (Json{{"images", "every_nth"}, {"memory_mb", 7}}));
  }
}

TEST(SettingsMigrations, SetAMissingSubstitutionAreaToTheRules) {
  const auto width = [](int version, int before) {
    const Json file{{"version", version}, {"field", {{"goal_substitution_area_width", before}}}};
    return complete_settings(current(file)).at("field").at("goal_substitution_area_width");
  };
  for (const int version : {1, 2}) {
    EXPECT_EQ(width(version, 0), 300);
    EXPECT_EQ(width(version, 408), 408);
  }
  EXPECT_EQ(width(3, 0), 0) << "somebody set it so";
}

TEST(SettingsMigrations, KeepValuesOfTheWrongType) {
  for (const char* text : {"[]", "7", R"({"field": 7})", R"({"field": {"other_computers": 7}})",
                           R"({"field": {"goal_substitution_area_width": "0"}})", R"({"cameras": {}})",
                           R"({"cameras": [7, null]})", R"({"cameras": [{"follow_light": 7}]})",
                           R"({"cameras": [{"follow_light": []}]})", R"({"recording": []})",
                           R"({"recording": 7})", R"({"recording": {"last_seconds": [{"images": "found"}]}})",
                           R"({"recording": {"last_seconds": {"images": 7}}})"}) {
    EXPECT_EQ(current(Json::parse(text)), Json::parse(text)) << text;
  }
}

}  // namespace
}  // namespace sslv::settings_migrations_test
