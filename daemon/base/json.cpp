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

Json parse_bounded_json(std::string_view text) {
  constexpr int kMaxDepth = 64, kMaxKeys = 1000;
  std::array<int, kMaxDepth + 2> keys{};
  const auto check = [&keys](int depth, Json::parse_event_t event, const Json&) {
    if (depth > kMaxDepth)
      throw std::length_error("JSON nested deeper than " + std::to_string(kMaxDepth) + " levels");
    const auto place = static_cast<std::size_t>(depth);
    if (event == Json::parse_event_t::object_start) keys[place + 1] = 0;
    if (event == Json::parse_event_t::key && ++keys[place] > kMaxKeys)
      throw std::length_error("JSON with more than " + std::to_string(kMaxKeys) + " keys in an object");
    return true;
  };
  return Json::parse(text, check);
}

}  // namespace sslv
