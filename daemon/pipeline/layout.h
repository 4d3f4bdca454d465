// SPDX-License-Identifier: Apache-2.0
#pragma once

// Hash of a type's layout in memory. Programs that were built separately may share objects of a type only if
// both have the same hash. It covers the members of a struct without constructors, recursively, but only the
// size and alignment of a class that hides its members (kKitVersion, kit/stamp.h, covers their meaning).

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

namespace sslv {

/// Converts to the type of any member.
struct AnyMember {
  template <class T>
  operator T() const;  // NOLINT(google-explicit-constructor): implicit on purpose
};

template <class T, std::size_t... kI>
constexpr bool takes_members(std::index_sequence<kI...>) {
  return requires {
    T{(void(kI), AnyMember{})...};
  };
}

inline constexpr std::size_t kMaxMembers = 20;

/// Number of members of a struct without constructors and bases.
template <class T, std::size_t kCount = kMaxMembers>
constexpr std::size_t member_count() {
  if constexpr (kCount == 0 || takes_members<T>(std::make_index_sequence<kCount>())) {
    static_assert(!takes_members<T>(std::make_index_sequence<kMaxMembers + 1>()),
                  "a struct with more members needs a longer list in layout.h");
    return kCount;
  } else {
    return member_count<T, kCount - 1>();
  }
}

/// References to all members, in their order.
template <class T>
constexpr auto members_of(T& value) {
  constexpr std::size_t kCount = member_count<std::remove_const_t<T>>();
  // clang-format off
  if constexpr (kCount == 0) { return std::tie(); }
  else if constexpr (kCount == 1) { auto& [a] = value; return std::tie(a); }
  else if constexpr (kCount == 2) { auto& [a, b] = value; return std::tie(a, b); }
  else if constexpr (kCount == 3) { auto& [a, b, c] = value; return std::tie(a, b, c); }
  else if constexpr (kCount == 4) { auto& [a, b, c, d] = value; return std::tie(a, b, c, d); }
  else if constexpr (kCount == 5) { auto& [a, b, c, d, e] = value; return std::tie(a, b, c, d, e); }
  else if constexpr (kCount == 6) { auto& [a, b, c, d, e, f] = value; return std::tie(a, b, c, d, e, f); }
  else if constexpr (kCount == 7) { auto& [a, b, c, d, e, f, g] = value; return std::tie(a, b, c, d, e, f, g); }
  else if constexpr (kCount == 8) { auto& [a, b, c, d, e, f, g, h] = value; return std::tie(a, b, c, d, e, f, g, h); }
  else if constexpr (kCount == 9) { auto& [a, b, c, d, e, f, g, h, i] = value; return std::tie(a, b, c, d, e, f, g, h, i); }
  else if constexpr (kCount == 10) { auto& [a, b, c, d, e, f, g, h, i, j] = value; return std::tie(a, b, c, d, e, f, g, h, i, j); }
  else if constexpr (kCount == 11) { auto& [a, b, c, d, e, f, g, h, i, j, k] = value; return std::tie(a, b, c, d, e, f, g, h, i, j, k); }
  else if constexpr (kCount == 12) { auto& [a, b, c, d, e, f, g, h, i, j, k, l] = value; return std::tie(a, b, c, d, e, f, g, h, i, j, k, l); }
  else if constexpr (kCount == 13) { auto& [a, b, c, d, e, f, g, h, i, j, k, l, m] = value; return std::tie(a, b, c, d, e, f, g, h, i, j, k, l, m); }
  else if constexpr (kCount == 14) { auto& [a, b, c, d, e, f, g, h, i, j, k, l, m, n] = value; return std::tie(a, b, c, d, e, f, g, h, i, j, k, l, m, n); }
  else if constexpr (kCount == 15) { auto& [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o] = value; return std::tie(a, b, c, d, e, f, g, h, i, j, k, l, m, n, o); }
  else if constexpr (kCount == 16) { auto& [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p] = value; return std::tie(a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p); }
  else if constexpr (kCount == 17) { auto& [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q] = value; return std::tie(a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q); }
  else if constexpr (kCount == 18) { auto& [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r] = value; return std::tie(a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r); }
  else if constexpr (kCount == 19) { auto& [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s] = value; return std::tie(a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s); }
  else { auto& [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t] = value; return std::tie(a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t); }
  // clang-format on
}

/// FNV-1a over whole numbers.
constexpr std::uint64_t mix_layout(std::uint64_t hash, std::uint64_t value) {
  for (int i = 0; i < 8; ++i) hash = (hash ^ (value >> (8 * i) & 255U)) * 0x100000001b3U;
  return hash;
}

/// Kind of a type, part of its hash.
enum class LayoutKind : std::uint8_t {
  kOpaque,
  kSigned,
  kUnsigned,
  kFloat,
  kBool,
  kArray,
  kVector,
  kOptional,
  kStruct
};

template <class T>
constexpr std::uint64_t start_layout(LayoutKind kind) {
  return mix_layout(mix_layout(0xcbf29ce484222325U, static_cast<std::uint64_t>(kind)),
                    std::uint64_t{sizeof(T)} << 8 | alignof(T));
}

template <class T>
struct Layout {
  template <class... M>
  static constexpr std::uint64_t of_members(std::type_identity<std::tuple<M...>>) {
    std::uint64_t hash = mix_layout(start_layout<T>(LayoutKind::kStruct), sizeof...(M));
    ((hash = mix_layout(hash, Layout<std::remove_cvref_t<M>>::value())), ...);
    return hash;
  }
  static constexpr std::uint64_t value() {
    if constexpr (std::is_enum_v<T>) {
      return Layout<std::underlying_type_t<T>>::value();
    } else if constexpr (std::is_same_v<T, bool>) {
      return start_layout<T>(LayoutKind::kBool);
    } else if constexpr (std::is_floating_point_v<T>) {
      return start_layout<T>(LayoutKind::kFloat);
    } else if constexpr (std::is_integral_v<T>) {
      return start_layout<T>(std::is_signed_v<T> ? LayoutKind::kSigned : LayoutKind::kUnsigned);
    } else if constexpr (std::is_aggregate_v<T> && std::is_class_v<T>) {
      return of_members(std::type_identity<decltype(members_of(std::declval<T&>()))>{});
    } else {
      return start_layout<T>(LayoutKind::kOpaque);
    }
  }
};
template <class T, std::size_t kSize>
struct Layout<std::array<T, kSize>> {
  static constexpr std::uint64_t value() {
    return mix_layout(start_layout<std::array<T, kSize>>(LayoutKind::kArray), Layout<T>::value());
  }
};
template <class T>
struct Layout<std::vector<T>> {
  static constexpr std::uint64_t value() {
    return mix_layout(start_layout<std::vector<T>>(LayoutKind::kVector), Layout<T>::value());
  }
};
template <class T>
struct Layout<std::optional<T>> {
  static constexpr std::uint64_t value() {
    return mix_layout(start_layout<std::optional<T>>(LayoutKind::kOptional), Layout<T>::value());
  }
};

template <class T>
constexpr std::uint64_t layout_of() {
  return Layout<T>::value();
}

}  // namespace sslv
