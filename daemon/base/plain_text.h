// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace sslv {

// What may stand in a name, a line of the log or a terminal: text that shows as what it is, in one line. Not
// plain are control characters (C0, DEL, C1), line and paragraph separators, and the characters that change
// the direction of writing (U+061C, U+200E, U+200F, U+202A .. U+202E, U+2066 .. U+2069): with these a name
// can look like another one, and a terminal or a log can be made to show what is not there.

/// Whether it is valid UTF-8 and every character is plain. Empty text is.
bool is_plain_text(std::string_view text);

/// Throws SettingsError naming `path` unless it is.
void check_plain_text(std::string_view text, std::string_view path);

/// The text with \u001b in the place of a character that is not plain, and \xff in that of a byte that is not
/// UTF-8. Also within JSON, which stays the same JSON: there only characters are replaced.
std::string escaped_text(std::string_view text);

/// The same, but line breaks stay: text of several lines.
std::string escaped_lines(std::string_view text);

/// The plain characters of a text.
std::string plain_part(std::string_view text);

}  // namespace sslv
