// SPDX-License-Identifier: Apache-2.0
#include "settings/bounded_patch.h"

#include "base/error.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace sslv {
namespace {

struct Extent {
  std::size_t size = 0, depth = 0;
};

/// Of a value and all in it; stops soon after `most` of size. Needs no stack: values may be nested deeply.
Extent extent_of(const Json& value, std::size_t most) {
  Extent out;
  std::vector<std::pair<const Json*, std::size_t>> left{{&value, 1}};
  while (!left.empty() && out.size <= most) {
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

std::size_t depth_of(const std::string& path) {
  return static_cast<std::size_t>(std::count(path.begin(), path.end(), '/'));
}

/// A member of an operation that is text; empty when it is not there or none: nlohmann's library says so.
std::string text_of(const Json& operation, const char* key) {
  const auto found = operation.is_object() ? operation.find(key) : operation.end();
  return operation.is_object() && found != operation.end() && found->is_string() ? found->get<std::string>()
                                                                                 : std::string();
}

/// Elements beside a value that is added or taken away, which may have to move.
std::size_t elements_beside(const Json& document, const std::string& path) {
  if (path.empty()) return 0;
  const Json::json_pointer parent = Json::json_pointer(path).parent_pointer();
  if (!document.contains(parent)) return 0;
  const Json& beside = document.at(parent);
  return beside.is_array() ? beside.size() : 0;
}

}  // namespace

Json apply_patch(Json document, const Json& patch, const PatchLimits& limits) {
  const auto refuse = [](const std::string& what, std::size_t most) {
    throw SettingsError(fmt::format("a JSON Patch with {} than {} is not allowed", what, most));
  };
  try {
    if (patch.is_array() && patch.size() > limits.operations) refuse("more operations", limits.operations);
    std::size_t size = extent_of(document, limits.size).size, work = 0;
    if (!patch.is_array()) document.patch_inplace(patch);  // it says what is wrong
    for (const Json& operation : patch) {
      const std::string op = text_of(operation, "op"), path = text_of(operation, "path"),
                        from = text_of(operation, "from");
      const Json* value = nullptr;  // that is read or moved
      if (op == "copy" || op == "move") {
        const Json::json_pointer place(from);
        if (document.contains(place)) value = &document.at(place);
      } else if (operation.is_object() && operation.contains("value")) {
        value = &operation.at("value");
      }
      const Extent extent = value != nullptr ? extent_of(*value, limits.size) : Extent{};
      work += extent.size + elements_beside(document, path) + elements_beside(document, from);
      if (op != "test" && op != "remove") {
        if (depth_of(path) + extent.depth > limits.depth) refuse("values nested deeper", limits.depth);
        // What is replaced or moved away is not taken off until the sum is too much.
        size += extent.size + path.size();
        if (size > limits.size) {
          work += limits.size;
          size = extent_of(document, limits.size).size + extent.size + path.size();
          if (size > limits.size) refuse("a result of more values and bytes", limits.size);
        }
      }
      if (work > limits.work) refuse("more to do", limits.work);
      document.patch_inplace(Json::array({operation}));
    }
  } catch (const Json::exception& error) {
    throw SettingsError(fmt::format("not a JSON Patch that fits the settings: {}", error.what()));
  }
  return document;
}

}  // namespace sslv
