// SPDX-License-Identifier: Apache-2.0
#include "settings/passwords.h"

#include "base/log.h"
#include "settings/store.h"

#include <cstring>
#include <system_error>
#include <utility>

#include <crypt.h>
#include <fmt/format.h>
#include <sys/stat.h>

namespace sslv {
namespace {

constexpr std::array kRoles{Role::kViewer, Role::kAdmin};
constexpr const char* kSetAgain = "; set them again with: ssl-visionctl passwd";

std::size_t place(Role role) {
  return static_cast<std::size_t>(role);
}

/// crypt(3) of a password with the method and salt of a hash, or with a new salt.
std::string crypted(const std::string& password, const std::string& salt) {
  const auto room = std::make_unique<crypt_data>();
  const char* made = crypt_r(password.c_str(), salt.c_str(), room.get());
  // An error is returned as a text that is not a hash.
  if (made == nullptr || made[0] == '*') throw std::runtime_error("crypt: the password cannot be hashed");
  return made;
}

std::string new_hash(const std::string& password) {
  std::array<char, CRYPT_GENSALT_OUTPUT_SIZE> salt{};
  if (crypt_gensalt_rn("$y$", 0, nullptr, 0, salt.data(), static_cast<int>(salt.size())) == nullptr)
    throw std::runtime_error("crypt: no salt: " + std::string(std::strerror(errno)));
  return crypted(password, salt.data());
}

bool fits(const std::string& password, const std::string& hash) {
  const std::string made = crypted(password, hash);
  unsigned char difference = made.size() == hash.size() ? 0 : 1;
  for (std::size_t i = 0; i < made.size() && i < hash.size(); ++i)
    difference = static_cast<unsigned char>(difference | (made[i] ^ hash[i]));
  return difference == 0;
}

std::string text_of(const std::array<std::string, 2>& hashes) {
  Json saved = Json::object();
  for (const Role role : kRoles) {
    if (!hashes[place(role)].empty()) saved[std::string(name_of(role))] = hashes[place(role)];
  }
  return saved.empty() ? "" : json_text(saved, 2) + "\n";
}

void check(const std::string& password) {
  if (password.size() >= Passwords::kShortest && password.size() <= Passwords::kLongest &&
      password.find('\0') == std::string::npos)
    return;
  throw SettingsError(fmt::format("password: too {}; expected {} .. {} characters",
                                  password.size() < Passwords::kShortest ? "short" : "long",
                                  Passwords::kShortest, Passwords::kLongest));
}

}  // namespace

std::string_view name_of(Role role) {
  return role == Role::kAdmin ? "admin" : "viewer";
}

std::optional<Role> role_named(std::string_view name) {
  for (const Role role : kRoles) {
    if (name == name_of(role)) return role;
  }
  return std::nullopt;
}

Passwords::Passwords(std::filesystem::path file)
    : file_(std::move(file)), stamp_(stamp_of(file_)), hashes_(stamp_ ? read(file_) : Hashes{}) {}

std::optional<Passwords::Stamp> Passwords::stamp_of(const std::filesystem::path& file) {
  struct stat about {};
  if (::stat(file.c_str(), &about) != 0) return std::nullopt;
  return Stamp{static_cast<long>(about.st_ino), about.st_mtim.tv_sec, about.st_mtim.tv_nsec,
               static_cast<long>(about.st_size)};
}

Passwords::Hashes Passwords::read(const std::filesystem::path& file) {
  Json saved;
  try {
    saved = read_json_file(file);
  } catch (const SettingsError& error) {
    throw SettingsError(error.what() + std::string(kSetAgain));
  }
  return hashes_in(saved, file.string());
}

Passwords::Hashes Passwords::hashes_in(const Json& saved, const std::string& file) {
  Hashes hashes;
  const auto refuse = [&] {
    throw SettingsError(fmt::format(
        "{}: expected the hash of an admin's password, and optionally of the viewers'{}", file, kSetAgain));
  };
  if (!saved.is_object() || !saved.contains(name_of(Role::kAdmin))) refuse();
  for (const auto& [name, hash] : saved.items()) {
    const auto role = role_named(name);
    // A hash unknown to crypt would fail at every sign-in.
    if (!role || !hash.is_string() ||
        crypt_checksalt(hash.get_ref<const std::string&>().c_str()) != CRYPT_SALT_OK)
      refuse();
    hashes[place(*role)] = hash.get<std::string>();
  }
  return hashes;
}

Passwords::Hashes Passwords::hashes_in(const std::string& text) {
  Json saved;
  try {
    saved = parse_bounded_json(text);
  } catch (const std::exception& error) {
    throw SettingsError(fmt::format("{}: {}", kFileName, error.what()));
  }
  return hashes_in(saved, kFileName);
}

std::string Passwords::hash(Role role) const {
  return (*hashes_.load())[place(role)];
}

std::optional<Role> Passwords::role_of(const std::string& password) const {
  if (password.size() > kLongest || password.find('\0') != std::string::npos) return std::nullopt;
  const auto hashes = hashes_.load();
  for (const Role role : {Role::kAdmin, Role::kViewer}) {
    const std::string& hash = (*hashes)[place(role)];
    if (!hash.empty() && fits(password, hash)) return role;
  }
  return std::nullopt;
}

void Passwords::set(Role role, const std::optional<std::string>& password) {
  if (password) check(*password);
  const std::string hash = password ? new_hash(*password) : "";
  const std::lock_guard lock(mutex_);
  Hashes next = *hashes_.load();
  next[place(role)] = hash;
  if (next[place(Role::kAdmin)].empty() && !next[place(Role::kViewer)].empty())
    throw SettingsError("the admin's password must be set first and removed last");
  put(std::move(next));
}

std::string Passwords::to_text() const {
  return text_of(*hashes_.load());
}

void Passwords::check_text(const std::string& text) {
  hashes_in(text);
}

bool Passwords::restore_if_none(const std::string& text) {
  Hashes next = hashes_in(text);
  const std::lock_guard lock(mutex_);
  read_if_changed();
  if (has(Role::kAdmin)) return false;
  put(std::move(next));
  return true;
}

void Passwords::take_back(const std::string& restored) {
  const Hashes before = hashes_in(restored);
  const std::lock_guard lock(mutex_);
  read_if_changed();
  if (*hashes_.load() == before) put({});
}

void Passwords::put(Hashes next) {
  const std::string saved = text_of(next);
  std::error_code error;
  std::filesystem::create_directories(file_.parent_path(), error);
  if (saved.empty()) {
    if (!std::filesystem::remove(file_, error) && error)
      throw StorageError(fmt::format("cannot remove {}: {}", file_.string(), error.message()));
  } else {
    write_file_durably(file_, saved, 0600);
  }
  stamp_ = stamp_of(file_);
  hashes_.store(std::move(next));
}

void Passwords::reload_if_changed() {
  const std::lock_guard lock(mutex_);
  read_if_changed();
}

void Passwords::read_if_changed() {
  const auto now = stamp_of(file_);
  if (!now || now == stamp_) return;
  stamp_ = now;
  try {
    hashes_.store(read(file_));
    log::info("the panel's passwords were changed");
  } catch (const SettingsError& error) {
    log::error("the panel's passwords are unchanged: {}", error.what());
  }
}

}  // namespace sslv
