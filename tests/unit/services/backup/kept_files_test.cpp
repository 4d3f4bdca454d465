// SPDX-License-Identifier: Apache-2.0
#include "services/backup/kept_files.h"

#include "support/temporary_folder.h"

#include <gtest/gtest.h>

namespace sslv::kept_files_test {
namespace {

class KeptPasswords : public testing::Test {
 protected:
  static BackupFiles backup_of(const std::string& password) {
    const test::TemporaryFolder folder;
    Passwords passwords(folder.path() / Passwords::kFileName);
    passwords.set(Role::kAdmin, password);
    return {{Passwords::kFileName, passwords.to_text()}};
  }

  const test::TemporaryFolder folder_;
  Passwords passwords_{folder_.path() / Passwords::kFileName};
  PasswordsPart part_{passwords_};
};

TEST_F(KeptPasswords, AreRestoredWhereThereAreNone) {
  const auto restored = part_.prepare(backup_of("battery staple"));
  restored->save();
  EXPECT_TRUE(part_.has_restored());
  EXPECT_EQ(passwords_.role_of("battery staple"), Role::kAdmin);
  restored->take_back();
  EXPECT_FALSE(part_.has_restored());
  EXPECT_FALSE(passwords_.has(Role::kAdmin));
}

TEST_F(KeptPasswords, APasswordSetWhileABackupIsReadIsKept) {
  const auto restored = part_.prepare(backup_of("battery staple"));
  passwords_.set(Role::kAdmin, "correct horse");
  restored->save();
  EXPECT_FALSE(part_.has_restored());
  EXPECT_EQ(passwords_.role_of("correct horse"), Role::kAdmin);
  restored->take_back();
  EXPECT_EQ(passwords_.role_of("correct horse"), Role::kAdmin);
}

TEST_F(KeptPasswords, APasswordSetWhileABackupIsSavedIsKept) {
  const auto restored = part_.prepare(backup_of("battery staple"));
  restored->save();
  passwords_.set(Role::kAdmin, "correct horse");
  restored->take_back();
  EXPECT_EQ(passwords_.role_of("correct horse"), Role::kAdmin);
}

}  // namespace
}  // namespace sslv::kept_files_test
