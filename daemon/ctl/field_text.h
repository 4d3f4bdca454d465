// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <string>

namespace sslv {

/// Answers to GET /api/field, /api/field/agreement and /api/field/kicks for a terminal.
std::string field_text(const Json& field);
std::string agreement_text(const Json& agreement);
std::string kicks_text(const Json& kicks);

}  // namespace sslv
