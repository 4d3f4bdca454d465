// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sslv {

/// RFC 4648, in one line.
std::string to_base64(std::span<const std::uint8_t> bytes);

/// White space anywhere is allowed. No value for anything else that is no base64, such as a text that was cut
/// off.
std::optional<std::vector<std::uint8_t>> from_base64(std::string_view text);

}  // namespace sslv
