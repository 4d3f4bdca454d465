// SPDX-License-Identifier: Apache-2.0
#pragma once

// Parameters are declared once, as members of a plain struct with one line each in its `fields()`:
//
//   struct Params {
//     double min_area_mm2 = 300;
//     static constexpr auto fields() {
//       return std::tuple{number("min_area_mm2", &Params::min_area_mm2, 0.0, 1e5, "mm2", "smallest blob taken
//       for a ball")};
//     }
//   };
//
// Parsing, range checks, defaults, the JSON schema and the panel's widget are derived from that line
// (params_json.h).

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

namespace sslv {

/// Default limits of a setting: characters (Unicode code points) of a text, entries of a list.
inline constexpr std::size_t kMaxTextLength = 200, kMaxListItems = 256;
/// Bytes of a path without the terminating zero: PATH_MAX of Linux minus 1.
inline constexpr std::size_t kMaxPathLength = 4095;
/// Limit for the number of values plus the characters of texts and keys, in an object whose keys are declared
/// elsewhere.
inline constexpr std::size_t kMaxObjectSize = 100'000;

/// An int, a double or std::optional of them, in the closed range [min, max]. An empty optional is JSON null.
template <class P, class V, class Limit>
struct NumberField {
  std::string_view key;
  V P::*member;
  Limit min, max;
  std::string_view unit;  // "mm", "px", "us"...; "" for a plain number
  std::string_view help;
};

/// A switch.
template <class P>
struct FlagField {
  std::string_view key;
  bool P::*member;
  std::string_view help;
};

/// A text; with `names_file` the name of a file, with `is_secret` never shown or logged.
template <class P>
struct TextField {
  std::string_view key;
  std::string P::*member;
  std::string_view help;
  std::size_t max_length = kMaxTextLength;  // characters
  bool names_file = false;
  bool is_secret = false;
};

/// One of an enum's values and its name in JSON.
template <class E>
struct Choice {
  std::string_view name;
  E value;
};

/// An enum or std::optional of one (JSON null when absent).
template <class P, class V, class E, std::size_t N>
struct ChoiceField {
  std::string_view key;
  V P::*member;
  std::array<Choice<E>, N> choices;
  std::string_view help;
};

/// A nested struct with its own fields(), or std::optional of one (JSON null when empty).
template <class P, class S>
struct GroupField {
  std::string_view key;
  S P::*member;
  std::string_view help;
};

/// A std::vector of structs with their own fields(), or std::optional of one (JSON null when empty).
template <class P, class V>
struct ListField {
  std::string_view key;
  V P::*member;
  std::string_view help;
  std::size_t max_items = kMaxListItems;
};

/// A std::vector<std::string>, each at most kMaxTextLength characters.
template <class P>
struct NamesField {
  std::string_view key;
  std::vector<std::string> P::*member;
  std::string_view help;
  std::size_t max_items = kMaxListItems;
};

/// A std::vector<int> of distinct numbers.
template <class P>
struct NumbersField {
  std::string_view key;
  std::vector<int> P::*member;
  int min, max;
  std::string_view help;
};

/// A closed interval [low, high] of integers, written as a JSON array of two numbers.
template <class P>
struct RangeField {
  std::string_view key;
  std::array<int, 2> P::*member;
  int min, max;
  std::string_view unit;
  std::string_view help;
};

/// A list of `min_points` to `max_points` points [x, y].
template <class P>
struct PointListField {
  std::string_view key;
  std::vector<std::array<double, 2>> P::*member;
  std::size_t min_points, max_points;
  double min, max;  // range of x and y
  std::string_view unit;
  std::string_view help;
};

/// A JSON object whose keys are declared elsewhere (a stage's parameters, a capture backend's options).
template <class P, class J>
struct ObjectField {
  std::string_view key;
  J P::*member;
  std::string_view help;
  std::size_t max_size = kMaxObjectSize;
};

template <class P, class V, class Limit>
constexpr auto number(std::string_view key, V P::*member, Limit min, Limit max, std::string_view unit,
                      std::string_view help) {
  return NumberField<P, V, Limit>{key, member, min, max, unit, help};
}
template <class P>
constexpr auto flag(std::string_view key, bool P::*member, std::string_view help) {
  return FlagField<P>{key, member, help};
}
/// Plain text (plain_text.h); other text is refused.
template <class P>
constexpr auto text(std::string_view key, std::string P::*member, std::string_view help,
                    std::size_t max_length = kMaxTextLength) {
  return TextField<P>{key, member, help, max_length};
}
/// A password: any text, limited only by the code that checks passwords. Refused values are not shown in
/// errors.
template <class P>
constexpr auto secret(std::string_view key, std::string P::*member, std::string_view help) {
  return TextField<P>{key, member, help, kMaxTextLength, false, true};
}
/// The path of a file or folder on the daemon's computer. The panel may set only some of these paths.
template <class P>
constexpr auto file(std::string_view key, std::string P::*member, std::string_view help) {
  return TextField<P>{key, member, help, kMaxPathLength, true};
}
template <class P, class V, class E, std::size_t N>
constexpr auto choice(std::string_view key, V P::*member, const std::array<Choice<E>, N>& choices,
                      std::string_view help) {
  return ChoiceField<P, V, E, N>{key, member, choices, help};
}
template <class P, class S>
constexpr auto group(std::string_view key, S P::*member, std::string_view help) {
  return GroupField<P, S>{key, member, help};
}
template <class P, class V>
constexpr auto list(std::string_view key, V P::*member, std::string_view help,
                    std::size_t max_items = kMaxListItems) {
  return ListField<P, V>{key, member, help, max_items};
}
template <class P>
constexpr auto names(std::string_view key, std::vector<std::string> P::*member, std::string_view help,
                     std::size_t max_items = kMaxListItems) {
  return NamesField<P>{key, member, help, max_items};
}
template <class P>
constexpr auto numbers(std::string_view key, std::vector<int> P::*member, int min, int max,
                       std::string_view help) {
  return NumbersField<P>{key, member, min, max, help};
}
template <class P>
constexpr auto range(std::string_view key, std::array<int, 2> P::*member, int min, int max,
                     std::string_view unit, std::string_view help) {
  return RangeField<P>{key, member, min, max, unit, help};
}
template <class P>
constexpr auto point_list(std::string_view key, std::vector<std::array<double, 2>> P::*member,
                          std::size_t min_points, std::size_t max_points, double min, double max,
                          std::string_view unit, std::string_view help) {
  return PointListField<P>{key, member, min_points, max_points, min, max, unit, help};
}
template <class P, class J>
constexpr auto object(std::string_view key, J P::*member, std::string_view help,
                      std::size_t max_size = kMaxObjectSize) {
  return ObjectField<P, J>{key, member, help, max_size};
}

}  // namespace sslv
