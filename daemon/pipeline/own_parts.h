// SPDX-License-Identifier: Apache-2.0
#pragma once

// Parts of the frame that stage libraries define: one stage writes them, another one reads them.
//
//   struct TagList {
//     static constexpr std::string_view kPartName = "tags";
//     std::vector<Tag> tags;
//     void clear() { tags.clear(); }  // for the next frame; the part keeps its memory
//   };
//
// Libraries share a part if it has the same name and the same layout in both.

#include "pipeline/layout.h"
#include "pipeline/part_codec.h"

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace sslv {

template <class T>
concept OwnPart = std::default_initializable<std::remove_const_t<T>> &&
    requires(std::remove_const_t<T>& part) {
  { T::kPartName } -> std::convertible_to<std::string_view>;
  part.clear();
};

/// Operations on a type-erased part.
struct OwnPartCode {
  std::shared_ptr<void> (*create)() = nullptr;
  void (*clear)(void* part) = nullptr;
  /// Conversion to flat bytes and back (part_codec.h). Null: the part cannot be sent to another process.
  void (*encode)(const void* part, ByteWriter& to) = nullptr;
  bool (*decode)(ByteReader& from, void* part) = nullptr;
  bool is_flat = false;  // the part is a FlatPart
};

/// Type-erased description of a library's part.
struct OwnPartType {
  std::string name;
  std::uint64_t layout = 0;
  OwnPartCode code;
};

/// A part of a library that runs in another process: its encoded bytes, which this process never interprets.
struct FlatPart {
  std::vector<std::byte> bytes;

  static OwnPartCode code() {
    return {.create = [] { return std::shared_ptr<void>(std::make_shared<FlatPart>()); },
            .clear = [](void* part) { static_cast<FlatPart*>(part)->bytes.clear(); },
            .encode =
                [](const void* part, ByteWriter& to) {
                  const auto& flat = static_cast<const FlatPart*>(part)->bytes;
                  to.bytes(flat.data(), flat.size());
                },
            .decode =
                [](ByteReader& from, void* part) {
                  auto& flat = static_cast<FlatPart*>(part)->bytes;
                  flat.resize(from.left());
                  return from.bytes(flat.data(), flat.size());
                },
            .is_flat = true};
  }
};

/// How a stage uses a library's part. `place` points to a variable of the library, written by the loader: the
/// part's index in every frame.
struct OwnPartUse {
  OwnPartType type;
  bool is_written = false;  // the stage writes it from scratch; else it reads it
  bool is_updated = false;  // the stage reads it and changes it
  std::size_t* place = nullptr;
};

/// The libraries' parts of one frame; empty if no stage has any.
class OwnParts {
 public:
  /// Index of T, for this library. Hidden regardless of the library's build options: the dynamic loader would
  /// otherwise merge the variables of two libraries that each have a T of their own.
  template <class T>
  [[gnu::visibility("hidden")]] inline static std::size_t place_of = 0;

  template <class T>
  T& get() const {
    return *static_cast<T*>(parts_[place_of<T>].part.get());
  }
  void* at(std::size_t place) const { return parts_[place].part.get(); }
  /// Operations on the part, from its creator.
  const OwnPartCode& code_at(std::size_t place) const { return parts_[place].code; }

  /// Creates the part unless it exists, and clears it. Allocates only the first time. If a library in this
  /// process shares the part with a library in another process, the part has the type of the library in this
  /// process.
  void prepare(std::size_t place, const OwnPartType& type) {
    if (parts_.size() <= place) parts_.resize(place + 1);
    Kept& kept = parts_[place];
    if (kept.part == nullptr || (kept.code.is_flat && !type.code.is_flat))
      kept = {type.code.create(), type.code};
    kept.code.clear(kept.part.get());
  }

 private:
  struct Kept {
    std::shared_ptr<void> part;
    OwnPartCode code;
  };
  std::vector<Kept> parts_;
};

template <OwnPart T>
OwnPartCode own_part_code() {
  OwnPartCode code{.create = [] { return std::shared_ptr<void>(std::make_shared<T>()); },
                   .clear = [](void* part) { static_cast<T*>(part)->clear(); }};
  if constexpr (kIsEncodable<T>) {
    code.encode = [](const void* part, ByteWriter& to) { encode(*static_cast<const T*>(part), to); };
    code.decode = [](ByteReader& from, void* part) { return decode(from, *static_cast<T*>(part)); };
  }
  return code;
}

enum class PartAccess : std::uint8_t { kReads, kWrites, kUpdates };

template <OwnPart T>
OwnPartUse own_part_use(PartAccess access) {
  return {{.name = std::string(T::kPartName), .layout = layout_of<T>(), .code = own_part_code<T>()},
          access == PartAccess::kWrites,
          access == PartAccess::kUpdates,
          &OwnParts::place_of<T>};
}

}  // namespace sslv
