// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "tracking/tracks.h"

namespace sslv {

/// As docs/openapi.json's FieldTracks, with the newest kick.
Json to_json(const TrackedField& tracked);
/// As its FieldKick.
Json to_json(const TrackedKick& kick);

}  // namespace sslv
