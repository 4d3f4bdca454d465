// SPDX-License-Identifier: Apache-2.0
#include "settings/passwords.h"

#include "base/error.h"
#include "base/json.h"
#include "settings/store.h"
#include "support/temporary_folder.h"

#include <fstream>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

namespace sslv::passwords_test {
namespace {

using test::TemporaryFolder;
using testing::HasSubstr;
using testing::StartsWith;

std::string what(const auto& act) {
  try {
    act();
  } catch (const SettingsError& error) {
    return error.what();
  }
  return "";
}

class PasswordsTest : public testing::Test {
 protected:
  const TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_.path() / Passwords::kFileName;
};

TEST_F(PasswordsTest, NobodyHasOneAtFirst) {
  Passwords passwords(file_);
  EXPECT_FALSE(passwords.has(Role::kAdmin));
  EXPECT_FALSE(passwords.role_of("").has_value());
  EXPECT_FALSE(std::filesystem::exists(file_));
}

TEST_F(PasswordsTest, TellWhoseAPasswordIs) {
  Passwords passwords(file_);
  passwords.set(Role::kAdmin, "correct horse");
  passwords.set(Role::kViewer, "battery staple");
  const Passwords read_again(file_);
  for (const Passwords* one : {&std::as_const(passwords), &read_again}) {
    EXPECT_EQ(one->role_of("correct horse"), Role::kAdmin);
    EXPECT_EQ(one->role_of("battery staple"), Role::kViewer);
    for (const char* wrong : {"", "correct hors", "correct horse ", "Correct horse"})
      EXPECT_FALSE(one->role_of(wrong).has_value()) << wrong;
    EXPECT_FALSE(one->role_of(std::string("correct horse\0x", 15)).has_value());
    EXPECT_FALSE(one->role_of(std::string(100'000, 'x')).has_value());
  }
}

TEST_F(PasswordsTest, AreHashedInAFileForTheServiceAlone) {
  Passwords passwords(file_);
  passwords.set(Role::kAdmin, "correct horse");
  const Json saved = read_json_file(file_);
  EXPECT_THAT(saved.at("admin").get<std::string>(), StartsWith("$y$"));
  EXPECT_THAT(saved.dump(), testing::Not(HasSubstr("horse")));
  struct stat about {};
  ASSERT_EQ(::stat(file_.c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0777u, 0600u);
  const std::string before = passwords.hash(Role::kAdmin);
  passwords.set(Role::kAdmin, "correct horse");
  EXPECT_NE(passwords.hash(Role::kAdmin), before) << "salted";
}

TEST_F(PasswordsTest, RefusesInvalidPasswords) {
  Passwords passwords(file_);
  EXPECT_EQ(what([&] { passwords.set(Role::kAdmin, "1234567"); }),
            "password: too short; expected 8 .. 200 characters");
  EXPECT_THAT(what([&] { passwords.set(Role::kAdmin, std::string(201, 'x')); }), HasSubstr("too long"));
  EXPECT_THAT(what([&] { passwords.set(Role::kViewer, "battery staple"); }), HasSubstr("admin's password"));
  EXPECT_FALSE(std::filesystem::exists(file_));
  passwords.set(Role::kAdmin, "correct horse");
  passwords.set(Role::kViewer, "battery staple");
  EXPECT_THAT(what([&] { passwords.set(Role::kAdmin, std::nullopt); }), HasSubstr("removed last"));
  EXPECT_EQ(passwords.role_of("correct horse"), Role::kAdmin);
}

TEST_F(PasswordsTest, CanBeTakenAway) {
  Passwords passwords(file_);
  passwords.set(Role::kAdmin, "correct horse");
  passwords.set(Role::kAdmin, std::nullopt);
  EXPECT_FALSE(passwords.has(Role::kAdmin));
  EXPECT_FALSE(std::filesystem::exists(file_));
  passwords.set(Role::kAdmin, std::nullopt);
}

TEST_F(PasswordsTest, SeesWhatAnotherProgramSets) {
  Passwords service(file_), tool(file_);
  tool.set(Role::kAdmin, "correct horse");
  EXPECT_FALSE(service.has(Role::kAdmin));
  service.reload_if_changed();
  EXPECT_EQ(service.role_of("correct horse"), Role::kAdmin);
  tool.set(Role::kAdmin, "battery staple");
  service.reload_if_changed();
  EXPECT_EQ(service.role_of("battery staple"), Role::kAdmin);
}

TEST_F(PasswordsTest, AMissingOrDamagedFileLetsNobodyIn) {
  Passwords passwords(file_);
  passwords.set(Role::kAdmin, "correct horse");
  std::ofstream(file_) << "{";
  passwords.reload_if_changed();
  EXPECT_EQ(passwords.role_of("correct horse"), Role::kAdmin);
  std::filesystem::remove(file_);
  passwords.reload_if_changed();
  EXPECT_TRUE(passwords.has(Role::kAdmin));
  passwords.set(Role::kAdmin, "battery staple");
  EXPECT_EQ(Passwords(file_).role_of("battery staple"), Role::kAdmin);
}

TEST_F(PasswordsTest, AFileThatCannotBeUsedIsRefusedAtStart) {
  for (const char* text :
       {"", "{", "7", "[]", "{}", R"({"viewer": "$y$j9T$x"})", R"({"admin": 7})", R"({"admin": ""})",
        R"({"admin": "plain text"})", R"({"admin": "$y$j9T$abc$", "root": "x"})"}) {
    folder_.write(Passwords::kFileName, text);
    EXPECT_THAT(what([&] { Passwords passwords(file_); }),
                testing::AllOf(StartsWith(file_.string() + ": "), HasSubstr("ssl-visionctl passwd")))
        << text;
  }
}

TEST_F(PasswordsTest, AnUnsavedPasswordIsNotUsed) {
  Passwords passwords("/proc/no/such/folder/passwords.json");
  EXPECT_THROW(passwords.set(Role::kAdmin, "correct horse"), StorageError);
  EXPECT_FALSE(passwords.has(Role::kAdmin));
}

TEST_F(PasswordsTest, AreRestoredFromABackupOnlyIfNoneIsSet) {
  Passwords other(folder_.path() / "other.json");
  other.set(Role::kAdmin, "battery staple");
  const std::string text = other.to_text();
  Passwords passwords(file_);
  EXPECT_TRUE(passwords.restore_if_none(text));
  EXPECT_EQ(passwords.role_of("battery staple"), Role::kAdmin);
  passwords.take_back(text);
  EXPECT_FALSE(passwords.has(Role::kAdmin));
  EXPECT_FALSE(std::filesystem::exists(file_));
  // Another program sets one meanwhile.
  Passwords(file_).set(Role::kAdmin, "correct horse");
  EXPECT_FALSE(passwords.restore_if_none(text));
  passwords.take_back(text);
  EXPECT_EQ(passwords.role_of("correct horse"), Role::kAdmin);
}

TEST(Role, HasAName) {
  for (const Role role : {Role::kViewer, Role::kAdmin}) EXPECT_EQ(role_named(name_of(role)), role);
  EXPECT_FALSE(role_named("root").has_value());
}

}  // namespace
}  // namespace sslv::passwords_test
