// SPDX-License-Identifier: Apache-2.0
#pragma once

// What clients say of recordings in the bodies of their requests.

#include "base/json.h"
#include "web/route.h"

#include <initializer_list>
#include <string>
#include <string_view>

namespace sslv {

/// Throws HttpError for a body with any other key.
void check_keys(const Json& body, std::initializer_list<std::string_view> known);

/// The part of a file's name that stands in `name`. Throws HttpError.
std::string asked_name(const Json& body);

/// The only key that can be changed, "pinned". Throws HttpError.
bool asked_pinned(const Request& request);

}  // namespace sslv
