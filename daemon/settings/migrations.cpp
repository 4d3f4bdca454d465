// SPDX-License-Identifier: Apache-2.0
#include "settings/migrations.h"

#include "base/error.h"

#include <string>
#include <utility>

#include <fmt/format.h>

namespace sslv {

int version_of(const Json& file, const Migrations& migrations) {
  const auto found = file.is_object() ? file.find(kVersionKey) : file.end();
  if (found == file.end()) return 1;
  const int newest = newest_version(migrations);
  if (!found->is_number_integer() || found->get<std::int64_t>() < 1) {
    throw SettingsError(
        fmt::format("/{}: {} is not allowed; expected a whole number 1 .. {}, or nothing for 1", kVersionKey,
                    found->dump(-1, ' ', false, Json::error_handler_t::replace), newest));
  }
  if (found->get<std::int64_t>() > newest) {
    throw SettingsError(fmt::format(
        "/{}: {} is newer than this program, which knows settings up to version {}; install the program that "
        "they were made for",
        kVersionKey, found->dump(), newest));
  }
  return found->get<int>();
}

Json migrated(Json tree, int version, const Migrations& migrations) {
  for (auto i = static_cast<std::size_t>(version - 1); i < migrations.size(); ++i) migrations[i](tree);
  return tree;
}

Json up_to_date(Json file, const Migrations& migrations) {
  const int version = version_of(file, migrations);
  if (file.is_object()) file.erase(kVersionKey);
  return migrated(std::move(file), version, migrations);
}

}  // namespace sslv
