// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

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

}  // namespace sslv
