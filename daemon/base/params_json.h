// SPDX-License-Identifier: Apache-2.0
#pragma once

// JSON <-> parameter structs (params.h). Paths are JSON pointers (RFC 6901); every error names the path, the
// value and the allowed values. Contains heavy templates: include this file only where settings are read or
// written.

#include "base/error.h"
#include "base/json.h"
#include "base/params.h"
#include "base/plain_text.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>

namespace sslv {

/// Ignored in every object: JSON has no comments, but sample settings need them.
inline constexpr std::string_view kCommentKey = "//";

template <class T>
struct IsOptional : std::false_type {
  using Value = T;
};
template <class T>
struct IsOptional<std::optional<T>> : std::true_type {
  using Value = T;
};

[[noreturn]] inline void refuse(const std::string& path, const Json& value, const std::string& allowed) {
  const std::string shown = shortened(escaped_text(json_text(value)));
  throw SettingsError(path + ": " + shown + " is not allowed; expected " + allowed);
}

/// Throws SettingsError if the list has more than `max_items` entries.
inline void check_count(const std::string& path, const Json& list, std::size_t max_items) {
  if (list.size() <= max_items) return;
  throw SettingsError(path + ": " + std::to_string(list.size()) +
                      " entries are not allowed; expected at most " + std::to_string(max_items));
}

/// Characters (Unicode code points), as JSON Schema counts them.
inline std::size_t length_of(std::string_view text) {
  return static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

inline std::string read_text(const Json& json, const std::string& path, std::size_t max_length,
                             std::string_view what) {
  if (!json.is_string()) refuse(path, json, std::string(what));
  const auto& text = json.get_ref<const std::string&>();
  if (length_of(text) > max_length)
    refuse(path, json, std::string(what) + " of at most " + std::to_string(max_length) + " characters");
  check_plain_text(text, path);
  return text;
}

inline std::string with_unit(const std::string& text, std::string_view unit) {
  return unit.empty() ? text : text + " " + std::string(unit);
}

// ---- reading: the struct's present values are the defaults for keys that are absent

template <class P>
void read_params(P& params, const Json& json, const std::string& path);

template <class V, class Limit>
V read_number(const Json& json, const std::string& path, Limit min, Limit max, std::string_view unit) {
  constexpr bool kInteger = std::is_integral_v<V>;
  const std::string allowed = with_unit(
      (kInteger ? "a whole number " : "a number ") + json_text(Json(min)) + " .. " + json_text(Json(max)),
      unit);
  const bool whole =
      json.is_number_integer() || (json.is_number() && json.get<double>() == std::floor(json.get<double>()));
  if (!json.is_number() || (kInteger && !whole)) refuse(path, json, allowed);
  const double value = json.get<double>();
  // Negated so that NaN fails too.
  if (!(value >= static_cast<double>(min) && value <= static_cast<double>(max))) refuse(path, json, allowed);
  return json.get<V>();
}

/// The subobject of `params` that has the member: `params` itself or a base class.
template <class P, class V>
P& owner_of(std::type_identity_t<P>& params, V P::*) {
  return params;
}
template <class P, class V>
const P& owner_of(const std::type_identity_t<P>& params, V P::*) {
  return params;
}

template <class P, class V, class L>
void read_field(P& params, const NumberField<P, V, L>& field, const Json& json, const std::string& path) {
  if constexpr (IsOptional<V>::value) {
    if (json.is_null()) {
      params.*field.member = std::nullopt;
    } else {
      params.*field.member =
          read_number<typename IsOptional<V>::Value>(json, path, field.min, field.max, field.unit);
    }
  } else {
    params.*field.member = read_number<V>(json, path, field.min, field.max, field.unit);
  }
}

template <class P>
void read_field(P& params, const FlagField<P>& field, const Json& json, const std::string& path) {
  if (!json.is_boolean()) refuse(path, json, "true or false");
  params.*field.member = json.get<bool>();
}

template <class P>
void read_field(P& params, const TextField<P>& field, const Json& json, const std::string& path) {
  if (field.is_secret) {
    if (!json.is_string()) refuse(path, "(hidden)", "a text");
    params.*field.member = json.get<std::string>();
    return;
  }
  params.*field.member = read_text(json, path, field.max_length, "a text");
}

template <class P, class V, class E, std::size_t N>
void read_field(P& params, const ChoiceField<P, V, E, N>& field, const Json& json, const std::string& path) {
  std::string allowed = "one of";
  if constexpr (IsOptional<V>::value) {
    if (json.is_null()) {
      params.*field.member = std::nullopt;
      return;
    }
    allowed = "null or one of";
  }
  for (const auto& choice : field.choices) {
    if (json.is_string() && json.get_ref<const std::string&>() == choice.name) {
      params.*field.member = choice.value;
      return;
    }
    allowed += " \"" + std::string(choice.name) + "\"";
  }
  refuse(path, json, allowed);
}

template <class P, class S>
void read_field(P& params, const GroupField<P, S>& field, const Json& json, const std::string& path) {
  if constexpr (IsOptional<S>::value) {
    if (json.is_null()) {
      params.*field.member = std::nullopt;
    } else {
      typename IsOptional<S>::Value value;
      read_params(value, json, path);
      params.*field.member = std::move(value);
    }
  } else {
    read_params(params.*field.member, json, path);
  }
}

template <class P, class V>
void read_field(P& params, const ListField<P, V>& field, const Json& json, const std::string& path) {
  if constexpr (IsOptional<V>::value) {
    if (json.is_null()) {
      params.*field.member = std::nullopt;
      return;
    }
  }
  if (!json.is_array()) refuse(path, json, IsOptional<V>::value ? "a list or null" : "a list");
  check_count(path, json, field.max_items);
  typename IsOptional<V>::Value values;
  for (std::size_t i = 0; i < json.size(); ++i) {
    read_params(values.emplace_back(), json[i], path + "/" + std::to_string(i));
  }
  params.*field.member = std::move(values);
}

template <class P>
void read_field(P& params, const NamesField<P>& field, const Json& json, const std::string& path) {
  if (!json.is_array()) refuse(path, json, "a list of names");
  check_count(path, json, field.max_items);
  std::vector<std::string> values;
  for (std::size_t i = 0; i < json.size(); ++i)
    values.push_back(read_text(json[i], path + "/" + std::to_string(i), kMaxTextLength, "a name"));
  params.*field.member = std::move(values);
}

template <class P>
void read_field(P& params, const RangeField<P>& field, const Json& json, const std::string& path) {
  if (!json.is_array() || json.size() != 2) refuse(path, json, "[low, high]");
  std::array<int, 2> value{};
  for (std::size_t i = 0; i < 2; ++i) {
    value[i] = read_number<int>(json[i], path + "/" + std::to_string(i), field.min, field.max, field.unit);
  }
  if (value[0] > value[1]) refuse(path, json, "[low, high] with low <= high");
  params.*field.member = value;
}

template <class P>
void read_field(P& params, const NumbersField<P>& field, const Json& json, const std::string& path) {
  if (!json.is_array()) refuse(path, json, "a list of whole numbers");
  std::vector<int> values;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const std::string here = path + "/" + std::to_string(i);
    const int value = read_number<int>(json[i], here, field.min, field.max, "");
    if (std::find(values.begin(), values.end(), value) != values.end())
      refuse(here, json[i], "each number once");
    values.push_back(value);
  }
  params.*field.member = std::move(values);
}

template <class P>
void read_field(P& params, const PointListField<P>& field, const Json& json, const std::string& path) {
  if (!json.is_array() || json.size() < field.min_points)
    refuse(path, json, "a list of at least " + std::to_string(field.min_points) + " points [x, y]");
  check_count(path, json, field.max_points);
  std::vector<std::array<double, 2>> values;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const std::string point_path = path + "/" + std::to_string(i);
    if (!json[i].is_array() || json[i].size() != 2) refuse(point_path, json[i], "[x, y]");
    auto& point = values.emplace_back();
    for (std::size_t k = 0; k < 2; ++k) {
      point[k] = read_number<double>(json[i][k], point_path + "/" + std::to_string(k), field.min, field.max,
                                     field.unit);
    }
  }
  params.*field.member = std::move(values);
}

template <class P, class J>
void read_field(P& params, const ObjectField<P, J>& field, const Json& json, const std::string& path) {
  if (!json.is_object()) refuse(path, json, "an object");
  if (extent_of(json, field.max_size).size > field.max_size) {
    throw SettingsError(path + ": the object is too large; expected at most " +
                        std::to_string(field.max_size) + " values and bytes of text in it");
  }
  params.*field.member = json;
}

/// Reads the keys that are present. Throws SettingsError for an unknown key or an invalid value; `params` is
/// then unspecified.
template <class P>
void read_params(P& params, const Json& json, const std::string& path) {
  if (!json.is_object()) refuse(path.empty() ? "/" : path, json, "an object");
  for (const auto& item : json.items()) {
    if (item.key() == kCommentKey) continue;
    const std::string item_path = path + "/" + shortened(escaped_text(item.key()));
    bool found = false;
    std::string known;
    const auto try_field = [&](const auto& field) {
      if (found) return;
      if (field.key == item.key()) {
        read_field(owner_of(params, field.member), field, item.value(), item_path);
        found = true;
      }
      known += (known.empty() ? "" : ", ") + std::string(field.key);
    };
    std::apply([&](const auto&... field) { (try_field(field), ...); }, P::fields());
    if (!found)
      throw SettingsError(escaped_text(item_path) +
                          ": no such parameter; known: " + (known.empty() ? "none" : known));
  }
}

/// The defaults of P, overridden by the keys of `json`.
template <class P>
P params_from_json(const Json& json, const std::string& path) {
  P params;
  read_params(params, json, path);
  return params;
}

// ---- writing

template <class P>
Json params_to_json(const P& params);

template <class P, class V, class L>
Json write_field(const P& params, const NumberField<P, V, L>& field) {
  if constexpr (IsOptional<V>::value) {
    const auto& value = params.*field.member;
    return value ? Json(*value) : Json(nullptr);
  } else {
    return Json(params.*field.member);
  }
}
template <class P>
Json write_field(const P& params, const FlagField<P>& field) {
  return params.*field.member;
}
template <class P>
Json write_field(const P& params, const TextField<P>& field) {
  return params.*field.member;
}
template <class P, class V, class E, std::size_t N>
Json write_field(const P& params, const ChoiceField<P, V, E, N>& field) {
  for (const auto& choice : field.choices) {
    if (params.*field.member == choice.value) return std::string(choice.name);
  }
  return nullptr;
}
template <class P, class S>
Json write_field(const P& params, const GroupField<P, S>& field) {
  if constexpr (IsOptional<S>::value) {
    const auto& value = params.*field.member;
    return value ? params_to_json(*value) : Json(nullptr);
  } else {
    return params_to_json(params.*field.member);
  }
}
template <class P, class V>
Json write_field(const P& params, const ListField<P, V>& field) {
  const auto& values = params.*field.member;
  Json out = Json::array();
  if constexpr (IsOptional<V>::value) {
    if (!values) return nullptr;
    for (const auto& value : *values) out.push_back(params_to_json(value));
  } else {
    for (const auto& value : values) out.push_back(params_to_json(value));
  }
  return out;
}
template <class P>
Json write_field(const P& params, const NamesField<P>& field) {
  return params.*field.member;
}
template <class P>
Json write_field(const P& params, const NumbersField<P>& field) {
  return params.*field.member;
}
template <class P>
Json write_field(const P& params, const RangeField<P>& field) {
  return params.*field.member;
}
template <class P>
Json write_field(const P& params, const PointListField<P>& field) {
  return params.*field.member;
}
template <class P, class J>
Json write_field(const P& params, const ObjectField<P, J>& field) {
  return params.*field.member;
}

template <class P>
Json params_to_json(const P& params) {
  Json out = Json::object();
  std::apply(
      [&](const auto&... field) {
        ((out[std::string(field.key)] = write_field(owner_of(params, field.member), field)), ...);
      },
      P::fields());
  return out;
}

// ---- JSON Schema (2020-12)

template <class P>
Json params_schema();

template <class P, class V, class L>
Json field_schema(const NumberField<P, V, L>& field) {
  Json out;
  if constexpr (IsOptional<V>::value) {
    out["type"] =
        Json::array({std::is_integral_v<typename IsOptional<V>::Value> ? "integer" : "number", "null"});
  } else {
    out["type"] = std::is_integral_v<V> ? "integer" : "number";
  }
  out["minimum"] = field.min;
  out["maximum"] = field.max;
  if (!field.unit.empty()) out["x-unit"] = field.unit;
  return out;
}
template <class P>
Json field_schema(const FlagField<P>&) {
  return {{"type", "boolean"}};
}
template <class P>
Json field_schema(const TextField<P>& field) {
  Json out{{"type", "string"}, {"maxLength", field.max_length}};
  if (field.names_file) out["format"] = "file";
  return out;
}
template <class P, class V, class E, std::size_t N>
Json field_schema(const ChoiceField<P, V, E, N>& field) {
  Json out{{"type", "string"}, {"enum", Json::array()}};
  for (const auto& choice : field.choices) out["enum"].push_back(choice.name);
  if constexpr (IsOptional<V>::value) {
    out["type"] = Json::array({"string", "null"});
    out["enum"].push_back(nullptr);
  }
  return out;
}
template <class P, class S>
Json field_schema(const GroupField<P, S>&) {
  if constexpr (IsOptional<S>::value) {
    Json out = params_schema<typename IsOptional<S>::Value>();
    // Not braced: clang 14 does not destroy a braced argument in a template.
    out["type"] = Json::array({"object", "null"});
    return out;
  } else {
    return params_schema<S>();
  }
}
template <class P, class V>
Json field_schema(const ListField<P, V>& field) {
  Json out{{"type", "array"},
           {"items", params_schema<typename IsOptional<V>::Value::value_type>()},
           {"maxItems", field.max_items}};
  if constexpr (IsOptional<V>::value) out["type"] = Json::array({"array", "null"});
  return out;
}
template <class P>
Json field_schema(const NamesField<P>& field) {
  const Json name{{"type", "string"}, {"maxLength", kMaxTextLength}};
  return {{"type", "array"}, {"items", name}, {"maxItems", field.max_items}};
}
template <class P>
Json field_schema(const NumbersField<P>& field) {
  return {{"type", "array"},
          {"items", {{"type", "integer"}, {"minimum", field.min}, {"maximum", field.max}}},
          {"uniqueItems", true},
          {"maxItems", field.max - field.min + 1}};
}
template <class P>
Json field_schema(const RangeField<P>& field) {
  Json out{{"type", "array"},
           {"items", {{"type", "integer"}, {"minimum", field.min}, {"maximum", field.max}}},
           {"minItems", 2},
           {"maxItems", 2}};
  if (!field.unit.empty()) out["x-unit"] = field.unit;
  return out;
}
template <class P>
Json field_schema(const PointListField<P>& field) {
  const Json coordinate{{"type", "number"}, {"minimum", field.min}, {"maximum", field.max}};
  Json point{{"type", "array"}, {"items", coordinate}, {"minItems", 2}, {"maxItems", 2}};
  Json out{{"type", "array"},
           {"items", std::move(point)},
           {"minItems", field.min_points},
           {"maxItems", field.max_points}};
  if (!field.unit.empty()) out["x-unit"] = field.unit;
  return out;
}
template <class P, class J>
Json field_schema(const ObjectField<P, J>&) {
  return {{"type", "object"}};
}

/// Schema of one parameter struct: properties with type, range, default, unit (x-unit) and help
/// (description).
template <class P>
Json params_schema() {
  const P defaults{};
  Json properties = Json::object();
  const auto add = [&](const auto& field) {
    Json one = field_schema(field);
    one["description"] = field.help;
    one["default"] = write_field(owner_of(defaults, field.member), field);
    properties[std::string(field.key)] = std::move(one);
  };
  std::apply([&](const auto&... field) { (add(field), ...); }, P::fields());
  return {{"type", "object"}, {"additionalProperties", false}, {"properties", properties}};
}

}  // namespace sslv
