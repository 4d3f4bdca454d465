// SPDX-License-Identifier: Apache-2.0
#pragma once

// Inputs of the stages of one camera besides the parts of its frame.

#include "pipeline/frame.h"
#include "pipeline/stage.h"
#include "pipeline/validate.h"

#include <cstddef>
#include <cstdint>
#include <tuple>
#include <type_traits>
#include <utility>

namespace sslv {

/// Destination of finished detections: the daemon's multicast socket or the command line's file.
class DetectionSink {
 public:
  virtual ~DetectionSink() = default;
  /// Called from the camera's thread, once per frame, even if nothing was found. Must not block.
  virtual void publish(const FrameInfo& info, const Scene& scene, const RobotList& robots,
                       const BallList& balls) noexcept = 0;
  /// Called from the camera's thread before and after each stage, with the stage's index in the stage table
  /// and its start (steady_ns()) or duration (ns).
  virtual void stage_begins(std::size_t, std::int64_t) noexcept {}
  virtual void stage_took(std::size_t, std::int64_t) noexcept {}
  /// Called from the camera's thread if some of a stage's results were dropped.
  virtual void left_out(std::size_t, const InvalidCounts&) noexcept {}
};

/// Validates everything that is published, including a stage's own lists.
class DetectionGuard final : public DetectionSink {
 public:
  /// Begins the next frame; `info` is the camera's data of this frame.
  void begin(DetectionSink& out, const FrameInfo& info) {
    out_ = &out;
    info_ = info;
  }
  const FrameInfo& info() const { return info_; }
  /// Counts of the results dropped since the last call.
  InvalidCounts take_left_out() noexcept { return std::exchange(left_out_, {}); }

  void publish(const FrameInfo& info, const Scene& scene, const RobotList& robots,
               const BallList& balls) noexcept override;

 private:
  DetectionSink* out_ = nullptr;
  FrameInfo info_;
  InvalidCounts left_out_;
  RobotList robots_;  // used only if some results are dropped
  BallList balls_;
};

struct CameraFloor {
  using Frame = sslv::Frame;
  static constexpr std::tuple kParts{
      Part{"info", &Frame::info},   Part{"image", &Frame::image},     Part{"labels", &Frame::labels},
      Part{"runs", &Frame::runs},   Part{"regions", &Frame::regions}, Part{"robots", &Frame::robots},
      Part{"balls", &Frame::balls},
  };
  static constexpr PartSet kProvided{0b11};  // info and image
  static constexpr std::string_view kProvider = "the camera";

  struct Inputs {
    Frame& frame;
    const CameraContext& context;
    DetectionSink& sink;
    void stage_begins(std::size_t stage, std::int64_t now_ns) const noexcept {
      sink.stage_begins(stage, now_ns);
    }
    void left_out(std::size_t stage, const InvalidCounts& what) const noexcept { sink.left_out(stage, what); }
    void stage_took(std::size_t stage, std::int64_t duration_ns) const noexcept {
      sink.stage_took(stage, duration_ns);
    }
  };

  using Given = std::tuple<const Scene&, const Lut&, const Mask&, const PatternTable&, DetectionSink&>;
  static const Scene& given(const Inputs& in, std::type_identity<const Scene&>) { return *in.context.scene; }
  static const Lut& given(const Inputs& in, std::type_identity<const Lut&>) {
    return *in.context.adapted_lut;
  }
  static const Mask& given(const Inputs& in, std::type_identity<const Mask&>) {
    return in.context.looked_at();
  }
  static const PatternTable& given(const Inputs& in, std::type_identity<const PatternTable&>) {
    return *in.context.patterns;
  }
  static DetectionSink& given(const Inputs& in, std::type_identity<DetectionSink&>) { return in.sink; }

  using Guard = DetectionGuard;
  static Inputs guarded(const Inputs& in, Guard& guard) {
    guard.begin(in.sink, in.frame.info);
    return {in.frame, in.context, guard};
  }
  static InvalidCounts drop_invalid(const Inputs& in, const PartSet& changed, const Guard& guard) noexcept;
};

using StageType = BasicStageType<CameraFloor>;

/// The row for stage class S of a camera's stack.
template <class S>
StageType stage(std::string_view name, std::string_view help) {
  return basic_stage<CameraFloor, S>(name, help);
}

}  // namespace sslv
