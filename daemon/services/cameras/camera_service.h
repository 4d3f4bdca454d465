// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/cameras/camera_report.h"
#include "services/cameras/camera_watch.h"
#include "services/cameras/loss_log.h"
#include "services/cameras/running_cameras.h"
#include "services/service.h"

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace sslv {

/// Reports on the running cameras for the panel, alerts and metrics.
class CameraService final : public Service {
 public:
  /// `cameras` must outlive this.
  explicit CameraService(RunningCameras& cameras) : cameras_(cameras) {}

  // Service
  void ask_to_stop() override { cameras_.ask_to_stop(); }
  std::vector<Route> routes() override;
  Plan plan(const SettingsChange& change) const override { return cameras_.plan(change); }
  void report(HealthReport& report) const override;
  void add_diagnostics(Json& diagnostics) const override;
  void write_metrics(MetricsText& out) const override;
  std::vector<SupportFile> support_files() const override;
  void each_second() override;
  std::vector<Event> take_events() override { return events_.take(); }

  /// See camera_summary().
  std::string summary() const;

 private:
  using List = std::vector<std::shared_ptr<RunningCamera>>;
  /// Returns the facts about each camera.
  std::vector<CameraFacts> facts_of(const List& cameras) const;

  /// Adds events, and logs lost images.
  void tell_what_became(const List& cameras);

  RunningCameras& cameras_;
  CameraWatch watch_;
  EventQueue events_;
  /// Counts of a camera at the last call of tell_what_became(), to detect new events; used by each_second()'s
  /// thread.
  struct Told {
    std::optional<std::uint64_t> reconnects, reopenings;
    LossLog losses;
  };
  std::map<int, Told> told_;  // by id
};

}  // namespace sslv
