// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "tracking/tracks.h"

namespace sslv {

/// FieldTracks of docs/openapi.json, with the newest kick.
Json to_json(const TrackedField& tracked);
/// FieldKick of docs/openapi.json.
Json to_json(const TrackedKick& kick);

}  // namespace sslv
