// SPDX-License-Identifier: Apache-2.0
#include "settings/bounded_patch.h"

#include "base/error.h"

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

/// A member of an operation that is text; empty when it is not there or none: nlohmann's library says so.
std::string text_of(const Json& operation, const char* key) {
  const auto found = operation.is_object() ? operation.find(key) : operation.end();
  return operation.is_object() && found != operation.end() && found->is_string() ? found->get<std::string>()
                                                                                 : std::string();
}

/// What one part of a path leads to; null when there is no such thing.
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

/// Whether a place would be in a number, a text or the like: the library asserts that it is not, or does
/// nothing.
bool is_in_primitive(const Json& document, std::string_view path) {
  for (const Json* at = &document; at != nullptr && path.starts_with('/');) {
    if (at->is_primitive()) return !at->is_null();  // what is added to null makes it an object
    const std::string_view token = path.substr(1, path.find('/', 1) - 1);
    path.remove_prefix(1 + token.size());
    at = child(*at, token);
  }
  return false;
}

/// Keys that may be looked through on the way to a place, as objects keep the order of theirs, and elements
/// beside it, which may have to move.
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
      const bool value_is_elsewhere = op == "copy" || op == "move";
      if (value_is_elsewhere) {
        const Json::json_pointer place(from);
        if (document.contains(place)) value = &document.at(place);
      } else if (operation.is_object() && operation.contains("value")) {
        value = &operation.at("value");
      }
      const JsonExtent extent = value != nullptr ? extent_of(*value, limits.size) : JsonExtent{};
      work += 1 + extent.size + work_on_the_way(document, path) +
              (value_is_elsewhere ? work_on_the_way(document, from) : 0);
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
      if (op != "test" && op != "replace" && is_in_primitive(document, path)) {
        throw SettingsError(fmt::format(
            "not a JSON Patch that fits the settings: {} is not in a list or an object", shortened(path)));
      }
      document.patch_inplace(Json::array({operation}));
    }
  } catch (const Json::exception& error) {
    throw SettingsError(
        fmt::format("not a JSON Patch that fits the settings: {}", shortened(error.what(), 300)));
  }
  return document;
}

}  // namespace sslv
