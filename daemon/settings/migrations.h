// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/error.h"
#include "base/json.h"

#include <string_view>
#include <utility>
#include <vector>

namespace sslv {

/// Makes a settings tree of one version into one of the next, before it is checked: a key that was renamed,
/// say. The tree is as somebody wrote it: keys may be missing or of another type, which is to be left alone.
using Migration = void (*)(Json& tree);

/// At place i, from version i + 1 to version i + 2; so the newest version is one more than there are
/// migrations, and files from before versions were counted are of version 1.
using Migrations = std::vector<Migration>;

inline int newest_version(const Migrations& migrations) {
  return static_cast<int>(migrations.size()) + 1;
}

/// The key of a settings file with its version, beside those of the settings.
inline constexpr std::string_view kVersionKey = "version";

/// The version that a file says it has; 1 where it does not say. Throws SettingsError for what is no version
/// and for one that is newer than this program.
int version_of(const Json& file, const Migrations& migrations);

/// A tree of this version as one of the newest.
Json migrated(Json tree, int version, const Migrations& migrations);

/// A settings file's tree as one of the newest version, without the key that says so. Throws as version_of().
Json up_to_date(Json file, const Migrations& migrations);

/// What `check` makes of a tree from elsewhere: an import, a profile, a step of the history. One without its
/// version is current, or of version 1 where that is refused. Throws SettingsError.
template <class Check>
auto check_any_version(Json tree, const Migrations& migrations, const Check& check) {
  if (tree.is_object() && tree.contains(kVersionKey)) return check(up_to_date(std::move(tree), migrations));
  try {
    return check(tree);
  } catch (const SettingsError&) {
    try {
      return check(migrated(std::move(tree), 1, migrations));
    } catch (const SettingsError&) {  // what was wrong with it as a current one is what counts
    }
    throw;
  }
}

}  // namespace sslv
