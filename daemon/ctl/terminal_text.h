// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <string>

namespace sslv {

// A server's words on their way to a terminal. It may be any server: what it sends is shown as text and never
// as something the terminal obeys (plain_text.h).

/// An answer with every text and key in it escaped, so that it is one line and shows as what it is.
Json plain_answer(const Json& answer);

/// An answer as JSON: the same JSON for every reader, and safe for a terminal. `indent`: -1 for one line.
std::string json_text(const Json& answer, int indent = 2);

/// An answer as JSON, or as `text` has it for people.
std::string answer_text(const Json& answer, bool as_json, std::string (*text)(const Json&));

}  // namespace sslv
