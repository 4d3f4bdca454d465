// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

namespace sslv {

/// Keeps the order of keys, so that a settings file is written back in its original order.
using Json = nlohmann::ordered_json;

// Compiling the library's writer and parser takes seconds, so only these functions use them.

/// `indent`: spaces for each level; -1: all in one line. Bytes that are not UTF-8 become U+FFFD.
std::string json_text(const Json& value, int indent = -1);

/// Whether all texts are UTF-8, so that json_text() keeps them.
bool is_utf8(const Json& value);

/// The library's message without its exception's number.
std::string reason_of(const Json::exception& error);

/// Parses a text of our own. Throws Json::parse_error.
Json parse_own_json(std::string_view text);

/// Extent of a value with everything it contains. `size`: number of values plus bytes of texts and keys.
/// `depth`: nesting levels, 1 for a value without children.
struct JsonExtent {
  std::size_t size = 0, depth = 0;
};

/// Stops counting soon after `max_size`. Not recursive, so deep nesting cannot overflow the stack.
JsonExtent extent_of(const Json& value, std::size_t max_size);

/// Memory limit of JSON from outside. Settings are copied twice while they are validated.
inline constexpr std::size_t kMaxJsonBytes = 16 * 1024 * 1024;

/// Parses a text from outside. Limits: `max_bytes` of memory once parsed, 64 levels, and 1000 keys per
/// object, because an ordered object searches all its keys for each new one. Throws std::length_error naming
/// the exceeded limit, and Json::exception if the text is not JSON.
Json parse_bounded_json(std::string_view text, std::size_t max_bytes = kMaxJsonBytes);

}  // namespace sslv
