// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/backup_part.h"
#include "settings/passwords.h"
#include "settings/profiles.h"

namespace sslv {

class ProfilesPart final : public BackupPart {
 public:
  explicit ProfilesPart(Profiles& profiles) : profiles_(profiles) {}
  BackupFiles files(const Config& config) const override;
  bool has(const std::string& name) const override { return name == Profiles::kFileName; }
  std::unique_ptr<SavedWith> prepare(BackupFiles files) override;

 private:
  Profiles& profiles_;
};

/// Hashes of passwords. A computer that already has a password keeps it: a person who may change settings
/// must not be able to set another password without knowing the current one.
class PasswordsPart final : public BackupPart {
 public:
  explicit PasswordsPart(Passwords& passwords) : passwords_(passwords) {}
  BackupFiles files(const Config& config) const override;
  bool has(const std::string& name) const override { return name == Passwords::kFileName; }
  std::unique_ptr<SavedWith> prepare(BackupFiles files) override;
  /// Whether the passwords of the backup that was prepared last were restored.
  bool has_restored() const { return has_restored_; }

 private:
  Passwords& passwords_;
  bool has_restored_ = false;
};

}  // namespace sslv
