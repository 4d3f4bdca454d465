// SPDX-License-Identifier: Apache-2.0
#include "services/status/status_service.h"

#include "base/clock.h"
#include "base/log.h"
#include "config/version.h"
#include "health/metrics_text.h"
#include "services/status/computer_report.h"
#include "services/status/support_bundle.h"

#include <cstdint>
#include <exception>
#include <utility>

namespace sslv {
namespace {

std::string pretty(const Json& json) {
  return json_text(json, 2) + "\n";
}

/// For monitoring: 200 unless there is a problem.
Response verdict(std::string problem) {
  const int status = problem.empty() ? 200 : 503;
  if (problem.empty()) problem = "ok";
  if (!problem.ends_with('\n')) problem += '\n';
  return text_response(std::move(problem), status);
}

Response get_log(const Request& request) {
  const int after = query_number(request, "after", 0, 0, kMaxRouteNumber);
  const auto named = request.query.find("level");
  const std::string name = named == request.query.end() ? "debug" : named->second;
  const auto least = log::level_named(name);
  if (!least) {
    throw HttpError(400, "level: \"" + name.substr(0, 40) +
                             "\" is not allowed; expected \"debug\", \"info\", \"warning\" or \"error\"");
  }
  const auto [lines, newest] = log::recent().newer_than(static_cast<std::uint64_t>(after), *least);
  Json out{{"lines", Json::array()}, {"next", newest}};
  for (const auto& line : lines) {
    out["lines"].push_back(
        {{"seq", line.seq}, {"time", line.time_s}, {"level", log::name_of(line.level)}, {"text", line.text}});
  }
  return json_response(out);
}

}  // namespace

StatusService::StatusService(const std::filesystem::path& state_folder, const Cameras& cameras,
                             const WebCounters& web, std::function<std::string()> network_missing)
    : started_s_(steady_s()),
      cameras_(cameras),
      web_(web),
      network_missing_(std::move(network_missing)),
      history_(state_folder),
      computer_reader_(state_folder),
      computer_(computer_reader_.read()),
      clock_(read_clock()) {}

StatusService::~StatusService() {
  if (!history_.has_started()) return;
  try {
    history_.look(make_report(nullptr).alerts, take_all_events());  // alerts and events of the last second
  } catch (const std::exception& error) {
    log::error("the last alerts and events were not saved: {}", error.what());
  }
}

std::vector<Event> StatusService::take_all_events() {
  std::vector<Event> out;
  for (Service* service : services_) {
    for (Event& event : service->take_events()) out.push_back(std::move(event));
  }
  return out;
}

HealthReport StatusService::make_report(Json* status) const {
  HealthReport report;
  report.status = status;
  for (const Service* service : services_) service->report(report);
  report.finish();
  alert_times_.stamp(report.alerts, unix_time_s(), steady_s());
  return report;
}

Json StatusService::status_json() const {
  Json out = Json::object();
  const HealthReport report = make_report(&out);
  out.update(Json{{"version", kVersion},
                  {"time", unix_time_s()},
                  {"uptime_s", steady_s() - started_s_},
                  {"viewers", web_.viewers.load()},
                  {"go", report.is_go()},
                  {"alerts", Json::array()},
                  {"checks", Json::array()}});
  for (const Alert& alert : report.alerts) out["alerts"].push_back(to_json(alert));
  for (const Check& check : report.checks) out["checks"].push_back(to_json(check));
  return out;
}

Json StatusService::diagnostics_json() const {
  Json out = Json::object();
  for (const Service* service : services_) service->add_diagnostics(out);
  return out;
}

std::string StatusService::metrics_text() const {
  MetricsText out;
  out.begin("sslv_build_info", "gauge", "Always 1; the label is the version.");
  out.add({{"version", kVersion}}, std::uint64_t{1});
  for (const Service* service : services_) service->write_metrics(out);
  return out.take();
}

Response StatusService::get_support(const Request& request) const {
  std::optional<SupportRecording> clip;
  if (const auto named = request.query.find("clip"); named != request.query.end()) {
    for (const Service* service : services_) {
      if (!clip) clip = service->support_clip(named->second);
    }
    if (!clip) throw HttpError(404, "clip: there is no such clip");
  }
  std::vector<SupportFile> files;
  for (const Service* service : services_) {
    for (SupportFile& file : service->support_files()) files.push_back(std::move(file));
  }
  return support_bundle(files, clip, request.stop);
}

std::vector<Route> StatusService::routes() {
  const auto part_of_status = [this](std::vector<std::string> keys) -> Handler {
    return [this, keys = std::move(keys)](const Request&) {
      const Json status = status_json();
      Json out = Json::object();
      for (const std::string& key : keys) out[key] = status.at(key);
      return json_response(out);
    };
  };
  Route support{"GET", "/api/support", [this](const Request& request) { return get_support(request); },
                Needs::kChange};
  support.streams = true;
  return {
      support,
      {"GET", "/api/status", [this](const Request&) { return json_response(status_json()); }},
      {"GET", "/api/alerts", part_of_status({"alerts"})},
      {"GET", "/api/checks", part_of_status({"go", "checks"})},
      {"GET", "/api/events", [this](const Request&) { return json_response(history_.to_json()); }},
      {"GET", "/api/diagnostics", [this](const Request&) { return json_response(diagnostics_json()); }},
      {"GET", "/api/log", get_log},
      // The paths that monitoring tools expect.
      {"GET", "/metrics",
       [this](const Request&) {
         return Response{200, "text/plain; version=0.0.4; charset=utf-8", metrics_text()};
       },
       Needs::kNothing, Speed::kAtOnce},
      {"GET", "/healthz", [this](const Request&) { return verdict(cameras_.hanging()); }, Needs::kNothing,
       Speed::kAtOnce},
      {"GET", "/readyz", [this](const Request&) { return verdict(cameras_.missing() + network_missing_()); },
       Needs::kNothing, Speed::kAtOnce},
  };
}

void StatusService::report(HealthReport& report) const {
  const std::lock_guard lock(mutex_);
  report_computer(computer_, clock_, report);
}

void StatusService::add_diagnostics(Json& diagnostics) const {
  {
    const std::lock_guard lock(mutex_);
    diagnostics["system"] = computer_json(computer_);
    diagnostics["clock"] = clock_json(clock_);
  }
  diagnostics["web"] = {{"connections", web_.connections.load()},
                        {"viewers", web_.viewers.load()},
                        {"jpegs_encoded", web_.jpegs_encoded.load()},
                        {"unsent", web_.unsent.load()}};
}

void StatusService::write_metrics(MetricsText& out) const {
  out.begin("sslv_preview_clients", "gauge",
            "Panels and other viewers connected by WebSocket, without second connections.");
  out.add({}, static_cast<double>(web_.viewers.load()));
  out.begin("sslv_web_unsent_total", "counter",
            "Answers, images and requests that were dropped because too many waited for slow clients.");
  out.add({}, web_.unsent.load());
  const std::lock_guard lock(mutex_);
  if (!clock_) return;
  out.begin("sslv_clock_offset_seconds", "gauge", "Clock error that the kernel still has to correct.");
  out.add({}, clock_->offset_ms * 1e-3);
  out.begin("sslv_clock_synchronized", "gauge", "1 while the kernel says that the clock is synchronised.");
  out.add({}, std::uint64_t{clock_->synchronised});
}

std::vector<SupportFile> StatusService::support_files() const {
  return {{"version.txt", "the program's version", [] { return std::string(kVersion) + "\n"; }},
          {"status.json", "cameras, network, alerts, as /api/status has them",
           [this] { return pretty(status_json()); }},
          {"diagnostics.json", "this computer, its clock, how long every stage takes",
           [this] { return pretty(diagnostics_json()); }},
          {"events.json", "alerts and events of the last 24 hours",
           [this] { return pretty(history_.to_json()); }},
          {"log.txt", "the last lines of the log", log_text}};
}

void StatusService::each_second() {
  ComputerFigures computer = computer_reader_.read();
  const auto clock = read_clock();
  {
    const std::lock_guard lock(mutex_);
    computer_ = std::move(computer);
    clock_ = clock;
  }
  // Also detects interruptions of an alert while nobody requests the status.
  const std::vector<Alert> alerts = make_report(nullptr).alerts;
  history_.look(alerts, take_all_events());
  for (Service* service : services_) service->see_alerts(alerts);
}

}  // namespace sslv
