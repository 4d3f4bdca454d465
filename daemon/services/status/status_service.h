// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "health/computer.h"
#include "services/cameras/cameras.h"
#include "services/service.h"
#include "services/status/alert_times.h"
#include "services/status/history_keeper.h"
#include "web/counters.h"

#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace sslv {

/// The state of the whole service, from the reports of all services: status, alerts, checks, metrics, the
/// support bundle; and the state of this computer.
class StatusService final : public Service, public Topic {
 public:
  /// All must outlive this. `state_folder`: its disk is monitored, and the history is stored in it.
  /// `network_missing`: see NetworkService::missing().
  StatusService(const std::filesystem::path& state_folder, const Cameras& cameras, const WebCounters& web,
                std::function<std::string()> network_missing);
  /// All other services must still exist.
  ~StatusService() override;

  /// The services to query, in the order in which checks are shown, including this one. Call it before the
  /// first request.
  void set_services(std::vector<Service*> services) { services_ = std::move(services); }

  // Topic
  const char* topic_name() const override { return "status"; }
  Json topic_data() override { return status_json(); }

  // Service
  std::vector<Route> routes() override;
  void report(HealthReport& report) const override;
  void add_diagnostics(Json& diagnostics) const override;
  void write_metrics(MetricsText& out) const override;
  std::vector<SupportFile> support_files() const override;
  void each_second() override;

 private:
  std::vector<Event> take_all_events();
  /// `status`: see HealthReport.
  HealthReport make_report(Json* status) const;
  Json status_json() const;
  Json diagnostics_json() const;
  std::string metrics_text() const;
  Response get_support(const Request& request) const;

  const double started_s_;  // on the steady clock
  const Cameras& cameras_;
  const WebCounters& web_;
  const std::function<std::string()> network_missing_;
  std::vector<Service*> services_;
  mutable AlertTimes alert_times_;
  HistoryKeeper history_;
  Computer computer_reader_;  // used by the thread that calls each_second()
  mutable std::mutex mutex_;  // guards computer_ and clock_
  ComputerFigures computer_;
  std::optional<ClockFigures> clock_;
};

}  // namespace sslv
