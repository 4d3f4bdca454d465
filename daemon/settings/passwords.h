// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "base/snapshot.h"

#include <array>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

namespace sslv {

/// Roles that can have a password. An admin may do everything that a viewer may.
enum class Role { kViewer, kAdmin };

std::string_view name_of(Role role);
std::optional<Role> role_named(std::string_view name);

/// The panel's passwords: a JSON file with a hash (yescrypt, crypt(5)) for each role that has a password,
/// readable by the service alone. Passwords are not settings: no export, history, profile, log or support
/// bundle contains them, and a backup contains them only on request. Thread-safe; `ssl-visionctl passwd` may
/// change the file at any time.
class Passwords {
 public:
  static constexpr std::size_t kShortest = 8, kLongest = 200;  // bytes
  /// File name in the state folder.
  static constexpr const char* kFileName = "passwords.json";

  /// Throws SettingsError if the file exists and is not usable, so that nobody gets access by mistake.
  explicit Passwords(std::filesystem::path file);

  bool has(Role role) const { return !hash(role).empty(); }
  /// Returns the role's hash; empty without a password. A different hash means that the password changed.
  std::string hash(Role role) const;

  /// Returns the role with this password. Deliberately takes about ten milliseconds and 16 MiB.
  std::optional<Role> role_of(const std::string& password) const;

  /// Sets a role's password, or removes it for nullopt. On return, the change is on disk. Throws
  /// SettingsError for a password that is too short or too long, and if only viewers would have a password;
  /// StorageError if it cannot be saved.
  void set(Role role, const std::optional<std::string>& password);

  /// The file's content, for a backup; empty if there are no passwords.
  std::string to_text() const;
  /// Throws SettingsError, beginning with the file's name, if `text` is not a valid passwords file.
  static void check_text(const std::string& text);
  /// Restores passwords from the text of a to_text(), unless an admin's password exists by now; returns
  /// whether it restored them. Throws like check_text(), and StorageError if they cannot be saved.
  bool restore_if_none(const std::string& text);
  /// Removes all passwords again unless they were changed since restore_if_none(restored). Throws like
  /// restore_if_none().
  void take_back(const std::string& restored);

  /// Reloads the file if it was changed. A file that is missing or not usable changes nothing.
  void reload_if_changed();

 private:
  using Hashes = std::array<std::string, 2>;  // indexed by role
  struct Stamp {                              // identifies the version of the file that was read
    long inode = 0, seconds = 0, nanoseconds = 0, size = 0;
    bool operator==(const Stamp&) const = default;
  };
  static Hashes read(const std::filesystem::path& file);
  /// `file`: its name, for error messages.
  static Hashes hashes_in(const Json& saved, const std::string& file);
  static Hashes hashes_in(const std::string& text);
  // To be called with mutex_ held:
  void put(Hashes hashes);  // writes to disk first
  void read_if_changed();
  static std::optional<Stamp> stamp_of(const std::filesystem::path& file);

  const std::filesystem::path file_;
  std::mutex mutex_;  // guards the stamp; held while the file is written
  std::optional<Stamp> stamp_;
  Snapshot<Hashes> hashes_;
};

}  // namespace sslv
