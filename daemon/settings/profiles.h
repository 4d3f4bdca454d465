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

/// Settings that were saved under a name.
struct Profile {
  static constexpr std::size_t kMaxSize = 1'000'000;  // as PatchLimits has it

  std::string name;
  double time_s = 0;  // Unix time when it was saved
  std::string who;    // the client's address
  Json settings = Json::object();
  int version = 1;  // of the settings: see Migrations

  static constexpr auto fields() {
    return std::tuple{text("name", &Profile::name, "what it is called"),
                      number("time", &Profile::time_s, 0.0, 1e12, "s", "Unix time"),
                      text("who", &Profile::who, "the client's address"),
                      object("settings", &Profile::settings, "all of them", kMaxSize),
                      number("version", &Profile::version, 1, 1000000, "", "of the settings")};
  }
};

/// All profiles, by name, kept in a file. May be used from several threads at once.
class Profiles {
 public:
  static constexpr std::size_t kMax = 32;
  static constexpr long kLongestName = 60;  // characters

  /// Kept in profiles.json. A file that cannot be used is set aside (renamed *.rejected).
  explicit Profiles(StateFolder& folder);

  std::vector<Profile> all() const;
  std::optional<Profile> find(const std::string& name) const;

  /// In the place of one with the same name; on disk when it returns. Throws SettingsError for a name that is
  /// not allowed and for one too many, StorageError when it cannot be saved; nothing has changed then.
  void save(Profile profile);
  /// Says whether there was one. Throws StorageError.
  bool remove(const std::string& name);

  // All of them as a file of a backup.
  static constexpr const char* kFileName = "profiles.json";
  /// Nothing where there is no such file.
  std::optional<std::string> to_text() const;
  /// Throws SettingsError, beginning with the file's name.
  static std::vector<Profile> from_text(const std::string& text);
  /// Takes these for all; nothing: no file. On disk when it returns. Throws StorageError; nothing has changed
  /// then.
  void replace(std::optional<std::vector<Profile>> profiles);

 private:
  void put(std::vector<Profile> profiles);  // on disk first

  StateFolder& folder_;
  const std::filesystem::path file_;
  mutable std::mutex mutex_;  // guards what follows
  std::vector<Profile> profiles_;
};

}  // namespace sslv
