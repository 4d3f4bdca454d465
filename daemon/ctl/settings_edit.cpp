// SPDX-License-Identifier: Apache-2.0
#include "ctl/settings_edit.h"

#include "ctl/change_text.h"
#include "ctl/table.h"
#include "settings/history.h"

#include <algorithm>
#include <cstdint>
#include <stdexcept>

#include <fmt/format.h>

namespace sslv {
namespace {

Json::json_pointer pointer_of(const std::string& text) {
  try {
    return Json::json_pointer(text);
  } catch (const Json::exception&) {
    throw std::runtime_error(fmt::format(
        "\"{}\" is not a place in the settings; expected a JSON pointer such as /field/field_length", text));
  }
}

std::string keys_of(const Json& value) {
  if (value.is_array()) return fmt::format("a list of {}", value.size());
  if (!value.is_object()) return "nothing below it";
  std::string out;
  for (const auto& [key, below] : value.items()) out += (out.empty() ? "" : ", ") + key;
  return out.empty() ? "nothing" : out;
}

// ---- schema

/// A part of the schema and its place.
struct SchemaPart {
  const Json* schema;
  std::string key;  // JSON Pointer
  std::string of;   // title of the oneOf alternative with this key; empty: in all alternatives
};

bool is_entry(const std::string& token) {
  return token == "*" || token == "-" ||
         (!token.empty() &&
          std::all_of(token.begin(), token.end(), [](char c) { return c >= '0' && c <= '9'; }));
}

/// The parts one step below; more than one if several alternatives have the key.
std::vector<SchemaPart> below(const SchemaPart& part, const std::string& token) {
  const Json& schema = *part.schema;
  const auto has = [&](const Json& object) {
    return object.contains("properties") && object["properties"].contains(token);
  };
  if (has(schema)) return {{&schema["properties"][token], part.key + "/" + token, part.of}};
  if (schema.contains("items") && is_entry(token)) return {{&schema["items"], part.key + "/*", part.of}};
  std::vector<SchemaPart> out;
  if (!schema.contains("oneOf")) return out;
  for (const Json& one : schema["oneOf"]) {
    if (has(one))
      out.push_back({&one["properties"][token], part.key + "/" + token, one.at("title").get<std::string>()});
  }
  return out;
}

std::string joined(const Json& list, const char* between) {
  std::string out;
  for (const Json& one : list) {
    out += (out.empty() ? "" : between) + (one.is_string() ? one.get<std::string>() : json_text(one));
  }
  return out;
}

std::string type_of(const Json& schema) {
  if (!schema.contains("type")) return schema.contains("const") ? "string" : "";
  const Json& type = schema["type"];
  std::string out = type.is_array() ? joined(type, "|") : type.get<std::string>();
  if (schema.contains("items")) out += " of " + type_of(schema["items"]);
  return out;
}

std::string range_of(const Json& schema) {
  if (schema.contains("const")) return joined(Json::array({schema["const"]}), "");
  if (schema.contains("enum")) return joined(schema["enum"], " | ");
  if (schema.contains("minimum"))
    return fmt::format("{} .. {}", schema["minimum"].get<double>(), schema.at("maximum").get<double>());
  return schema.contains("items") ? range_of(schema["items"]) : "";
}

void add_rows(const SchemaPart& part, std::vector<std::vector<std::string>>& rows) {
  const Json& schema = *part.schema;
  const bool is_group = schema.contains("properties");
  if (!part.key.empty() && (!is_group || schema.at("type").is_array())) {
    rows.push_back({part.key, type_of(schema), range_of(schema), schema.value("x-unit", ""),
                    (part.of.empty() ? "" : part.of + ": ") + schema.value("description", "")});
  }
  if (is_group) {
    for (const auto& [name, one] : schema["properties"].items())
      add_rows({&one, part.key + "/" + name, part.of}, rows);
  }
  if (schema.contains("items") && schema["items"].contains("properties"))
    add_rows({&schema["items"], part.key + "/*", part.of}, rows);
  if (schema.contains("oneOf")) {
    for (const Json& one : schema["oneOf"])
      add_rows({&one, part.key, one.at("title").get<std::string>()}, rows);
  }
}

}  // namespace

const Json& value_at(const Json& tree, const std::string& pointer) {
  const Json::json_pointer place = pointer_of(pointer);
  if (tree.contains(place)) return tree.at(place);
  Json::json_pointer parent = place;
  while (!tree.contains(parent)) parent.pop_back();
  throw std::runtime_error(fmt::format("{}: no such setting; {} has {}", pointer,
                                       parent.empty() ? "the tree" : parent.to_string(),
                                       keys_of(tree.at(parent))));
}

Json json_or_text(const std::string& word) {
  const Json value = Json::parse(word, nullptr, false);
  return value.is_discarded() ? Json(word) : value;
}

Json patch_that_sets(const Json& tree, const std::vector<std::pair<std::string, std::string>>& pairs) {
  Json patch = Json::array();
  for (const auto& [pointer, word] : pairs) {
    // "add" would insert into a list instead of replacing an entry.
    patch.push_back({{"op", tree.contains(pointer_of(pointer)) ? "replace" : "add"},
                     {"path", pointer},
                     {"value", json_or_text(word)}});
  }
  return patch;
}

Json edit_settings(const Client& daemon, const Json& read, const Json& patch, bool dry_run) {
  if (dry_run) return {{"changes", daemon.post("/api/settings/check", patch).at("changes")}};
  return edit_between(read, daemon.patch("/api/settings", patch, read.at("revision").get<std::uint64_t>()));
}

Json edit_between(const Json& before, const Json& after) {
  return {{"changes", changes_between(before.at("settings"), after.at("settings"))},
          {"revision", after.at("revision")}};
}

std::string edit_text(const Json& edit) {
  return changes_text(edit.at("changes")) +
         (edit.contains("revision")
              ? fmt::format("saved, revision {}\n", edit.at("revision").get<std::uint64_t>())
              : "only checked, nothing was saved\n");
}

std::string schema_text(const Json& schema, const std::string& pointer) {
  std::vector<SchemaPart> parts{{&schema, "", ""}};
  // Pointers can only be split from the back.
  std::vector<std::string> tokens;
  for (Json::json_pointer rest = pointer_of(pointer); !rest.empty(); rest.pop_back())
    tokens.push_back(rest.back());
  for (auto token = tokens.rbegin(); token != tokens.rend(); ++token) {
    std::vector<SchemaPart> next;
    for (const SchemaPart& part : parts) {
      for (const SchemaPart& one : below(part, *token)) next.push_back(one);
    }
    if (next.empty()) throw std::runtime_error(fmt::format("{}: no such setting", pointer));
    parts = std::move(next);
  }
  std::vector<std::vector<std::string>> rows;
  for (const SchemaPart& part : parts) add_rows(part, rows);
  return table_text({{"key"}, {"type"}, {"range"}, {"unit"}, {"help"}}, rows);
}

}  // namespace sslv
