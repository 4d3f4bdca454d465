// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "settings/store.h"
#include "web/route.h"

#include <cstdint>
#include <optional>

namespace sslv {

/// The revision that the request names in If-Match. Throws HttpError 400.
std::optional<std::uint64_t> if_match_of(const Request& request);

/// docs/openapi.json's answer to what was saved.
Json saved_json(const SettingsStore::Version& version);

Json field_presets_json();

}  // namespace sslv
