// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <string>

namespace sslv {

/// Human-readable text for BackupContents of docs/openapi.json.
std::string backup_text(const Json& contents);

/// The same for the result of a restore: {"backup": BackupContents, "revision": 7, "passwords": "none"}.
std::string restored_text(const Json& restored);

}  // namespace sslv
