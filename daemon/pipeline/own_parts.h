// SPDX-License-Identifier: Apache-2.0
#pragma once

// Parts of the frame that stage libraries bring: what one stage finds and another one reads.
//
//   struct TagList {
//     static constexpr std::string_view kPartName = "tags";
//     std::vector<Tag> tags;
//     void clear() { tags.clear(); }  // for the next frame; keeps its memory
//   };
//
// Libraries share a part when it has the same name and the same layout in both.

#include "pipeline/layout.h"

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

/// A part that a library brings, with its type erased.
struct OwnPartType {
  std::string name;
  std::uint64_t layout = 0;
  std::shared_ptr<void> (*create)() = nullptr;
  void (*clear)(void* part) = nullptr;
};

/// What a stage has to do with such a part. `place` is a number of the library's own that who takes its
/// stages into a table writes: where the part lies in every frame.
struct OwnPartUse {
  OwnPartType type;
  bool is_written = false;  // from scratch; else it needs it
  std::size_t* place = nullptr;
};

/// The parts of one frame that libraries brought: none where no stage has any.
class OwnParts {
 public:
  /// The place of T in this library.
  template <class T>
  inline static std::size_t place_of = 0;

  template <class T>
  T& get() const {
    return *static_cast<T*>(parts_[place_of<T>].get());
  }
  void* at(std::size_t place) const { return parts_[place].get(); }

  /// Makes the part unless it is there, and empties it. Allocates only the first time.
  void prepare(std::size_t place, const OwnPartType& type) {
    if (parts_.size() <= place) parts_.resize(place + 1);
    if (parts_[place] == nullptr) parts_[place] = type.create();
    type.clear(parts_[place].get());
  }

 private:
  std::vector<std::shared_ptr<void>> parts_;
};

template <OwnPart T>
OwnPartUse own_part_use(bool is_written) {
  return {{.name = std::string(T::kPartName),
           .layout = layout_of<T>(),
           .create = [] { return std::shared_ptr<void>(std::make_shared<T>()); },
           .clear = [](void* part) { static_cast<T*>(part)->clear(); }},
          is_written,
          &OwnParts::place_of<T>};
}

}  // namespace sslv
