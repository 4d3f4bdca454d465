// SPDX-License-Identifier: Apache-2.0
#include "services/backup/kept_files.h"

#include "base/log.h"

#include <exception>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace sslv {
namespace {

class RestoredProfiles final : public SavedWith {
 public:
  RestoredProfiles(Profiles& profiles, std::optional<std::vector<Profile>> next)
      : profiles_(profiles), next_(std::move(next)) {}
  void save() override {
    if (profiles_.to_text()) old_ = profiles_.all();
    profiles_.replace(next_);
  }
  void take_back() noexcept override {
    try {
      profiles_.replace(old_);
    } catch (const std::exception& error) {
      log::error("profiles of a refused backup were not removed: {}", error.what());
    }
  }

 private:
  Profiles& profiles_;
  const std::optional<std::vector<Profile>> next_;
  std::optional<std::vector<Profile>> old_;  // nullopt: there was no file
};

class RestoredPasswords final : public SavedWith {
 public:
  RestoredPasswords(Passwords& passwords, std::optional<std::string> text, bool& is_restored)
      : passwords_(passwords), text_(std::move(text)), is_restored_(is_restored) {}
  void save() override { is_restored_ = text_ && passwords_.restore_if_none(*text_); }
  void take_back() noexcept override {
    try {
      if (std::exchange(is_restored_, false)) passwords_.take_back(*text_);
    } catch (const std::exception& error) {
      log::error("passwords of a refused backup were not removed: {}", error.what());
    }
  }

 private:
  Passwords& passwords_;
  const std::optional<std::string> text_;
  bool& is_restored_;
};

std::optional<std::string> part_text_in(BackupFiles& files, const char* name) {
  const auto found = files.find(name);
  return found == files.end() ? std::nullopt : std::optional(std::move(found->second));
}

}  // namespace

BackupFiles ProfilesPart::files(const Config& /*config*/) const {
  const auto text = profiles_.to_text();
  return text ? BackupFiles{{Profiles::kFileName, *text}} : BackupFiles{};
}

std::unique_ptr<SavedWith> ProfilesPart::prepare(BackupFiles files) {
  const auto text = part_text_in(files, Profiles::kFileName);
  return std::make_unique<RestoredProfiles>(profiles_,
                                            text ? std::optional(Profiles::from_text(*text)) : std::nullopt);
}

BackupFiles PasswordsPart::files(const Config& /*config*/) const {
  const std::string text = passwords_.to_text();
  return text.empty() ? BackupFiles{} : BackupFiles{{Passwords::kFileName, text}};
}

std::unique_ptr<SavedWith> PasswordsPart::prepare(BackupFiles files) {
  const auto text = part_text_in(files, Passwords::kFileName);
  if (text) Passwords::check_text(*text);
  has_restored_ = false;
  return std::make_unique<RestoredPasswords>(passwords_, text, has_restored_);
}

}  // namespace sslv
