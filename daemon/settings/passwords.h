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

/// Whom the panel has passwords for. An admin may do all that a viewer may.
enum class Role { kViewer, kAdmin };

std::string_view name_of(Role role);
std::optional<Role> role_named(std::string_view name);

/// The panel's passwords: a JSON file with a hash (yescrypt, crypt(5)) for each role that has one, readable
/// by the service alone. They are no settings: no export, history, profile, log or support bundle has them,
/// and a backup only where somebody asks for it. May be used from any thread; `ssl-visionctl passwd` may
/// change the file meanwhile.
class Passwords {
 public:
  static constexpr std::size_t kShortest = 8, kLongest = 200;  // bytes
  /// The name of the file in the state folder.
  static constexpr const char* kFileName = "passwords.json";

  /// Throws SettingsError when there is such a file and it cannot be used: nobody is let in by mistake.
  explicit Passwords(std::filesystem::path file);

  bool has(Role role) const { return !hash(role).empty(); }
  /// Empty without a password. Another one means that the password was changed.
  std::string hash(Role role) const;

  /// Whose password this is. Takes some ten milliseconds and 16 MiB by intent.
  std::optional<Role> role_of(const std::string& password) const;

  /// On disk when it returns; none takes the role's password away. Throws SettingsError for a password that
  /// is too short or too long, and for an admin's that is taken away while the viewers have one; StorageError
  /// when it cannot be saved.
  void set(Role role, const std::optional<std::string>& password);

  /// What the file holds, for a backup; empty where there is none.
  std::string to_text() const;
  /// Throws SettingsError, beginning with the file's name, for what is no such text.
  static void check_text(const std::string& text);
  /// Takes over what to_text() returned, unless there is an admin's password by now: whether it did. Throws
  /// likewise, and StorageError when it cannot be saved.
  bool restore_if_none(const std::string& text);
  /// There is none again, unless they were changed since restore_if_none(). Throws likewise.
  void take_back(const std::string& restored);

  /// Reads the file again if it was changed. One that is gone or cannot be used changes nothing.
  void reload_if_changed();

 private:
  using Hashes = std::array<std::string, 2>;  // by role
  struct Stamp {                              // of the file that was read
    long inode = 0, seconds = 0, nanoseconds = 0, size = 0;
    bool operator==(const Stamp&) const = default;
  };
  static Hashes read(const std::filesystem::path& file);
  /// `file`: its name, for the text of the error.
  static Hashes hashes_in(const Json& saved, const std::string& file);
  static Hashes hashes_in(const std::string& text);
  // With the mutex held.
  void put(Hashes hashes);  // on disk first
  void read_if_changed();
  static std::optional<Stamp> stamp_of(const std::filesystem::path& file);

  const std::filesystem::path file_;
  std::mutex mutex_;  // guards the stamp; held while the file is written
  std::optional<Stamp> stamp_;
  Snapshot<Hashes> hashes_;
};

}  // namespace sslv
