// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace sslv {

// Plain text: text for a name, a line of the log or a terminal, displayed as it is in one line. Not plain are
// control characters (C0, DEL, C1), line and paragraph separators, and the characters that change the
// direction of writing (U+061C, U+200E, U+200F, U+202A .. U+202E, U+2066 .. U+2069): they can make a name
// look like another name, and make a terminal or a log show text that was not written.

/// True for valid UTF-8 in which every character is plain, and for empty text.
bool is_plain_text(std::string_view text);

/// Throws SettingsError naming `path` unless the text is plain.
void check_plain_text(std::string_view text, std::string_view path);

/// Replaces each character that is not plain by its escape (\u001b), and each byte that is not UTF-8 by \xff
/// with its value. JSON stays equivalent, because it is valid UTF-8 and the escapes of characters are JSON
/// escapes.
std::string escaped_text(std::string_view text);

/// The same for text of several lines: keeps line breaks.
std::string escaped_lines(std::string_view text);

/// The plain characters of a text.
std::string plain_part(std::string_view text);

}  // namespace sslv
