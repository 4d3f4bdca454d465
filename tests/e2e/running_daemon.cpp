// SPDX-License-Identifier: Apache-2.0
#include "e2e/running_daemon.h"

#include "support/paths.h"
#include "support/patience.h"

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <set>
#include <stdexcept>
#include <string>

#include <httplib.h>

namespace sslv::test {
namespace {

/// Whether to retry: on a busy computer a camera sometimes answers too late or is briefly lost.
bool is_only_late(const httplib::Response& answer, int expected) {
  const auto says = [&](const char* text) { return answer.body.find(text) != std::string::npos; };
  return says("the camera has not answered") || (answer.status != expected && says("is not open"));
}

template <class Ask>
Json checked(const Ask& ask, const std::string& asked, int expected) {
  httplib::Result answer = ask();
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (answer && is_only_late(*answer, expected) && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    answer = ask();
  }
  if (!answer) throw std::runtime_error(asked + ": no answer");
  if (answer->status != expected)
    throw std::runtime_error(asked + ": " + std::to_string(answer->status) + " " + answer->body);
  return answer->get_header_value("Content-Type") == "image/jpeg" ? Json(answer->body)
                                                                  : Json::parse(answer->body);
}

httplib::Client client(const std::string& address) {
  httplib::Client out(address);
  out.set_read_timeout(kPatience);
  out.set_write_timeout(kPatience);
  return out;
}

}  // namespace

Json demo_settings(int multicast_port) {
  Json settings = Json::parse(std::ifstream(source_path("/config/demo.json")));
  settings["panel"] = {{"port", 0}};
  settings["network"]["vision"]["group"] = GroupListener::kGroup;
  settings["network"]["vision"]["port"] = multicast_port;
  settings["network"]["referee"]["enabled"] = false;
  return settings;
}

void make_images_small(Json& settings, double frame_rate_hz) {
  for (Json& camera : settings["cameras"]) {
    camera["source"].update(Json{{"width", 390}, {"height", 290}, {"frame_rate_hz", frame_rate_hz}});
    Json& calibration = camera["calibration"];
    for (const char* key : {"focal_length", "principal_point_x", "principal_point_y"})
      calibration[key] = calibration[key].get<double>() / 2;
    calibration.update(Json{{"pixel_image_width", 390}, {"pixel_image_height", 290}});
  }
}

RunningDaemon::RunningDaemon(const std::string& settings_file, const std::filesystem::path& state,
                             std::vector<std::string> environment, const std::vector<KeptFile>& kept)
    : process_({daemon_program(), "--config", settings_file, "--files", source_path("/tests")},
               (environment.push_back("STATE_DIRECTORY=" + state.string()), environment), kept) {
  const std::string line = process_.wait_for_line("panel on port ");
  port_ = line.substr(line.rfind(' ') + 1);
}

RunningDaemon::~RunningDaemon() {
  if (!::testing::Test::HasFailure() && std::uncaught_exceptions() == 0) return;
  try {
    process_.send_signal(SIGKILL);
    process_.wait_for_exit();
  } catch (const std::exception& error) {
    std::printf("%s\n", error.what());
    return;
  }
  std::printf("the daemon printed:\n%s\n", process_.output().c_str());
}

Json RunningDaemon::get(const std::string& path, int expected) const {
  Json answer = checked([&] { return client(address()).Get(path); }, "GET " + path, expected);
  // Ignores alerts that depend on the machine: dropped or late images, and a network card that these tests do
  // not send on. verdict.test.mjs tests robots that are lost with their camera. Warnings about simulated
  // beside real cameras are expected, because these tests combine all kinds.
  if (path == "/api/status") {
    static const std::set<std::string> kElsewhere{
        "ball_lost",         "camera_not_real", "camera_off_time",    "camera_slow", "frames_dropped",
        "frames_incomplete", "latency_high",    "only_this_computer", "robots_lost", "stage_slow"};
    Json others = Json::array();
    for (const Json& alert : answer["alerts"]) {
      if (!kElsewhere.contains(alert["id"].get<std::string>())) others.push_back(alert);
    }
    answer["alerts"] = others;
  }
  return answer;
}

Json RunningDaemon::patch(const Json& json_patch, int expected) const {
  return checked(
      [&] {
        return client(address()).Patch("/api/settings", json_patch.dump(), "application/json-patch+json");
      },
      "PATCH", expected);
}

Json RunningDaemon::set(const std::string& settings_path, const Json& value, int expected) const {
  return patch(Json::array({{{"op", "replace"}, {"path", settings_path}, {"value", value}}}), expected);
}

Json RunningDaemon::post(const std::string& path, const Json& body, int expected) const {
  return checked([&] { return client(address()).Post(path, body.dump(), "application/json"); },
                 "POST " + path, expected);
}

Json RunningDaemon::remove(const std::string& path, int expected) const {
  return checked([&] { return client(address()).Delete(path); }, "DELETE " + path, expected);
}

void RunningDaemon::give_up(const Json& answer) {
  throw std::runtime_error("the daemon does not come to the expected state: " + answer.dump(2));
}

bool has_alert(const Json& status, const std::string& id) {
  return std::ranges::any_of(status["alerts"], [&](const Json& alert) { return alert["id"] == id; });
}

const Json& alert_of(const Json& status, const std::string& id) {
  for (const Json& alert : status["alerts"]) {
    if (alert["id"] == id) return alert;
  }
  throw std::runtime_error("no alert " + id + ": " + status["alerts"].dump());
}

std::string title_of_alert(const Json& status, const std::string& id) {
  return alert_of(status, id)["title"];
}

double unix_now_s() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

SSL_DetectionFrame receive_frame(GroupListener& listener, double sent_after_s) {
  for (;;) {
    const SSL_WrapperPacket packet = receive(listener);
    if (packet.has_detection() && packet.detection().t_sent() > sent_after_s) return packet.detection();
  }
}

SSL_WrapperPacket receive(GroupListener& listener) {
  const auto bytes = listener.receive();
  if (!bytes) throw std::runtime_error("no packet came");
  SSL_WrapperPacket packet;
  if (!packet.ParseFromString(*bytes)) throw std::runtime_error("a packet that cannot be parsed");
  return packet;
}

}  // namespace sslv::test
