// SPDX-License-Identifier: Apache-2.0
#include "ctl/client.h"

#include <fmt/format.h>
#include <httplib.h>

namespace sslv {

namespace {

/// The body of an answer. Throws ClientError.
std::string body_of(const httplib::Result& response, const std::string& address, const std::string& path) {
  if (!response) {
    throw ClientError(fmt::format("no daemon answers at {} ({}); is it running, and is --daemon right?",
                                  address, httplib::to_string(response.error())));
  }
  if (response->status != 200 && response->status != 202) {
    const Json error = Json::parse(response->body, nullptr, false);
    const bool explained = error.is_object() && error.contains("error") && error["error"].is_string();
    throw ClientError(explained ? error["error"].get<std::string>()
                                : fmt::format("{}: HTTP status {}", path, response->status));
  }
  return response->body;
}

httplib::Client client_of(const std::string& address) {
  httplib::Client http(address);
  if (!http.is_valid())
    throw ClientError(fmt::format("\"{}\" is no address; expected http://HOST:PORT", address));
  http.set_connection_timeout(2);
  http.set_read_timeout(5);
  return http;
}

}  // namespace

std::string Client::get(const std::string& path) const {
  return body_of(client_of(address_).Get(path), address_, path);
}

Json Client::post(const std::string& path, const Json& body) const {
  return Json::parse(
      body_of(client_of(address_).Post(path, body.dump(), "application/json"), address_, path));
}

Json Client::patch(const std::string& path, const Json& body) const {
  return Json::parse(
      body_of(client_of(address_).Patch(path, body.dump(), "application/json"), address_, path));
}

std::string status_text(const Json& status) {
  const Json& network = status.at("network");
  std::string out = fmt::format("{}  ({}, up {:.0f} s)\n", status.at("site").get<std::string>(),
                                status.at("version").get<std::string>(), status.at("uptime_s").get<double>());
  out +=
      fmt::format("-> {}:{}{}  {:.0f} packets/s, {} errors\n", network.at("group").get<std::string>(),
                  network.at("port").get<int>(),
                  network.at("interface") == "" ? "" : " on " + network.at("interface").get<std::string>(),
                  network.at("packets_per_s").get<double>(), network.at("send_errors").get<std::uint64_t>());
  out += fmt::format("{:>6}  {:<14} {:<8} {:>10} {:>6} {:>8} {:>8} {:>9} {:>7} {:>6}\n", "camera", "name",
                     "state", "picture", "fps", "p50 ms", "p99 ms", "frames", "robots", "balls");
  for (const Json& camera : status.at("cameras")) {
    out +=
        fmt::format("{:>6}  {:<14} {:<8} {:>10} {:>6.1f} {:>8.2f} {:>8.2f} {:>9} {:>7} {:>6}\n",
                    camera.at("id").get<int>(), camera.at("name").get<std::string>(),
                    camera.at("state").get<std::string>(),
                    fmt::format("{}x{}", camera.at("width").get<int>(), camera.at("height").get<int>()),
                    camera.at("fps").get<double>(), camera.at("latency_ms").at("p50").get<double>(),
                    camera.at("latency_ms").at("p99").get<double>(), camera.at("frames").get<std::uint64_t>(),
                    camera.at("robots").get<int>(), camera.at("balls").get<int>());
  }
  for (const Json& alert : status.at("alerts")) {
    out += fmt::format("{}: {}. {}\n", alert.at("severity").get<std::string>(),
                       alert.at("title").get<std::string>(), alert.at("fix").get<std::string>());
  }
  return out;
}

}  // namespace sslv
