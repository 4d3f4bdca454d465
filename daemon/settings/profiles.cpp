// SPDX-License-Identifier: Apache-2.0
#include "settings/profiles.h"

#include "base/log.h"
#include "base/params_json.h"
#include "base/plain_text.h"
#include "settings/state_folder.h"

#include <algorithm>
#include <exception>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <glib.h>

namespace sslv {
namespace {

struct File {
  std::vector<Profile> profiles;
  static constexpr auto fields() { return std::tuple{list("profiles", &File::profiles, "by name")}; }
};

std::string text_of(const File& file) {
  return json_text(params_to_json(file), 2) + "\n";
}

/// A name must also fit between two slashes of a URL.
void check_name(const std::string& name) {
  if (is_plain_text(name) && !name.empty() && g_utf8_strlen(name.c_str(), -1) <= Profiles::kLongestName &&
      name.find('/') == std::string::npos && name.front() != '.' && name.front() != ' ' && name.back() != ' ')
    return;
  throw SettingsError(
      fmt::format("name: {} is not allowed; expected 1 .. {} printable characters without a slash, a dot at "
                  "the beginning or a space at either end",
                  shortened(escaped_text(json_text(Json(name)))), Profiles::kLongestName));
}

auto place_of(std::vector<Profile>& profiles, const std::string& name) {
  return std::find_if(profiles.begin(), profiles.end(),
                      [&](const Profile& profile) { return profile.name == name; });
}

}  // namespace

Profiles::Profiles(StateFolder& folder) : folder_(folder), file_(folder.path() / kFileName) {
  remove_leftover(file_);
  std::error_code ignored;
  if (!std::filesystem::exists(file_, ignored)) return;
  try {
    profiles_ = params_from_json<File>(read_json_file(file_), "").profiles;
  } catch (const SettingsError& error) {
    log::error("the profiles cannot be used and were set aside as {}: {}", set_aside(file_).string(),
               error.what());
  }
}

std::vector<Profile> Profiles::all() const {
  const std::lock_guard lock(mutex_);
  return profiles_;
}

std::optional<Profile> Profiles::find(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  for (const Profile& profile : profiles_) {
    if (profile.name == name) return profile;
  }
  return std::nullopt;
}

void Profiles::save(Profile profile) {
  check_name(profile.name);
  const std::lock_guard lock(mutex_);
  std::vector<Profile> next = profiles_;
  const auto old = place_of(next, profile.name);
  if (old != next.end()) {
    *old = std::move(profile);
  } else if (next.size() == kMax) {
    throw SettingsError(fmt::format("there are {} profiles already, the maximum; delete one first", kMax));
  } else {
    const auto after = std::find_if(next.begin(), next.end(),
                                    [&](const Profile& other) { return other.name > profile.name; });
    next.insert(after, std::move(profile));
  }
  put(std::move(next));
}

bool Profiles::remove(const std::string& name) {
  const std::lock_guard lock(mutex_);
  std::vector<Profile> next = profiles_;
  const auto old = place_of(next, name);
  if (old == next.end()) return false;
  next.erase(old);
  put(std::move(next));
  return true;
}

std::optional<std::string> Profiles::to_text() const {
  const std::lock_guard lock(mutex_);
  std::error_code ignored;
  if (profiles_.empty() && !std::filesystem::exists(file_, ignored)) return std::nullopt;
  return text_of(File{profiles_});
}

std::vector<Profile> Profiles::from_text(const std::string& text) {
  try {
    std::vector<Profile> profiles = params_from_json<File>(parse_bounded_json(text), "").profiles;
    if (profiles.size() > kMax) throw SettingsError(fmt::format("it has more than {} profiles", kMax));
    for (const Profile& profile : profiles) check_name(profile.name);
    const auto in_order = [](const Profile& one, const Profile& next) { return one.name >= next.name; };
    if (std::adjacent_find(profiles.begin(), profiles.end(), in_order) != profiles.end())
      throw SettingsError("its profiles are not sorted by name, or a name occurs twice");
    return profiles;
  } catch (const std::exception& error) {
    throw SettingsError(fmt::format("{}: {}", kFileName, error.what()));
  }
}

void Profiles::replace(std::optional<std::vector<Profile>> profiles) {
  const std::lock_guard lock(mutex_);
  if (profiles) return put(*std::move(profiles));
  remove_file(file_);
  profiles_.clear();
}

void Profiles::put(std::vector<Profile> profiles) {
  File file{std::move(profiles)};
  folder_.write(file_, text_of(file));
  profiles_ = std::move(file.profiles);
}

}  // namespace sslv
