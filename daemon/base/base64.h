// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sslv {

/// RFC 4648, without line breaks.
std::string to_base64(std::span<const std::uint8_t> bytes);

/// Ignores white space anywhere. No value for other invalid base64, such as a truncated text.
std::optional<std::vector<std::uint8_t>> from_base64(std::string_view text);

}  // namespace sslv
