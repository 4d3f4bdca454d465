// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>

namespace sslv {

/// Limits a text for a message to `max_bytes`. A longer text is cut, never inside a UTF-8 character, and ends
/// in "...".
inline std::string shortened(std::string_view text, std::size_t max_bytes = 60) {
  constexpr std::string_view kCut = "...";
  if (text.size() <= max_bytes) return std::string(text);
  std::size_t end = max_bytes > kCut.size() ? max_bytes - kCut.size() : 0;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
  return std::string(text.substr(0, end)) + std::string(kCut);
}

/// A setting that cannot be used. The text is one line for the admin: where (file, JSON pointer of the key),
/// the value, and what is allowed. At start, the error ends the program with exit code 78 (EX_CONFIG); at run
/// time, the change is refused and the old settings stay in effect.
struct SettingsError : std::runtime_error {
  /// Maximum length of the text, which may quote long values.
  static constexpr std::size_t kMaxBytes = 4000;
  /// `text`: one line, truncated to kMaxBytes.
  explicit SettingsError(std::string_view text) : runtime_error(shortened(text, kMaxBytes)) {}
};

/// A requested resource is busy now but may be free in a moment, for example a port that another program
/// holds. The text is one line for the admin, as in SettingsError. At start, the error ends the program with
/// exit code 75 (EX_TEMPFAIL), and the service manager tries again.
struct BusyError : SettingsError {
  using SettingsError::SettingsError;
};

/// A file that cannot be written or read. The text is one line.
struct StorageError : std::runtime_error {
  using runtime_error::runtime_error;
};

}  // namespace sslv
