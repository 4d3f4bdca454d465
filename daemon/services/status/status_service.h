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

/// How the service is, put together of what all services say: status, alerts, checks, metrics, the support
/// bundle; and this computer itself.
class StatusService final : public Service, public Topic {
 public:
  /// All must outlive this. `state_folder`: whose disk is watched, and where the history is kept.
  /// `network_missing`: see NetworkService::missing().
  StatusService(const std::filesystem::path& state_folder, const Cameras& cameras, const WebCounters& web,
                std::function<std::string()> network_missing);
  /// All other services are still there.
  ~StatusService() override;

  /// Who is asked, in the order in which checks are shown; this service itself among them. Before the first
  /// request.
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
  Computer computer_reader_;  // of the thread of each_second()
  mutable std::mutex mutex_;  // guards the next two
  ComputerFigures computer_;
  std::optional<ClockFigures> clock_;
};

}  // namespace sslv
