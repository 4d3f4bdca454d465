// SPDX-License-Identifier: Apache-2.0
#include "services/settings/settings_routes.h"

#include "base/params_json.h"
#include "config/config.h"
#include "geometry/field.h"

#include <charconv>
#include <string>
#include <string_view>

namespace sslv {

std::optional<std::uint64_t> if_match_of(const Request& request) {
  if (request.if_match.empty()) return std::nullopt;
  // `7`, or `"7"` as HTTP writes entity tags.
  std::string_view digits = request.if_match;
  if (digits.size() > 2 && digits.starts_with('"') && digits.ends_with('"'))
    digits = digits.substr(1, digits.size() - 2);
  std::uint64_t revision = 0;
  const auto [end, error] = std::from_chars(digits.begin(), digits.end(), revision);
  if (error != std::errc() || end != digits.end()) {
    throw HttpError(400, "If-Match: " + request.if_match.substr(0, 40) +
                             " is not allowed; expected the revision the change was made for");
  }
  return revision;
}

Json saved_json(const SettingsStore::Version& version) {
  return {{"revision", version.revision},
          {"version", newest_version(settings_migrations())},
          {"settings", version.settings},
          {"saved", true},
          {"refused", version.refused}};
}

Json field_presets_json() {
  Json presets = Json::array();
  for (const FieldPreset& preset : field_presets()) {
    presets.push_back(
        {{"name", preset.name}, {"description", preset.help}, {"field", params_to_json(preset.size)}});
  }
  return presets;
}

}  // namespace sslv
