// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace sslv {

/// 64 hexadecimal digits.
std::string sha256_of(std::string_view bytes);

}  // namespace sslv
