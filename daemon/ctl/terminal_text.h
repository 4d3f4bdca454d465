// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <string>

namespace sslv {

// Text from a server for a terminal. The server may be any server, so its text is escaped: the terminal shows
// it and never interprets it (base/plain_text.h).

/// Escapes every text and key of an answer, so that each is one line and is shown unchanged.
Json plain_answer(const Json& answer);

/// An answer as JSON that has the same meaning for every parser and is safe for a terminal. `indent`: -1 for
/// one line.
std::string terminal_json(const Json& answer, int indent = 2);

/// An answer as JSON, or as human-readable text by `text`.
std::string answer_text(const Json& answer, bool as_json, std::string (*text)(const Json&));

}  // namespace sslv
