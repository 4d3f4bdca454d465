// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <string>

namespace sslv {

/// For a terminal, of the answers to GET /api/field, /api/field/agreement and /api/field/kicks.
std::string field_text(const Json& field);
std::string agreement_text(const Json& agreement);
std::string kicks_text(const Json& kicks);

}  // namespace sslv
