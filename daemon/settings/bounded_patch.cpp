// SPDX-License-Identifier: Apache-2.0
#include "settings/bounded_patch.h"

#include "base/error.h"
#include "base/params_json.h"

#include <algorithm>
#include <charconv>
#include <string>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

namespace sslv {
namespace {

std::size_t depth_of(const std::string& path) {
  return static_cast<std::size_t>(std::count(path.begin(), path.end(), '/'));
}

/// Text member of an operation; empty if it is missing or not text, which nlohmann's library reports.
std::string text_of(const Json& operation, const char* key) {
  const auto found = operation.is_object() ? operation.find(key) : operation.end();
  return operation.is_object() && found != operation.end() && found->is_string() ? found->get<std::string>()
                                                                                 : std::string();
}

/// The child that one part of a path refers to; null if there is none.
const Json* child(const Json& parent, std::string_view token) {
  if (parent.is_array()) {
    std::size_t i = 0;
    const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), i);
    const bool is_there = error == std::errc() && end == token.data() + token.size() && i < parent.size();
    return is_there ? &parent[i] : nullptr;
  }
  if (!parent.is_object()) return nullptr;
  std::string key;
  for (std::size_t i = 0; i < token.size(); ++i) {
    const bool is_escaped = token[i] == '~' && i + 1 < token.size();
    key += is_escaped ? (token[++i] == '1' ? '/' : '~') : token[i];
  }
  const auto found = parent.find(key);
  return found == parent.end() ? nullptr : &*found;
}

/// Whether a path leads into a number, a text or another primitive value. For such a path, the library either
/// fails an assertion or ignores the operation.
bool is_in_primitive(const Json& document, std::string_view path) {
  for (const Json* at = &document; at != nullptr && path.starts_with('/');) {
    if (at->is_primitive()) return !at->is_null();  // adding to null makes it an object
    const std::string_view token = path.substr(1, path.find('/', 1) - 1);
    path.remove_prefix(1 + token.size());
    at = child(*at, token);
  }
  return false;
}

/// Number of keys and elements along a path: objects keep the order of their keys, so all keys may be
/// searched, and the elements of a list may have to move.
std::size_t work_on_the_way(const Json& document, std::string_view path) {
  std::size_t work = 0;
  for (const Json* at = &document; at != nullptr && at->is_structured() && path.starts_with('/');) {
    work += at->size();
    const std::string_view token = path.substr(1, path.find('/', 1) - 1);
    path.remove_prefix(1 + token.size());
    at = child(*at, token);
  }
  return work;
}

[[noreturn]] void refuse_shape(const Json& found) {
  refuse("not a JSON Patch that fits the settings", found,
         R"(a list of objects such as [{"op": "replace", "path": "/site", "value": "Field 2"}])");
}

}  // namespace

Json apply_patch(Json document, const Json& patch, const PatchLimits& limits) {
  const auto refuse = [](const std::string& what, std::size_t most) {
    throw SettingsError(fmt::format("a JSON Patch with {} than {} is not allowed", what, most));
  };
  try {
    if (!patch.is_array()) refuse_shape(patch);
    if (patch.size() > limits.operations) refuse("more operations", limits.operations);
    std::size_t size = extent_of(document, limits.size).size, work = 0;
    for (const Json& operation : patch) {
      if (!operation.is_object()) refuse_shape(operation);
      const std::string op = text_of(operation, "op"), path = text_of(operation, "path"),
                        from = text_of(operation, "from");
      const Json* value = nullptr;  // the value that the operation reads or moves
      const bool value_is_elsewhere = op == "copy" || op == "move";
      if (value_is_elsewhere) {
        const Json::json_pointer place(from);
        if (document.contains(place)) value = &document.at(place);
      } else if (operation.contains("value")) {
        value = &operation.at("value");
      }
      const JsonExtent extent = value != nullptr ? extent_of(*value, limits.size) : JsonExtent{};
      work += 1 + extent.size + work_on_the_way(document, path) +
              (value_is_elsewhere ? work_on_the_way(document, from) : 0);
      if (op != "test" && op != "remove") {
        if (depth_of(path) + extent.depth > limits.depth) refuse("values nested deeper", limits.depth);
        // Replaced or moved values are not subtracted until the sum exceeds the limit.
        size += extent.size + path.size();
        if (size > limits.size) {
          work += limits.size;
          size = extent_of(document, limits.size).size + extent.size + path.size();
          if (size > limits.size) refuse("a result with more values and bytes", limits.size);
        }
      }
      if (work > limits.work) refuse("more work", limits.work);
      if (op != "test" && op != "replace" && is_in_primitive(document, path)) {
        throw SettingsError(fmt::format(
            "not a JSON Patch that fits the settings: {} is not in a list or an object", shortened(path)));
      }
      document.patch_inplace(Json::array({operation}));
    }
  } catch (const Json::exception& error) {
    throw SettingsError(
        fmt::format("not a JSON Patch that fits the settings: {}", shortened(reason_of(error), 300)));
  }
  return document;
}

}  // namespace sslv
