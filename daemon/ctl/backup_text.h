// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <string>

namespace sslv {

/// BackupContents of docs/openapi.json, for people.
std::string backup_text(const Json& contents);

/// {"backup": BackupContents, "revision": 7, "passwords": "none"} once it was restored.
std::string restored_text(const Json& restored);

}  // namespace sslv
