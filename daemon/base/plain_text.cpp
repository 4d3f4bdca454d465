// SPDX-License-Identifier: Apache-2.0
#include "base/plain_text.h"

#include "base/error.h"

#include <cstddef>

#include <fmt/format.h>
#include <glib.h>

namespace sslv {
namespace {

bool changes_direction(gunichar c) {
  return c == 0x061C || c == 0x200E || c == 0x200F || (c >= 0x202A && c <= 0x202E) ||
         (c >= 0x2066 && c <= 0x2069);
}

bool is_plain(gunichar c) {
  return g_unichar_iscntrl(c) == FALSE && c != 0x2028 && c != 0x2029 && !changes_direction(c);
}

/// Calls `plain` with the bytes of each plain character, `other` with each other character and `broken` with
/// each byte that is not UTF-8.
template <class Plain, class Other, class Broken>
void walk(std::string_view text, const Plain& plain, const Other& other, const Broken& broken) {
  constexpr auto kFirstError = static_cast<gunichar>(-2);
  while (!text.empty()) {
    // GLib treats a zero byte as the end.
    const gunichar c =
        text.front() == '\0' ? 0 : g_utf8_get_char_validated(text.data(), static_cast<gssize>(text.size()));
    std::size_t size = 1;
    if (c >= kFirstError) {
      broken(static_cast<unsigned char>(text.front()));
    } else {
      size = static_cast<std::size_t>(g_unichar_to_utf8(c, nullptr));
      is_plain(c) ? plain(text.substr(0, size)) : other(c);
    }
    text.remove_prefix(size);
  }
}

std::string escaped(std::string_view text, bool keep_lines) {
  std::string out;
  out.reserve(text.size());
  walk(
      text, [&](std::string_view bytes) { out += bytes; },
      [&](gunichar c) { out += keep_lines && c == '\n' ? "\n" : fmt::format("\\u{:04x}", c); },
      [&](unsigned char byte) { out += fmt::format("\\x{:02x}", byte); });
  return out;
}

}  // namespace

bool is_plain_text(std::string_view text) {
  bool all = true;
  const auto refuse = [&](auto) { all = false; };
  walk(
      text, [](std::string_view) {}, refuse, refuse);
  return all;
}

void check_plain_text(std::string_view text, std::string_view path) {
  if (is_plain_text(text)) return;
  constexpr std::size_t kMaxShown = 60;
  const std::string shown = escaped_text(text);
  throw SettingsError(
      fmt::format("{}: \"{}\"{} is not allowed; expected a text without control characters and "
                  "without characters that change the direction of writing",
                  path, plain_part(shown.substr(0, kMaxShown)), shown.size() > kMaxShown ? "..." : ""));
}

std::string escaped_text(std::string_view text) {
  return escaped(text, false);
}

std::string escaped_lines(std::string_view text) {
  return escaped(text, true);
}

std::string plain_part(std::string_view text) {
  std::string out;
  walk(
      text, [&](std::string_view bytes) { out += bytes; }, [](gunichar) {}, [](unsigned char) {});
  return out;
}

}  // namespace sslv
