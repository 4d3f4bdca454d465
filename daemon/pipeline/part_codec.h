// SPDX-License-Identifier: Apache-2.0
#pragma once

// Converts parts of a frame to flat bytes and back, for stages that run in a separate process. Both ends are
// the same program on the same computer, so the bytes are not a file format. The reader does not trust the
// writer: every count is limited by the bytes that are left.
//
// Supported types: numbers, bools, enums, structs without constructors, std::vector, array, optional, pair,
// string and bitset, Eigen matrices of fixed size, and any nesting of these types. A class that hides its
// members has either
//
//   template <class Self> static auto stored(Self& self) { return std::tie(self.a_, self.b_); }
//
// or `void encode(ByteWriter&) const` and `bool decode(ByteReader&)` of its own. An enum whose values are
// used as indices has `constexpr E largest(E)` beside it: larger values are refused.

#include "pipeline/layout.h"

#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

namespace sslv {

/// Writes into given memory. Data that does not fit is dropped, and then fits() is false.
class ByteWriter {
 public:
  explicit ByteWriter(std::span<std::byte> room) : at_(room.data()), begin_(at_), end_(at_ + room.size()) {}

  void bytes(const void* from, std::size_t count) noexcept {
    if (count > static_cast<std::size_t>(end_ - at_)) {
      fits_ = false;
      return;
    }
    if (count != 0) std::memcpy(at_, from, count);
    at_ += count;
  }
  void count(std::size_t value) noexcept {
    const std::uint64_t wide = value;
    bytes(&wide, sizeof wide);
  }

  /// Writes the output of `write` after its size in bytes, so that a reader can skip it.
  template <class Write>
  void whole(Write write) {
    std::byte* const at = at_;
    count(0);
    write();
    if (!fits_) return;
    const std::uint64_t bytes = static_cast<std::uint64_t>(at_ - at) - sizeof(std::uint64_t);
    std::memcpy(at, &bytes, sizeof bytes);
  }

  bool fits() const { return fits_; }
  std::size_t written() const { return static_cast<std::size_t>(at_ - begin_); }

 private:
  std::byte *at_, *begin_, *end_;
  bool fits_ = true;
};

/// Reads the output of a ByteWriter, possibly from a hostile process. The memory may change while it is read,
/// so nothing is read twice.
class ByteReader {
 public:
  /// `refuses_nan`: decoding fails at a NaN.
  explicit ByteReader(std::span<const std::byte> from, bool refuses_nan = false)
      : at_(from.data()), end_(at_ + from.size()), refuses_nan_(refuses_nan) {}

  /// Returns false if fewer bytes are left.
  bool bytes(void* to, std::size_t count) noexcept {
    if (count > left()) return false;
    if (count != 0) std::memcpy(to, at_, count);
    at_ += count;
    return true;
  }
  /// Reads a count of elements of at least `least_bytes` each; returns false if the remaining bytes are too
  /// few for this count.
  bool count(std::size_t& value, std::size_t least_bytes) noexcept {
    std::uint64_t wide = 0;
    if (!bytes(&wide, sizeof wide) || wide > left() / std::max<std::size_t>(least_bytes, 1)) return false;
    value = static_cast<std::size_t>(wide);
    return true;
  }

  /// Reader of the output of ByteWriter::whole(); nothing if this output is incomplete.
  std::optional<ByteReader> whole() noexcept {
    std::size_t bytes = 0;
    if (!count(bytes, 1)) return std::nullopt;
    const std::byte* const at = at_;
    at_ += bytes;
    return ByteReader({at, bytes}, refuses_nan_);
  }

  std::size_t left() const { return static_cast<std::size_t>(end_ - at_); }
  bool refuses_nan() const { return refuses_nan_; }

 private:
  const std::byte *at_, *end_;
  bool refuses_nan_;
};

template <class T>
concept CodesItself = requires(const T& value, T& other, ByteWriter& writer, ByteReader& reader) {
  value.encode(writer);
  { other.decode(reader) } -> std::same_as<bool>;
};
template <class T>
concept HasStored = requires(T& value) {
  T::stored(value);
};
template <class T>
concept HasLargest = requires(T value) {
  { largest(value) } -> std::same_as<T>;
};
template <class T>
concept EigenMatrix = requires(T& value) {
  typename T::Scalar;
  { T::SizeAtCompileTime } -> std::convertible_to<int>;
  value.data();
};

/// Codec of one type. kIs: whether the type is supported. kAnyBits: every bit pattern is valid, so that
/// arrays are copied as a whole. kLeast: the minimum number of bytes of an encoded value.
template <class T>
struct PartCodec {
  static constexpr bool is_struct() { return std::is_aggregate_v<T> && std::is_class_v<T>; }
  static auto members(T& value) {
    if constexpr (HasStored<T>)
      return T::stored(value);
    else
      return members_of(value);
  }
  static auto members(const T& value) {
    if constexpr (HasStored<T>)
      return T::stored(value);
    else
      return members_of(value);
  }
  /// Sum of the results of `use` for the types of all members.
  template <class Use>
  static constexpr std::size_t sum(Use use) {
    return [&]<class... M>(std::type_identity<std::tuple<M...>>) {
      return (std::size_t{0} + ... + use(std::type_identity<std::remove_cvref_t<M>>{}));
    }(std::type_identity<decltype(members(std::declval<T&>()))>{});
  }

  static constexpr bool is() {
    if constexpr (CodesItself<T> || std::is_arithmetic_v<T> || std::is_enum_v<T>) {
      return true;
    } else if constexpr (EigenMatrix<T>) {
      return T::SizeAtCompileTime > 0;
    } else if constexpr (HasStored<T> || is_struct()) {
      return sum([]<class M>(std::type_identity<M>) -> std::size_t { return PartCodec<M>::kIs ? 0 : 1; }) ==
             0;
    } else {
      return false;
    }
  }
  static constexpr bool any_bits() {
    if constexpr (std::is_enum_v<T>) {
      return !HasLargest<T>;
    } else if constexpr (std::is_arithmetic_v<T>) {
      return !std::is_same_v<T, bool> && !std::is_floating_point_v<T>;
    } else if constexpr (is_struct() && std::is_trivially_copyable_v<T> && !CodesItself<T> && !HasStored<T>) {
      return sum([]<class M>(std::type_identity<M>) -> std::size_t {
               return PartCodec<M>::kAnyBits ? 0 : 1;
             }) == 0;
    } else {
      return false;
    }
  }
  static constexpr std::size_t least() {
    if constexpr (any_bits() || EigenMatrix<T> || std::is_arithmetic_v<T> || std::is_enum_v<T>) {
      return sizeof(T);
    } else if constexpr (is() && !CodesItself<T>) {
      return sum([]<class M>(std::type_identity<M>) { return PartCodec<M>::kLeast; });
    } else {
      return 1;
    }
  }
  static constexpr bool kIs = is();
  static constexpr bool kAnyBits = any_bits();
  static constexpr std::size_t kLeast = least();

  static void encode(const T& value, ByteWriter& to) {
    if constexpr (CodesItself<T>) {
      value.encode(to);
    } else if constexpr (kAnyBits || std::is_arithmetic_v<T> || std::is_enum_v<T>) {
      to.bytes(&value, sizeof value);
    } else if constexpr (EigenMatrix<T>) {
      to.bytes(value.data(), sizeof(typename T::Scalar) * static_cast<std::size_t>(T::SizeAtCompileTime));
    } else {
      std::apply(
          [&](const auto&... member) {
            (PartCodec<std::remove_cvref_t<decltype(member)>>::encode(member, to), ...);
          },
          members(value));
    }
  }
  static bool decode(ByteReader& from, T& value) {
    if constexpr (CodesItself<T>) {
      return value.decode(from);
    } else if constexpr (kAnyBits) {
      return from.bytes(&value, sizeof value);
    } else if constexpr (std::is_same_v<T, bool>) {
      std::uint8_t byte = 0;
      if (!from.bytes(&byte, 1) || byte > 1) return false;
      value = byte == 1;
      return true;
    } else if constexpr (std::is_enum_v<T>) {
      std::underlying_type_t<T> number{};
      if (!from.bytes(&number, sizeof number) || number < 0 ||
          number > static_cast<std::underlying_type_t<T>>(largest(T{})))
        return false;
      value = static_cast<T>(number);
      return true;
    } else if constexpr (std::is_floating_point_v<T>) {
      return from.bytes(&value, sizeof value) && !(from.refuses_nan() && std::isnan(value));
    } else if constexpr (EigenMatrix<T>) {
      for (int i = 0; i < T::SizeAtCompileTime; ++i) {
        if (!PartCodec<typename T::Scalar>::decode(from, value.data()[i])) return false;
      }
      return true;
    } else {
      return std::apply(
          [&](auto&... member) {
            return (PartCodec<std::remove_cvref_t<decltype(member)>>::decode(from, member) && ...);
          },
          members(value));
    }
  }
};

template <class T, std::size_t kSize>
struct PartCodec<std::array<T, kSize>> {
  static constexpr bool kIs = PartCodec<T>::kIs, kAnyBits = PartCodec<T>::kAnyBits;
  static constexpr std::size_t kLeast = kSize * PartCodec<T>::kLeast;
  static void encode(const std::array<T, kSize>& value, ByteWriter& to) {
    if constexpr (kAnyBits) {
      to.bytes(value.data(), sizeof value);
    } else {
      for (const T& one : value) PartCodec<T>::encode(one, to);
    }
  }
  static bool decode(ByteReader& from, std::array<T, kSize>& value) {
    if constexpr (kAnyBits) {
      return from.bytes(value.data(), sizeof value);
    } else {
      return std::all_of(value.begin(), value.end(), [&](T& one) { return PartCodec<T>::decode(from, one); });
    }
  }
};

template <class T>
struct PartCodec<std::vector<T>> {
  static constexpr bool kIs = PartCodec<T>::kIs && std::is_default_constructible_v<T>, kAnyBits = false;
  static constexpr std::size_t kLeast = sizeof(std::uint64_t);
  static void encode(const std::vector<T>& value, ByteWriter& to) {
    to.count(value.size());
    if constexpr (PartCodec<T>::kAnyBits) {
      to.bytes(value.data(), value.size() * sizeof(T));
    } else {
      for (const T& one : value) PartCodec<T>::encode(one, to);
    }
  }
  /// Keeps the vector's memory.
  static bool decode(ByteReader& from, std::vector<T>& value) {
    std::size_t count = 0;
    if (!from.count(count, PartCodec<T>::kLeast)) return false;
    value.resize(count);
    if constexpr (PartCodec<T>::kAnyBits) {
      return from.bytes(value.data(), count * sizeof(T));
    } else {
      return std::all_of(value.begin(), value.end(), [&](T& one) { return PartCodec<T>::decode(from, one); });
    }
  }
};

template <>
struct PartCodec<std::string> {
  static constexpr bool kIs = true, kAnyBits = false;
  static constexpr std::size_t kLeast = sizeof(std::uint64_t);
  static void encode(const std::string& value, ByteWriter& to) {
    to.count(value.size());
    to.bytes(value.data(), value.size());
  }
  static bool decode(ByteReader& from, std::string& value) {
    std::size_t count = 0;
    if (!from.count(count, 1)) return false;
    value.resize(count);
    return from.bytes(value.data(), count);
  }
};

template <class T>
struct PartCodec<std::optional<T>> {
  static constexpr bool kIs = PartCodec<T>::kIs, kAnyBits = false;
  static constexpr std::size_t kLeast = 1;
  static void encode(const std::optional<T>& value, ByteWriter& to) {
    PartCodec<bool>::encode(value.has_value(), to);
    if (value) PartCodec<T>::encode(*value, to);
  }
  static bool decode(ByteReader& from, std::optional<T>& value) {
    bool is_there = false;
    if (!PartCodec<bool>::decode(from, is_there)) return false;
    if (!is_there) {
      value.reset();
      return true;
    }
    if constexpr (std::is_default_constructible_v<T>) {
      if (!value) value.emplace();
    } else {
      if (!value) value.emplace(T::for_stored());
    }
    return PartCodec<T>::decode(from, *value);
  }
};

template <class A, class B>
struct PartCodec<std::pair<A, B>> {
  static constexpr bool kIs = PartCodec<A>::kIs && PartCodec<B>::kIs, kAnyBits = false;
  static constexpr std::size_t kLeast = PartCodec<A>::kLeast + PartCodec<B>::kLeast;
  static void encode(const std::pair<A, B>& value, ByteWriter& to) {
    PartCodec<A>::encode(value.first, to);
    PartCodec<B>::encode(value.second, to);
  }
  static bool decode(ByteReader& from, std::pair<A, B>& value) {
    return PartCodec<A>::decode(from, value.first) && PartCodec<B>::decode(from, value.second);
  }
};

template <std::size_t kBits>
struct PartCodec<std::bitset<kBits>> {
  static constexpr bool kIs = kBits % 64 == 0, kAnyBits = kIs;
  static constexpr std::size_t kLeast = sizeof(std::bitset<kBits>);
  static void encode(const std::bitset<kBits>& value, ByteWriter& to) { to.bytes(&value, sizeof value); }
  static bool decode(ByteReader& from, std::bitset<kBits>& value) { return from.bytes(&value, sizeof value); }
};

/// Whether a T can be sent to another process.
template <class T>
inline constexpr bool kIsEncodable = PartCodec<T>::kIs;

template <class T>
void encode(const T& value, ByteWriter& to) {
  PartCodec<T>::encode(value, to);
}
/// Returns false if the bytes are not a valid T; then `value` is unspecified.
template <class T>
[[nodiscard]] bool decode(ByteReader& from, T& value) {
  return PartCodec<T>::decode(from, value);
}

}  // namespace sslv
