// SPDX-License-Identifier: Apache-2.0
#pragma once

// Binds stages to frames. This is the one file where types are erased; everything around it is plain.
//
// A stage is a class with a nested `Params` struct (base/params.h) and a member function
//
//   void process(const Params&, const A&, B&, ...) noexcept;
//
// whose signature is the contract: `const T&` reads the part of type T, `T&` writes it from scratch,
// `Update<T>` edits it in place. `const Scene&`, `const Lut&`, `const Mask&` and `const PatternTable&` are
// constants of the camera, `DetectionSink&` is where results leave the process. Any other parameter does not
// compile.

#include "base/params_json.h"
#include "pipeline/frame.h"

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

/// Where finished detections go: the multicast socket of the daemon, a file of the command line.
class DetectionSink {
 public:
  virtual ~DetectionSink() = default;
  /// Called from the camera's thread, once a frame, also when nothing was found. Must not block.
  virtual void publish(const FrameInfo& info, const RobotList& robots, const BallList& balls) noexcept = 0;
  /// Likewise, after each stage: its place in the table of stages, and its time.
  virtual void stage_took(std::size_t, std::int64_t) noexcept {}
};

inline constexpr std::size_t kPartCount = std::tuple_size_v<decltype(kParts)>;
using PartSet = std::bitset<kPartCount>;

/// Position of the part of type T in kParts; kPartCount when Frame has none.
template <class T>
constexpr std::size_t part_index() {
  std::size_t index = kPartCount, i = 0;
  std::apply(
      [&](const auto&... part) {
        ((std::is_same_v<std::remove_cvref_t<decltype(part)>, Part<T>> ? void(index = i++) : void(i++)), ...);
      },
      kParts);
  return index;
}

template <class T>
T& part_of(Frame& frame) {
  return frame.*std::get<Part<T>>(kParts).member;
}

/// A part that a stage both reads and changes in place.
template <class T>
struct Update {
  T& value;
  T* operator->() const { return &value; }
  T& operator*() const { return value; }
};

/// All that a stage can be given besides its parameters.
struct Inputs {
  Frame& frame;
  const CameraContext& context;
  DetectionSink& sink;
};

template <class T>
inline constexpr bool kIsPart = part_index<T>() < kPartCount;

/// How one parameter of process() is fed, and what it says about the stage's needs.
template <class Arg>
struct Feed {
  static_assert(
      !sizeof(Arg),
      "process() takes a parameter that is neither a part of Frame (const T&, T&, Update<T>) nor a constant "
      "of the camera (const Scene&, const Lut&, const Mask&, const PatternTable&) nor DetectionSink&: see "
      "pipeline/frame.h");
};
template <class T>
requires kIsPart<T>
struct Feed<const T&> {
  static const T& get(const Inputs& in) { return part_of<T>(in.frame); }
  static void declare(PartSet& reads, PartSet&) { reads.set(part_index<T>()); }
};
template <class T>
requires(kIsPart<T> && !std::is_const_v<T>) struct Feed<T&> {
  static T& get(const Inputs& in) { return part_of<T>(in.frame); }
  static void declare(PartSet&, PartSet& writes) { writes.set(part_index<T>()); }
};
template <class T>
requires kIsPart<T>
struct Feed<Update<T>> {
  static Update<T> get(const Inputs& in) { return {part_of<T>(in.frame)}; }
  static void declare(PartSet& reads, PartSet&) { reads.set(part_index<T>()); }
};
template <>
struct Feed<const Scene&> {
  static const Scene& get(const Inputs& in) { return *in.context.scene; }
  static void declare(PartSet&, PartSet&) {}
};
template <>
struct Feed<const Lut&> {
  static const Lut& get(const Inputs& in) { return *in.context.adapted_lut; }
  static void declare(PartSet&, PartSet&) {}
};
template <>
struct Feed<const Mask&> {
  static const Mask& get(const Inputs& in) { return in.context.looked_at(); }
  static void declare(PartSet&, PartSet&) {}
};
template <>
struct Feed<const PatternTable&> {
  static const PatternTable& get(const Inputs& in) { return *in.context.patterns; }
  static void declare(PartSet&, PartSet&) {}
};
template <>
struct Feed<DetectionSink&> {
  static DetectionSink& get(const Inputs& in) { return in.sink; }
  static void declare(PartSet&, PartSet&) {}
};

/// Parameters of one stage, immutable, with their type erased.
using StageParams = std::shared_ptr<const void>;

/// One stage in a running pipeline, with whatever it remembers between frames.
class Step {
 public:
  virtual ~Step() = default;
  /// `params` was made by the same StageType.
  virtual void run(const Inputs& in, const void* params) noexcept = 0;
};

/// A row of the stage table.
struct StageType {
  std::string_view name, help;
  PartSet reads, writes;
  std::unique_ptr<Step> (*create)();
  struct Parsed {
    StageParams params;
    Json complete;  // with defaults filled in
  };
  Parsed (*parse)(const Json& json, const std::string& path);  // throws SettingsError
  Json (*schema)();
};

template <class S, bool kNoexcept, class... Args>
StageType describe_stage(std::string_view name, std::string_view help,
                         void (S::*)(const typename S::Params&, Args...) noexcept(kNoexcept)) {
  static_assert(kNoexcept, "process() must be noexcept: nobody catches what a stage throws");
  using Params = typename S::Params;
  struct Bound final : Step {
    S stage;
    void run(const Inputs& in, const void* params) noexcept override {
      stage.process(*static_cast<const Params*>(params), Feed<Args>::get(in)...);
    }
  };
  StageType type{name,
                 help,
                 {},
                 {},
                 +[]() -> std::unique_ptr<Step> { return std::make_unique<Bound>(); },
                 +[](const Json& json, const std::string& path) -> StageType::Parsed {
                   auto params = std::make_shared<const Params>(params_from_json<Params>(json, path));
                   Json complete = params_to_json(*params);
                   return {std::move(params), std::move(complete)};
                 },
                 &params_schema<Params>};
  (Feed<Args>::declare(type.reads, type.writes), ...);
  return type;
}

/// The row for stage class S. A process() that can throw does not compile.
template <class S>
StageType stage(std::string_view name, std::string_view help) {
  static_assert(
      requires { typename S::Params; }, "a stage needs a nested struct Params");
  return describe_stage<S>(name, help, &S::process);
}

}  // namespace sslv
