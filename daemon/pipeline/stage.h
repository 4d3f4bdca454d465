// SPDX-License-Identifier: Apache-2.0
#pragma once

// Binds stages to frames. Types are erased only in this file.
//
// A stage is a class with a nested `Params` struct (base/params.h) and a member function
//
//   void process(const Params&, const A&, B&, ...) noexcept;
//
// whose signature is the contract: `const T&` reads the part of type T, `T&` writes it from scratch,
// `Update<T>` edits it in place. A part belongs to the frame of the stage's floor (cameras or whole field,
// see below) or to a stage library (own_parts.h). `StageNotes&` takes messages for the admin. Each floor
// defines further inputs: camera_stage.h for the stages of one camera, field_stage.h for the stages of the
// whole field. Any other parameter does not compile.
//
// A stage that keeps state between frames lists the members that hold it, so that a recording can begin with
// that state:
//
//   template <class Self> static auto remembered(Self& self) { return std::tie(self.memory_); }
//
// part_codec.h must support the types of these members.

#include "base/params_json.h"
#include "base/stage_notes.h"
#include "pipeline/own_parts.h"

#include <algorithm>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

namespace sslv {

/// A part of a frame: its name in error messages, and its member. Parts are identified by their type.
template <class Frame, class T>
struct Part {
  std::string_view name;
  T Frame::*member;
};
template <class Frame, class T>
Part(std::string_view, T Frame::*) -> Part<Frame, T>;

// A floor is a struct with
//   Frame                   the frame, with the member stage_ns
//   kParts                  a tuple of its parts
//   kProvided, kProvider    the parts (a PartSet) available before the first stage, and their source
//   Inputs                  all inputs of stages: `frame`, and stage_begins(), stage_took() and left_out(),
//                           each with the stage's index in the table
//   Given                   a tuple of the inputs that are not parts
//   given(inputs, type)     an overload for each type in Given
//   Guard                   validates what stages publish
//   guarded(inputs, guard)  the inputs that stages get, which publish through the guard
//   drop_invalid(inputs, changed, guard)
//                           drops invalid results of the parts that a stage has changed (validate.h)

template <class Floor>
inline constexpr std::size_t kPartCount = std::tuple_size_v<std::remove_cvref_t<decltype(Floor::kParts)>>;

/// Position of the part of type T in the floor's parts; the number of parts if there is none.
template <class Floor, class T>
constexpr std::size_t part_index() {
  std::size_t index = kPartCount<Floor>, i = 0;
  std::apply(
      [&](const auto&... part) {
        ((std::is_same_v<std::remove_cvref_t<decltype(part)>, Part<typename Floor::Frame, T>>
              ? void(index = i++)
              : void(i++)),
         ...);
      },
      Floor::kParts);
  return index;
}

/// A set of parts of any floor, by index: the parts of the frame, then the parts of libraries.
using PartSet = std::bitset<64>;
/// A set of a floor's Given.
using GivenSet = std::bitset<16>;

/// A part that a stage both reads and changes in place.
template <class T>
struct Update {
  T& value;
  T* operator->() const { return &value; }
  T& operator*() const { return value; }
};

template <class Floor, class T>
inline constexpr bool kIsPart = part_index<Floor, T>() < kPartCount<Floor>;

template <class Floor, class Arg>
concept GivenBy = requires(const typename Floor::Inputs& inputs) {
  { Floor::given(inputs, std::type_identity<Arg>{}) } -> std::same_as<Arg>;
};

/// Position of Arg in the floor's Given.
template <class Floor, class Arg>
constexpr std::size_t given_index() {
  std::size_t index = 0;
  bool found = false;
  [&]<class... All>(std::type_identity<std::tuple<All...>>) {
    ((found = found || std::is_same_v<All, Arg>, index += found ? 0 : 1), ...);
  }(std::type_identity<typename Floor::Given>{});
  return index;
}

/// Parameters of one stage, immutable, with their type erased.
using StageParams = std::shared_ptr<const void>;

/// One stage in a running pipeline, with its state between frames.
template <class Floor>
class Step {
 public:
  virtual ~Step() = default;
  /// `params` was made by the same StageType.
  virtual void run(const typename Floor::Inputs& in, const void* params) noexcept = 0;
  /// Writes the state from earlier frames. Called between two frames.
  virtual void save(ByteWriter&) const noexcept {}
  /// Restores the output of save(), which may be forged or from another version. Returns false if it is
  /// invalid; the stage then has no state.
  virtual bool restore(ByteReader&) { return true; }

  StageNotes notes;
};

/// A row of a floor's stage table.
template <class Floor>
struct BasicStageType {
  std::string name, help;
  PartSet reads, writes;
  PartSet updates;  // parts in `reads` that the stage changes in place
  GivenSet takes;
  std::vector<OwnPartUse> own_parts;
  /// Passes on the exceptions of the stage's constructor.
  std::function<std::unique_ptr<Step<Floor>>()> create;
  struct Parsed {
    StageParams params;
    Json complete;  // with defaults filled in
  };
  std::function<Parsed(const Json& json, const std::string& path)> parse;  // throws SettingsError
  std::function<Json()> schema;
  std::string library{};  // the library's file name; empty: built-in stage
};

/// Supplies one parameter of process() and declares what the stage needs for it.
template <class Floor, class Arg>
struct Feed {
  static_assert(
      GivenBy<Floor, Arg>,
      "process() takes a parameter that is neither a part of Frame (const T&, T&, Update<T>) nor anything "
      "else that this floor gives its stages: see pipeline/camera_stage.h and pipeline/field_stage.h");
  static Arg get(const typename Floor::Inputs& in, Step<Floor>&) {
    return Floor::given(in, std::type_identity<Arg>{});
  }
  static void declare(BasicStageType<Floor>& type) {
    static_assert(given_index<Floor, Arg>() < std::tuple_size_v<typename Floor::Given>);
    type.takes.set(given_index<Floor, Arg>());
  }
};
template <class Floor>
struct Feed<Floor, StageNotes&> {
  static StageNotes& get(const typename Floor::Inputs&, Step<Floor>& step) { return step.notes; }
  static void declare(BasicStageType<Floor>&) {}
};
template <class Floor, class T>
requires kIsPart<Floor, T>
struct Feed<Floor, const T&> {
  static const T& get(const typename Floor::Inputs& in, Step<Floor>&) { return part(in); }
  static T& part(const typename Floor::Inputs& in) {
    return in.frame.*std::get<Part<typename Floor::Frame, T>>(Floor::kParts).member;
  }
  static void declare(BasicStageType<Floor>& type) { type.reads.set(part_index<Floor, T>()); }
};
template <class Floor, class T>
requires(kIsPart<Floor, T> && !std::is_const_v<T>) struct Feed<Floor, T&> {
  static T& get(const typename Floor::Inputs& in, Step<Floor>&) { return Feed<Floor, const T&>::part(in); }
  static void declare(BasicStageType<Floor>& type) { type.writes.set(part_index<Floor, T>()); }
};
template <class Floor, class T>
requires kIsPart<Floor, T>
struct Feed<Floor, Update<T>> {
  static Update<T> get(const typename Floor::Inputs& in, Step<Floor>&) {
    return {Feed<Floor, const T&>::part(in)};
  }
  static void declare(BasicStageType<Floor>& type) {
    type.reads.set(part_index<Floor, T>());
    type.updates.set(part_index<Floor, T>());
  }
};
// Parts of libraries.
template <class Floor, OwnPart T>
struct Feed<Floor, const T&> {
  static const T& get(const typename Floor::Inputs& in, Step<Floor>&) { return part(in); }
  static T& part(const typename Floor::Inputs& in) { return in.frame.own_parts.template get<T>(); }
  static void declare(BasicStageType<Floor>& type) {
    type.own_parts.push_back(own_part_use<T>(PartAccess::kReads));
  }
};
template <class Floor, OwnPart T>
requires(!std::is_const_v<T>) struct Feed<Floor, T&> {
  static T& get(const typename Floor::Inputs& in, Step<Floor>&) { return Feed<Floor, const T&>::part(in); }
  static void declare(BasicStageType<Floor>& type) {
    type.own_parts.push_back(own_part_use<T>(PartAccess::kWrites));
  }
};
template <class Floor, OwnPart T>
struct Feed<Floor, Update<T>> {
  static Update<T> get(const typename Floor::Inputs& in, Step<Floor>&) {
    return {Feed<Floor, const T&>::part(in)};
  }
  static void declare(BasicStageType<Floor>& type) {
    type.own_parts.push_back(own_part_use<T>(PartAccess::kUpdates));
  }
};

template <class S>
concept Remembers = requires(S& stage) {
  S::remembered(stage);
};

/// Writes each member of a stage's state, preceded by the hash of its layout.
template <Remembers S>
void save_stage(const S& stage, ByteWriter& to) noexcept {
  std::apply([&]<class... M>(const M&... member) { ((encode(layout_of<M>(), to), encode(member, to)), ...); },
             S::remembered(stage));
}
/// Restores the whole state or nothing.
template <Remembers S>
bool restore_stage(S& stage, ByteReader& from) {
  const auto one = [&]<class M>(M& member) {
    std::uint64_t layout = 0;
    return decode(from, layout) && layout == layout_of<M>() && decode(from, member);
  };
  auto members = S::remembered(stage);
  auto restored = std::apply([](const auto&... member) { return std::tuple(member...); }, members);
  if (!std::apply([&](auto&... member) { return (one(member) && ...); }, restored)) return false;
  members = std::move(restored);
  return true;
}

/// Throws std::logic_error for two parameters of the same name, because the second one could not be set.
template <class P>
Json stage_schema() {
  std::vector<std::string_view> names;
  std::apply([&](const auto&... field) { (names.push_back(field.key), ...); }, P::fields());
  std::sort(names.begin(), names.end());
  const auto twice = std::adjacent_find(names.begin(), names.end());
  if (twice != names.end())
    throw std::logic_error("two of its parameters are called '" + std::string(*twice) + "'");
  return params_schema<P>();
}

template <class Floor, class S, bool kNoexcept, class... Args>
BasicStageType<Floor> describe_stage(std::string_view name, std::string_view help,
                                     void (S::*)(const typename S::Params&, Args...) noexcept(kNoexcept)) {
  static_assert(kNoexcept, "process() must be noexcept: nobody catches what a stage throws");
  using Params = typename S::Params;
  using Type = BasicStageType<Floor>;
  struct Bound final : Step<Floor> {
    S stage;
    void run(const typename Floor::Inputs& in, const void* params) noexcept override {
      stage.process(*static_cast<const Params*>(params), Feed<Floor, Args>::get(in, *this)...);
    }
    void save(ByteWriter& to) const noexcept override {
      if constexpr (Remembers<S>) save_stage(stage, to);
    }
    bool restore(ByteReader& from) override {
      if constexpr (Remembers<S>) {
        return restore_stage(stage, from);
      } else {
        return true;
      }
    }
  };
  Type type;
  type.name = name;
  type.help = help;
  type.create = []() -> std::unique_ptr<Step<Floor>> { return std::make_unique<Bound>(); };
  type.parse = [](const Json& json, const std::string& path) -> typename Type::Parsed {
    auto params = std::make_shared<const Params>(params_from_json<Params>(json, path));
    Json complete = params_to_json(*params);
    return {std::move(params), std::move(complete)};
  };
  type.schema = &stage_schema<Params>;
  (Feed<Floor, Args>::declare(type), ...);
  return type;
}

/// The row for stage class S. A process() that can throw does not compile.
template <class Floor, class S>
BasicStageType<Floor> basic_stage(std::string_view name, std::string_view help) {
  static_assert(
      requires { typename S::Params; }, "a stage needs a nested struct Params");
  return describe_stage<Floor, S>(name, help, &S::process);
}

}  // namespace sslv
