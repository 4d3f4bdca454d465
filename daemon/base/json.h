// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string_view>

#include <nlohmann/json.hpp>

namespace sslv {

/// Keeps the order in which keys were written, so that a settings file reads back as it was laid out.
using Json = nlohmann::ordered_json;

/// How much a value is, and all in it: values and bytes of text (keys too) together, and how deep they are
/// nested; 1 for a value that holds no other.
struct JsonExtent {
  std::size_t size = 0, depth = 0;
};

/// Stops soon after `max_size`. Needs no stack: values may be nested deeply.
JsonExtent extent_of(const Json& value, std::size_t max_size);

/// Of a JSON from elsewhere, in memory. Settings are copied twice while they are checked.
inline constexpr std::size_t kMaxJsonBytes = 16 * 1024 * 1024;

/// A text from elsewhere: at most `max_bytes` once it is read, 64 levels, and 1000 keys in an object, for an
/// object that keeps the order of its keys looks all of them through for each new one. Throws
/// std::length_error where it has more, saying so, and Json::exception where it is not JSON.
Json parse_bounded_json(std::string_view text, std::size_t max_bytes = kMaxJsonBytes);

}  // namespace sslv
