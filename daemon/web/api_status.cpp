// SPDX-License-Identifier: Apache-2.0
#include "base/log.h"
#include "web/api.h"
#include "web/http.h"

#include <limits>

#include <httplib.h>

namespace sslv {
namespace {

/// For monitoring: 200 unless there is a problem.
void set_verdict(httplib::Response& response, std::string problem) {
  response.status = problem.empty() ? 200 : 503;
  if (problem.empty()) problem = "ok";
  if (!problem.ends_with('\n')) problem += '\n';
  response.set_content(problem, "text/plain; charset=utf-8");
}

}  // namespace

void get_status(const WebHost& host, const httplib::Request&, httplib::Response& response) {
  set_json(response, host.status());
}

void get_cameras(const WebHost& host, const httplib::Request&, httplib::Response& response) {
  set_json(response, host.status().at("cameras"));
}

void get_alerts(const WebHost& host, const httplib::Request&, httplib::Response& response) {
  set_json(response, {{"alerts", host.status().at("alerts")}});
}

void get_checks(const WebHost& host, const httplib::Request&, httplib::Response& response) {
  const Json status = host.status();
  set_json(response, {{"go", status.at("go")}, {"checks", status.at("checks")}});
}

void get_timeline(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  set_json(response, host.timeline(query_number(request, "seconds", 600, 1, 600)));
}

void get_diagnostics(const WebHost& host, const httplib::Request&, httplib::Response& response) {
  set_json(response, host.diagnostics());
}

void get_metrics(const WebHost& host, const httplib::Request&, httplib::Response& response) {
  response.set_content(host.metrics(), "text/plain; version=0.0.4; charset=utf-8");
}

void get_health(const WebHost& host, const httplib::Request&, httplib::Response& response) {
  set_verdict(response, host.hanging());
}

void get_readiness(const WebHost& host, const httplib::Request&, httplib::Response& response) {
  set_verdict(response, host.missing());
}

void get_log(const WebHost&, const httplib::Request& request, httplib::Response& response) {
  const int after = query_number(request, "after", 0, 0, std::numeric_limits<int>::max());
  const std::string name = request.has_param("level") ? request.get_param_value("level") : "debug";
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
  set_json(response, out);
}

void get_network_interfaces(const WebHost& host, const httplib::Request&, httplib::Response& response) {
  set_json(response, {{"interfaces", host.network_interfaces()}});
}

}  // namespace sslv
