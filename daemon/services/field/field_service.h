// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/snapshot.h"
#include "config/config.h"
#include "net/heard_cameras.h"
#include "net/multicast.h"
#include "pipeline/field_intake.h"
#include "services/field/agreement_history.h"
#include "services/field/ball_learning.h"
#include "services/field/running_field.h"
#include "services/service.h"
#include "services/settings/settings_editor.h"
#include "services/stage_report.h"
#include "services/stage_watch.h"
#include "settings/state_folder.h"
#include "web/route.h"

#include <chrono>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>

namespace sslv {

/// Tracks robots and balls from the detections of all the field's cameras, on this computer and on others,
/// and sends the tracks to the network and to viewers.
class FieldService final : public Service, public Topic {
 public:
  /// All must outlive this. `config`: the current settings.
  FieldService(const Snapshot<Config>& config, FieldIntake& intake, SettingsEditor& settings,
               StateFolder& folder, TracksForLog& for_log);

  /// Processes a message of another computer's vision, received at monotonic time `now_s`. `is_named`: the
  /// settings name that computer. Called by the listening thread.
  void hear(const VisionMessage& message, const std::string& address, bool is_named, double now_s);
  /// Whether this is the sender of our own tracks. Thread-safe.
  bool is_own(const boost::asio::ip::udp::endpoint& sender) const { return sender_.is_own(sender); }

  // Topic
  const char* topic_name() const override { return "field"; }
  std::chrono::milliseconds topic_period() const override { return std::chrono::milliseconds(33); }
  Json topic_data() override;

  // Service
  void ask_to_stop() override { running_.ask_to_stop(); }
  std::vector<Route> routes() override;
  Plan plan(const SettingsChange& change) const override;
  void report(HealthReport& report) const override;
  void add_diagnostics(Json& diagnostics) const override;
  void write_metrics(MetricsText& out) const override;
  void each_second() override;

 private:
  /// `before`: the current pipeline, reused if its stack is the same.
  FieldSetup make_setup(const Config& config, std::shared_ptr<FieldPipeline> before = nullptr) const;
  Json field_json();
  Json kicks_json();
  Json agreement_json() const;
  void take_kicks();
  void look_at_stages();
  StackFacts stack_facts() const;
  std::uint64_t images_off_time_lately() const;
  std::optional<Hang> hang() const;

  const Snapshot<Config>& config_;
  FieldIntake& intake_;
  SettingsEditor& settings_;
  const std::string uuid_;
  MulticastSender sender_;
  const std::shared_ptr<SightingsQueue> heard_queue_;
  mutable std::mutex heard_mutex_;  // guards the next two; never locked by a camera's or the field's thread
  HeardCameras heard_cameras_;
  ArrivedSightings heard_;
  mutable std::mutex history_mutex_;
  AgreementHistory history_;
  mutable std::mutex stages_mutex_;  // guards the next two
  StageWatch stage_watch_;
  struct Load {  // totals since the start, at steady_s
    std::uint64_t frames, lost, images_off_time;
    double steady_s;
  };
  std::deque<Load> loads_;  // the newest last
  std::mutex kicks_mutex_;
  std::deque<TrackedKick> kicks_;  // the newest last
  bool was_hanging_ = false;       // used by the thread of each_second() only
  BallLearning ball_;
  RunningField running_;  // last: its thread uses the members above
};

}  // namespace sslv
