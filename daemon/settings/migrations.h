// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/error.h"
#include "base/json.h"

#include <string_view>
#include <utility>
#include <vector>

namespace sslv {

/// Turns a settings tree of one version into a tree of the next version, for example by renaming a key. The
/// tree is not validated yet: keys may be missing or have another type; leave those unchanged.
using Migration = void (*)(Json& tree);

/// Element i migrates from version i + 1 to i + 2. So the newest version is the number of migrations plus
/// one. Files that were written before there were versions have version 1.
using Migrations = std::vector<Migration>;

inline int newest_version(const Migrations& migrations) {
  return static_cast<int>(migrations.size()) + 1;
}

/// The key of the version in a settings file, beside the settings' own keys.
inline constexpr std::string_view kVersionKey = "version";

/// Returns a file's version; 1 if it has none. Throws SettingsError for an invalid version and for a version
/// newer than this program's newest one.
int version_of(const Json& file, const Migrations& migrations);

/// Returns a tree of this version, migrated to the newest version.
Json migrated(Json tree, int version, const Migrations& migrations);

/// Returns a settings file's tree, migrated to the newest version and without kVersionKey. Throws like
/// version_of().
Json up_to_date(Json file, const Migrations& migrations);

/// Returns the result of `check` for a tree from elsewhere: an import, a profile, a step of the history. A
/// tree without a version is checked as a tree of the newest version and, if that fails, of version 1. Throws
/// SettingsError.
template <class Check>
auto check_any_version(Json tree, const Migrations& migrations, const Check& check) {
  if (tree.is_object() && tree.contains(kVersionKey)) return check(up_to_date(std::move(tree), migrations));
  try {
    return check(tree);
  } catch (const SettingsError&) {
    try {
      return check(migrated(std::move(tree), 1, migrations));
    } catch (const SettingsError&) {  // report the problems found in the newest version
    }
    throw;
  }
}

}  // namespace sslv
