// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "base/params.h"

#include <cstddef>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

namespace sslv {

class StateFolder;

/// Settings saved under a name.
struct Profile {
  static constexpr std::size_t kMaxSize = 1'000'000;  // as in PatchLimits

  std::string name;
  double time_s = 0;  // Unix time when it was saved
  std::string who;    // the client's address
  Json settings = Json::object();
  int version = 1;  // version of the settings: see Migrations

  static constexpr auto fields() {
    return std::tuple{text("name", &Profile::name, "name"),
                      number("time", &Profile::time_s, 0.0, 1e12, "s", "Unix time"),
                      text("who", &Profile::who, "the client's address"),
                      object("settings", &Profile::settings, "all settings", kMaxSize),
                      number("version", &Profile::version, 1, 1000000, "", "of the settings")};
  }
};

/// All profiles, by name, stored in a file. Thread-safe.
class Profiles {
 public:
  static constexpr std::size_t kMax = 32;
  static constexpr long kLongestName = 60;  // characters

  /// Stored in profiles.json. An unusable file is set aside (renamed *.rejected).
  explicit Profiles(StateFolder& folder);

  std::vector<Profile> all() const;
  std::optional<Profile> find(const std::string& name) const;

  /// Adds a profile or replaces the profile of the same name. On return, the change is on disk. Throws
  /// SettingsError for an invalid name and for too many profiles, StorageError if it cannot be saved; nothing
  /// has changed then.
  void save(Profile profile);
  /// Returns whether there was such a profile. Throws StorageError.
  bool remove(const std::string& name);

  // For backups, which contain all profiles as one file.
  static constexpr const char* kFileName = "profiles.json";
  /// Returns the file's content; nothing if there are no profiles and no file.
  std::optional<std::string> to_text() const;
  /// Throws SettingsError, beginning with the file's name, if the text is invalid.
  static std::vector<Profile> from_text(const std::string& text);
  /// Replaces all profiles; std::nullopt removes the file. On return, the change is on disk. Throws
  /// StorageError; nothing has changed then.
  void replace(std::optional<std::vector<Profile>> profiles);

 private:
  void put(std::vector<Profile> profiles);  // writes to disk first

  StateFolder& folder_;
  const std::filesystem::path file_;
  mutable std::mutex mutex_;  // guards the members below
  std::vector<Profile> profiles_;
};

}  // namespace sslv
