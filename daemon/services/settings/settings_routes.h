// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "settings/store.h"
#include "web/route.h"

#include <cstdint>
#include <optional>

namespace sslv {

/// Returns the revision in the request's If-Match header; nothing without one. Throws HttpError 400.
std::optional<std::uint64_t> if_match_of(const Request& request);

/// Answer to a request that saved settings, as in docs/openapi.json.
Json saved_json(const SettingsStore::Version& version);

Json field_presets_json();

}  // namespace sslv
