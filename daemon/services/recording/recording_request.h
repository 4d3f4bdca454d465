// SPDX-License-Identifier: Apache-2.0
#pragma once

// Parses the bodies of requests about recordings.

#include "base/json.h"
#include "web/route.h"

#include <initializer_list>
#include <string>
#include <string_view>

namespace sslv {

/// Throws HttpError if `body` is not an object or has a key that is not in `known`.
void check_keys(const Json& body, std::initializer_list<std::string_view> known);

/// Returns the value of "name", converted to a part of a file name. Throws HttpError if it is invalid.
std::string asked_name(const Json& body);

/// Value of "pinned", the only key that can be changed. Throws HttpError.
bool asked_pinned(const Request& request);

}  // namespace sslv
