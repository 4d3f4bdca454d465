// SPDX-License-Identifier: Apache-2.0
#include "settings/profiles.h"

#include "base/error.h"
#include "settings/state_folder.h"

#include <fstream>

#include <gmock/gmock.h>
#include <unistd.h>

namespace sslv::profiles_test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

class ProfilesTest : public testing::Test {
 protected:
  ~ProfilesTest() override { std::filesystem::remove_all(folder_); }

  static std::vector<std::string> names(const Profiles& profiles) {
    std::vector<std::string> out;
    for (const Profile& profile : profiles.all()) out.push_back(profile.name);
    return out;
  }
  static std::string refusal(Profiles& profiles, const std::string& name) {
    try {
      profiles.save({name, 1, "Mia", Json::object()});
    } catch (const SettingsError& error) {
      return error.what();
    }
    return "not refused";
  }

  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("profiles_test." + std::to_string(::getpid()));
  const std::filesystem::path file_ = folder_ / "state/profiles.json";
  StateFolder state_{folder_ / "state"};
};

TEST_F(ProfilesTest, OutliveTheDaemonInTheOrderOfTheirNames) {
  {
    Profiles profiles(state_);
    EXPECT_TRUE(profiles.all().empty());
    profiles.save({"night", 1.5, "Mia", {{"site", "hall"}}});
    profiles.save({"Äther 日本", 2, "Tom", Json::object()});
    profiles.save({"day", 3, "Tom", Json::object()});
  }
  const Profiles profiles(state_);
  EXPECT_THAT(names(profiles), ElementsAre("day", "night", "Äther 日本"));
  const auto night = profiles.find("night");
  ASSERT_TRUE(night);
  EXPECT_EQ(night->time_s, 1.5);
  EXPECT_EQ(night->who, "Mia");
  EXPECT_EQ(night->settings, (Json{{"site", "hall"}}));
  EXPECT_FALSE(profiles.find("evening"));
}

TEST_F(ProfilesTest, ANewOneTakesThePlaceOfItsName) {
  Profiles profiles(state_);
  profiles.save({"night", 1, "Mia", {{"site", "hall"}}});
  profiles.save({"night", 2, "Tom", {{"site", "field"}}});
  EXPECT_THAT(names(profiles), ElementsAre("night"));
  EXPECT_EQ(profiles.find("night")->settings["site"], "field");
}

TEST_F(ProfilesTest, OneMayBeRemoved) {
  Profiles profiles(state_);
  profiles.save({"night", 1, "Mia", Json::object()});
  EXPECT_FALSE(profiles.remove("day"));
  EXPECT_TRUE(profiles.remove("night"));
  EXPECT_TRUE(profiles.all().empty());
  EXPECT_TRUE(Profiles(state_).all().empty());
}

TEST_F(ProfilesTest, NamesAreShortPrintableText) {
  Profiles profiles(state_);
  const auto repeated = [](const std::string& text, int times) {
    std::string out;
    for (int i = 0; i < times; ++i) out += text;
    return out;
  };
  EXPECT_EQ(refusal(profiles, repeated("ä", 60)), "not refused");
  EXPECT_EQ(refusal(profiles, "Division B (evening, 2/3)"),
            "name: \"Division B (evening, 2/3)\" is not allowed; expected 1 .. 60 printable characters "
            "without a slash, a dot at the beginning or a space at either end");
  for (const std::string& name :
       {std::string(), repeated("ä", 61), std::string("a\nb"), std::string("a\0b", 3), std::string("a\xff"),
        std::string("\u202eb"), std::string("a\u009b"), std::string(" a"), std::string("a "),
        std::string(".."), std::string("."), std::string("a/b")}) {
    EXPECT_THAT(refusal(profiles, name), AllOf(StartsWith("name: "), HasSubstr("1 .. 60 printable"))) << name;
  }
  EXPECT_EQ(profiles.all().size(), 1u);
}

TEST_F(ProfilesTest, TheirNumberIsLimited) {
  Profiles profiles(state_);
  for (std::size_t i = 0; i < Profiles::kMax; ++i)
    profiles.save({std::to_string(i), 1, "Mia", Json::object()});
  EXPECT_THAT(refusal(profiles, "one more"), HasSubstr("there are 32 profiles already"));
  EXPECT_EQ(refusal(profiles, "7"), "not refused");  // replaced
  EXPECT_EQ(Profiles(state_).all().size(), Profiles::kMax);
}

TEST_F(ProfilesTest, AFailedSaveChangesNothing) {
  Profiles profiles(state_);
  profiles.save({"night", 1, "Mia", Json::object()});
  std::filesystem::create_directories(file_.string() + ".new");  // blocks writing the new file
  EXPECT_THROW(profiles.save({"day", 1, "Mia", Json::object()}), StorageError);
  EXPECT_THROW(profiles.remove("night"), StorageError);
  EXPECT_THAT(names(profiles), ElementsAre("night"));
}

TEST_F(ProfilesTest, AFileThatCannotBeUsedIsSetAside) {
  std::filesystem::create_directories(file_.parent_path());
  std::ofstream(file_) << R"({"profiles": [{"name": 7}]})";
  EXPECT_TRUE(Profiles(state_).all().empty());
  EXPECT_FALSE(std::filesystem::exists(file_));
  EXPECT_TRUE(std::filesystem::exists(file_.string() + ".rejected"));
}

}  // namespace
}  // namespace sslv::profiles_test
