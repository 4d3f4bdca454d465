// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace sslv {

// Plain text: text for a name, a log line or a terminal, displayed unchanged on one line. It contains no
// control characters (C0, DEL, C1), no line or paragraph separators, and no characters that change the
// direction of writing (U+061C, U+200E, U+200F, U+202A .. U+202E, U+2066 .. U+2069). Those characters can
// make one name look like another, and can forge text in a log or terminal.

/// True for valid UTF-8 in which every character is plain, and for empty text.
bool is_plain_text(std::string_view text);

/// Throws SettingsError naming `path` unless the text is plain.
void check_plain_text(std::string_view text, std::string_view path);

/// Replaces each character that is not plain by its escape (\u001b), and each byte that is not UTF-8 by \x
/// and its value (\xff). JSON stays equivalent, because it is valid UTF-8 and the escapes of characters are
/// JSON escapes.
std::string escaped_text(std::string_view text);

/// The same for text of several lines: keeps line breaks.
std::string escaped_lines(std::string_view text);

/// The plain characters of a text.
std::string plain_part(std::string_view text);

}  // namespace sslv
