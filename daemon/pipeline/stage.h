// SPDX-License-Identifier: Apache-2.0
#pragma once

// Binds stages to frames. This is the one file where types are erased; everything around it is plain.
//
// A stage is a class with a nested `Params` struct (base/params.h) and a member function
//
//   void process(const Params&, const A&, B&, ...) noexcept;
//
// whose signature is the contract: `const T&` reads the part of type T, `T&` writes it from scratch,
// `Update<T>` edits it in place. What else a stage can be given is the floor's: camera_stage.h for the stages
// of one camera, field_stage.h for those of the whole field. Any other parameter does not compile.

#include "base/params_json.h"

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

namespace sslv {

/// A part of a frame: its name in error messages, and its place. Parts are told apart by their type.
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
//   kProvided, kProvider    the parts (a PartSet) that are there before the first stage, and who provides
//   them Inputs                  all that a stage can be given: `frame`, and a stage_took(place in the table,
//   ns) given(inputs, type)     an overload for each parameter of a stage that is no part

template <class Floor>
inline constexpr std::size_t kPartCount = std::tuple_size_v<std::remove_cvref_t<decltype(Floor::kParts)>>;

/// Position of the part of type T in the floor's parts; their count when there is none.
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

/// Which parts; of whatever floor.
using PartSet = std::bitset<16>;

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

/// How one parameter of process() is fed, and what it says about the stage's needs.
template <class Floor, class Arg>
struct Feed {
  static_assert(
      GivenBy<Floor, Arg>,
      "process() takes a parameter that is neither a part of Frame (const T&, T&, Update<T>) nor anything "
      "else that this floor gives its stages: see pipeline/camera_stage.h and pipeline/field_stage.h");
  static Arg get(const typename Floor::Inputs& in) { return Floor::given(in, std::type_identity<Arg>{}); }
  static void declare(PartSet&, PartSet&) {}
};
template <class Floor, class T>
requires kIsPart<Floor, T>
struct Feed<Floor, const T&> {
  static const T& get(const typename Floor::Inputs& in) { return part(in); }
  static T& part(const typename Floor::Inputs& in) {
    return in.frame.*std::get<Part<typename Floor::Frame, T>>(Floor::kParts).member;
  }
  static void declare(PartSet& reads, PartSet&) { reads.set(part_index<Floor, T>()); }
};
template <class Floor, class T>
requires(kIsPart<Floor, T> && !std::is_const_v<T>) struct Feed<Floor, T&> {
  static T& get(const typename Floor::Inputs& in) { return Feed<Floor, const T&>::part(in); }
  static void declare(PartSet&, PartSet& writes) { writes.set(part_index<Floor, T>()); }
};
template <class Floor, class T>
requires kIsPart<Floor, T>
struct Feed<Floor, Update<T>> {
  static Update<T> get(const typename Floor::Inputs& in) { return {Feed<Floor, const T&>::part(in)}; }
  static void declare(PartSet& reads, PartSet&) { reads.set(part_index<Floor, T>()); }
};

/// Parameters of one stage, immutable, with their type erased.
using StageParams = std::shared_ptr<const void>;

/// One stage in a running pipeline, with whatever it remembers between frames.
template <class Floor>
class Step {
 public:
  virtual ~Step() = default;
  /// `params` was made by the same StageType.
  virtual void run(const typename Floor::Inputs& in, const void* params) noexcept = 0;
};

/// A row of a floor's stage table.
template <class Floor>
struct BasicStageType {
  std::string_view name, help;
  PartSet reads, writes;
  std::unique_ptr<Step<Floor>> (*create)();
  struct Parsed {
    StageParams params;
    Json complete;  // with defaults filled in
  };
  Parsed (*parse)(const Json& json, const std::string& path);  // throws SettingsError
  Json (*schema)();
};

template <class Floor, class S, bool kNoexcept, class... Args>
BasicStageType<Floor> describe_stage(std::string_view name, std::string_view help,
                                     void (S::*)(const typename S::Params&, Args...) noexcept(kNoexcept)) {
  static_assert(kNoexcept, "process() must be noexcept: nobody catches what a stage throws");
  using Params = typename S::Params;
  using Type = BasicStageType<Floor>;
  struct Bound final : Step<Floor> {
    S stage;
    void run(const typename Floor::Inputs& in, const void* params) noexcept override {
      stage.process(*static_cast<const Params*>(params), Feed<Floor, Args>::get(in)...);
    }
  };
  Type type{name,
            help,
            {},
            {},
            +[]() -> std::unique_ptr<Step<Floor>> { return std::make_unique<Bound>(); },
            +[](const Json& json, const std::string& path) -> typename Type::Parsed {
              auto params = std::make_shared<const Params>(params_from_json<Params>(json, path));
              Json complete = params_to_json(*params);
              return {std::move(params), std::move(complete)};
            },
            &params_schema<Params>};
  (Feed<Floor, Args>::declare(type.reads, type.writes), ...);
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
