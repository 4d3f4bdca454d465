// SPDX-License-Identifier: Apache-2.0
#include "services/field/running_field.h"

#include "base/background.h"
#include "base/clock.h"
#include "config/stages.h"

#include <chrono>

namespace sslv {
namespace {

/// Nice value, lower than for threads that only serve viewers, because teams wait for tracks.
constexpr int kNice = 5;
constexpr double kAgreementEvery_s = 1;

}  // namespace

RunningField::RunningField(FieldIntake& intake, MulticastSender& out, TracksForLog& for_log,
                           BallLearning& ball, FieldSetup setup)
    : intake_(intake),
      out_(out),
      for_log_(for_log),
      ball_(ball),
      setup_(std::move(setup)),
      stage_totals_(field_stage_table().size()),
      invalid_(field_stage_table().size()),
      thread_([this](const std::stop_token& ending) {
        become_background_thread("field", kNice);
        run(ending);
      }) {}

void RunningField::ask_to_stop() {
  thread_.request_stop();
  intake_.ring();
}

double RunningField::now_s() const noexcept {
  return unix_time_s();
}

void RunningField::run(const std::stop_token& ending) {
  while (!ending.stop_requested()) {
    const std::uint32_t mark = intake_.mark();
    if (intake_.take([this](const ArrivedSightings& arrived) { process(arrived); })) continue;
    if (ending.stop_requested()) return;
    intake_.wait(mark, std::chrono::steady_clock::now() + std::chrono::seconds(1));
  }
}

void RunningField::process(const ArrivedSightings& arrived) noexcept {
  const auto setup = setup_.use();
  in_use_ = &*setup;
  frame_.arrived = arrived;
  setup->pipeline->run({frame_, setup->field, setup->ball, *this, *this}, setup->parameters);
  frames_.fetch_add(1, std::memory_order_relaxed);
  left_out_.store(frame_.left_out);
  repaired_.add(frame_.agreement.repaired() + frame_.tracked.repaired);
  if (const WatchedKick* kick = kick_watch_.add(frame_.observations, frame_.tracked)) ball_.hand_over(*kick);
  const double now_s = unix_time_s();
  if (now_s >= agreement_due_s_ || agreement_due_s_ > now_s + 2 * kAgreementEvery_s) {
    agreement_due_s_ = now_s + kAgreementEvery_s;
    write_now(frame_.agreement, now_s, writing_agreement_);
    agreement_.store(writing_agreement_);
  }
}

void RunningField::publish(const TrackedField& tracked) noexcept {
  if (in_use_->sends) {
    write_tracked(tracked, in_use_->source, packet_);
    out_.send(serialize(packet_, buffer_));
  } else if (const std::int64_t now_ns = steady_ns(); for_log_.is_due(now_ns)) {
    write_tracked(tracked, in_use_->source, packet_);
    for_log_.write(now_ns, unix_time_ns(), serialize(packet_, buffer_));
  }
  const std::int64_t took_ns = steady_ns() - frame_.arrived.handed_over_ns;
  latency_.add_ns(took_ns);
  latency_total_.add_ns(took_ns);
  write_now(tracked, writing_);
  now_.store(writing_);
}

}  // namespace sslv
