// SPDX-License-Identifier: Apache-2.0
#include "base/json.h"

#include <algorithm>
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

}  // namespace sslv
