// SPDX-License-Identifier: Apache-2.0
#include "base/base64.h"

#include <memory>

#include <glib.h>

namespace sslv {
namespace {

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

/// Whether the text is complete, valid base64. GLib would ignore invalid characters and a missing end.
bool is_whole(std::string_view text) {
  std::size_t digits = 0, padding = 0;
  for (const char c : text) {
    if (is_space(c)) continue;
    const bool is_digit = g_ascii_isalnum(c) || c == '+' || c == '/';
    if (c == '=') {
      ++padding;
    } else if (!is_digit || padding > 0) {
      return false;
    }
    ++digits;
  }
  return digits % 4 == 0 && padding <= 2;
}

}  // namespace

std::string to_base64(std::span<const std::uint8_t> bytes) {
  const std::unique_ptr<gchar, decltype(&g_free)> text(g_base64_encode(bytes.data(), bytes.size()), &g_free);
  return text.get();
}

std::optional<std::vector<std::uint8_t>> from_base64(std::string_view text) {
  if (!is_whole(text)) return std::nullopt;
  std::vector<std::uint8_t> out(text.size() / 4 * 3 + 3);
  gint state = 0;
  guint save = 0;
  out.resize(g_base64_decode_step(text.data(), text.size(), out.data(), &state, &save));
  return out;
}

}  // namespace sslv
