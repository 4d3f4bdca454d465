// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/duration_totals.h"
#include "base/handover.h"
#include "base/recent.h"
#include "base/seqlock.h"
#include "net/multicast.h"
#include "net/tracker_packets.h"
#include "pipeline/field_intake.h"
#include "pipeline/pipeline.h"
#include "pipeline/stage_mark.h"
#include "recording/tracks_for_log.h"
#include "services/field/agreement_now.h"
#include "services/field/ball_learning.h"
#include "services/field/field_now.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

namespace sslv {

/// Stages and settings that process the field's frames; replaced as a whole between two frames.
struct FieldSetup {
  std::shared_ptr<FieldPipeline> pipeline;
  FieldPipeline::Parameters parameters;
  FieldSize field;
  BallModel ball;
  TrackerSource source;
  bool sends = false;  // tracks are sent to the network
};

/// Total of a counter that restarts at 0 now and then. One thread adds, any thread reads.
class CountOverRestarts {
 public:
  void add(std::uint64_t count) noexcept {
    if (count > last_) total_.fetch_add(count - last_, std::memory_order_relaxed);
    last_ = count;
  }
  std::uint64_t total() const noexcept { return total_.load(std::memory_order_relaxed); }

 private:
  std::uint64_t last_ = 0;
  std::atomic<std::uint64_t> total_{0};
};

/// Runs the field's stack in a thread of its own, which yields to the cameras' threads and waits only for
/// their detections. Public functions may be called from any thread.
class RunningField final : private FieldSink, private FieldClock {
 public:
  /// All must outlive this.
  RunningField(FieldIntake& intake, MulticastSender& out, TracksForLog& for_log, BallLearning& ball,
               FieldSetup setup);
  ~RunningField() override { ask_to_stop(); }
  /// Starts stopping without waiting; the destructor waits.
  void ask_to_stop();

  /// Takes effect with the next image.
  void change(FieldSetup setup) { setup_.store(std::move(setup)); }
  std::shared_ptr<const FieldSetup> setup() const { return setup_.load(); }

  FieldNow now() const { return now_.load(); }
  AgreementNow agreement() const { return agreement_.load(); }
  LeftOut left_out() const { return left_out_.load(); }
  /// Number of images, over all cameras.
  std::uint64_t frames() const { return frames_.load(std::memory_order_relaxed); }
  /// Number of filters that were reset since the start because they were not finite.
  std::uint64_t repaired() const { return repaired_.total(); }
  /// Time from a camera's handover until the tracks are on the socket.
  const RecentDurations& latency() const { return latency_; }
  const DurationTotals& latency_total() const { return latency_total_; }
  /// Indexed like the table of the field's stages.
  const std::vector<DurationTotals>& stage_totals() const { return stage_totals_; }
  /// Dropped results of the stages, indexed like stage_totals().
  const std::vector<InvalidTotals>& invalid() const { return invalid_; }
  /// The stage that the thread is in.
  std::optional<StageMark::Reading> stage_now() const { return mark_.read(); }

 private:
  // FieldClock
  double now_s() const noexcept override;
  // FieldSink
  void publish(const TrackedField& tracked) noexcept override;
  void stage_begins(std::size_t stage, std::int64_t now_ns) noexcept override { mark_.begin(stage, now_ns); }
  void stage_took(std::size_t stage, std::int64_t duration_ns) noexcept override {
    mark_.end();
    stage_totals_[stage].add_ns(duration_ns);
  }
  void left_out(std::size_t stage, const InvalidCounts& what) noexcept override { invalid_[stage].add(what); }

  void run(const std::stop_token& ending);
  void process(const ArrivedSightings& arrived) noexcept;

  FieldIntake& intake_;
  MulticastSender& out_;
  TracksForLog& for_log_;
  BallLearning& ball_;
  Handover<FieldSetup> setup_;
  std::atomic<std::uint64_t> frames_{0};
  CountOverRestarts repaired_;  // the tracks' count restarts with a new stack, and if the clock is set back
  RecentDurations latency_;
  DurationTotals latency_total_;
  std::vector<DurationTotals> stage_totals_;
  std::vector<InvalidTotals> invalid_;
  StageMark mark_;
  Seqlock<FieldNow> now_;
  Seqlock<AgreementNow> agreement_;
  Seqlock<LeftOut> left_out_;
  // Used by the thread only.
  FieldFrame frame_;
  KickWatch kick_watch_;
  const FieldSetup* in_use_ = nullptr;
  FieldNow writing_;
  AgreementNow writing_agreement_;
  double agreement_due_s_ = 0;
  TrackerWrapperPacket packet_;
  std::vector<std::byte> buffer_;
  std::jthread thread_;  // last: the thread uses all members above
};

}  // namespace sslv
