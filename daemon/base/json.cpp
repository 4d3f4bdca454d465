// SPDX-License-Identifier: Apache-2.0
#include "base/json.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace sslv {

JsonExtent extent_of(const Json& value, std::size_t max_size) {
  JsonExtent out;
  std::vector<std::pair<const Json*, std::size_t>> left{{&value, 1}};
  while (!left.empty() && out.size <= max_size) {
    const auto [at, depth] = left.back();
    left.pop_back();
    out.depth = std::max(out.depth, depth);
    ++out.size;
    if (at->is_string()) {
      out.size += at->get_ref<const std::string&>().size();
    } else if (at->is_array()) {
      for (const Json& one : *at) left.emplace_back(&one, depth + 1);
    } else if (at->is_object()) {
      for (const auto& [key, one] : at->items()) {
        out.size += key.size();
        left.emplace_back(&one, depth + 1);
      }
    }
  }
  return out;
}

Json parse_bounded_json(std::string_view text, std::size_t max_bytes) {
  constexpr int kMaxDepth = 64, kMaxKeys = 1000;
  // About what the library takes: a few bytes of text, "[],", become a hundred of memory.
  constexpr std::size_t kBytesOfValue = 32, kBytesOfText = 32, kBytesOfKey = 48, kBytesOfList = 32;
  std::array<int, kMaxDepth + 2> keys{};
  std::size_t bytes = 0;
  const auto check = [&](int depth, Json::parse_event_t event, const Json& parsed) {
    if (depth > kMaxDepth)
      throw std::length_error("JSON nested deeper than " + std::to_string(kMaxDepth) + " levels");
    const auto place = static_cast<std::size_t>(depth);
    switch (event) {
      case Json::parse_event_t::object_start: keys[place + 1] = 0; [[fallthrough]];
      case Json::parse_event_t::array_start: bytes += kBytesOfValue + kBytesOfList; break;
      case Json::parse_event_t::key:
        if (++keys[place] > kMaxKeys)
          throw std::length_error("JSON with more than " + std::to_string(kMaxKeys) + " keys in an object");
        bytes += kBytesOfKey + parsed.get_ref<const std::string&>().size();
        break;
      case Json::parse_event_t::value:
        bytes += kBytesOfValue;
        if (parsed.is_string()) bytes += kBytesOfText + parsed.get_ref<const std::string&>().size();
        break;
      default: break;
    }
    if (bytes > max_bytes)
      throw std::length_error("JSON that takes more than " + std::to_string(max_bytes >> 20U) +
                              " MiB of memory");
    return true;
  };
  return Json::parse(text, check);
}

}  // namespace sslv
