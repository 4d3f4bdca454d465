// SPDX-License-Identifier: Apache-2.0
#pragma once

// Inputs of the stages of the whole field besides the parts of its frame.

#include "geometry/field.h"
#include "pipeline/field_frame.h"
#include "pipeline/stage.h"
#include "pipeline/validate.h"
#include "tracking/ball_motion.h"
#include "tracking/field_clock.h"

#include <cstddef>
#include <cstdint>
#include <tuple>
#include <type_traits>
#include <utility>

namespace sslv {

/// Destination of tracks: the multicast socket of the daemon and its panel.
class FieldSink {
 public:
  virtual ~FieldSink() = default;
  /// Called from the field's thread, once for every image of every camera. Must not block.
  virtual void publish(const TrackedField& tracked) noexcept = 0;
  /// Called from the field's thread before and after each stage, with the stage's index in the stage table
  /// and its start (steady_ns()) or duration (ns).
  virtual void stage_begins(std::size_t, std::int64_t) noexcept {}
  virtual void stage_took(std::size_t, std::int64_t) noexcept {}
  /// Called from the field's thread if some of a stage's results were dropped.
  virtual void left_out(std::size_t, const InvalidCounts&) noexcept {}
};

/// Validates everything that is published, including a stage's own tracks.
class FieldGuard final : public FieldSink {
 public:
  void begin(FieldSink& out) { out_ = &out; }
  /// Counts of the results dropped since the last call.
  InvalidCounts take_left_out() noexcept { return std::exchange(left_out_, {}); }

  void publish(const TrackedField& tracked) noexcept override;

 private:
  FieldSink* out_ = nullptr;
  InvalidCounts left_out_;
  TrackedField tracked_;  // used only if something is dropped
};

struct FieldFloor {
  using Frame = FieldFrame;
  static constexpr std::tuple kParts{
      Part{"arrived", &FieldFrame::arrived},           Part{"sightings", &FieldFrame::sightings},
      Part{"left_out", &FieldFrame::left_out},         Part{"time", &FieldFrame::time},
      Part{"observations", &FieldFrame::observations}, Part{"agreement", &FieldFrame::agreement},
      Part{"tracked", &FieldFrame::tracked},
  };
  static constexpr PartSet kProvided{0b1};  // arrived
  static constexpr std::string_view kProvider = "the camera input";

  struct Inputs {
    FieldFrame& frame;
    const FieldSize& field;
    const BallModel& ball;
    const FieldClock& clock;
    FieldSink& sink;
    void stage_begins(std::size_t stage, std::int64_t now_ns) const noexcept {
      sink.stage_begins(stage, now_ns);
    }
    void left_out(std::size_t stage, const InvalidCounts& what) const noexcept { sink.left_out(stage, what); }
    void stage_took(std::size_t stage, std::int64_t duration_ns) const noexcept {
      sink.stage_took(stage, duration_ns);
    }
  };

  using Given = std::tuple<const FieldSize&, const BallModel&, const FieldClock&, FieldSink&>;
  static const FieldSize& given(const Inputs& in, std::type_identity<const FieldSize&>) { return in.field; }
  static const BallModel& given(const Inputs& in, std::type_identity<const BallModel&>) { return in.ball; }
  static const FieldClock& given(const Inputs& in, std::type_identity<const FieldClock&>) { return in.clock; }
  static FieldSink& given(const Inputs& in, std::type_identity<FieldSink&>) { return in.sink; }

  using Guard = FieldGuard;
  static Inputs guarded(const Inputs& in, Guard& guard) {
    guard.begin(in.sink);
    return {in.frame, in.field, in.ball, in.clock, guard};
  }
  static InvalidCounts drop_invalid(const Inputs& in, const PartSet& changed, const Guard& guard) noexcept;
};

using FieldStageType = BasicStageType<FieldFloor>;

/// The row for stage class S of the field's stack.
template <class S>
FieldStageType field_stage(std::string_view name, std::string_view help) {
  return basic_stage<FieldFloor, S>(name, help);
}

/// Passes the tracks to the sink on the field's own thread.
class PublishField {
 public:
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  /// Calls sink.publish(tracked).
  void process(const Params&, const TrackedField& tracked, FieldSink& sink) noexcept {
    sink.publish(tracked);
  }
};

}  // namespace sslv
