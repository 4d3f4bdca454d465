// SPDX-License-Identifier: Apache-2.0
// Behaviour of GigE cameras that restart, lose packets or send large images, as tables in Markdown. The
// camera is simulated and sends over loopback, on the same processors as the daemon. Takes two minutes;
// arguments select "restarts", "loss" and "five_megapixels".
#include "e2e/frame_numbers.h"
#include "e2e/gige_scene.h"
#include "e2e/running_daemon.h"
#include "support/paths.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>

namespace sslv::test {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// The demo with camera 0 as a GigE camera.
struct Bench {
  Bench(const Json& calibration, int width, int height, double frame_rate_hz) {
    Json& camera = settings["cameras"][0];
    camera["calibration"].update(calibration);
    camera["calibration"].update(Json{{"pixel_image_width", width}, {"pixel_image_height", height}});
    camera["source"].update(Json{{"width", width},
                                 {"height", height},
                                 {"pixel_format", "bayer_rg8"},
                                 {"frame_rate_hz", frame_rate_hz},
                                 {"speed", 0}});
    simulated = settings;
    scene.emplace(camera);
    camera["source"] = {{"backend", "aravis"}, {"camera", "127.0.0.1"}, {"packet_size", 8900}};
  }
  std::unique_ptr<ChildProcess> start_camera() const {
    return start_gige_camera(folder.write("served.json", scene->served.dump()));
  }
  std::unique_ptr<RunningDaemon> start_daemon() const {
    return std::make_unique<RunningDaemon>(folder.write("settings.json", settings.dump()),
                                           folder.path() / "state");
  }

  GroupListener listener;
  TemporaryFolder folder;
  Json settings = demo_settings(listener.port());
  Json simulated;  // the same with the simulator instead of the GigE camera
  std::optional<GigeScene> scene;
};

/// Camera 0 of the demo, scaled.
Bench half_field() {
  return {
      {{"focal_length", 758.15}, {"principal_point_x", 642.0}, {"principal_point_y", 472.8}}, 1280, 952, 30};
}

SSL_DetectionFrame next_frame(GroupListener& listener) {
  for (;;) {
    const SSL_WrapperPacket packet = receive(listener);
    if (packet.has_detection() && packet.detection().camera_id() == 0) return packet.detection();
  }
}

/// Evaluates all frames published in that time.
FrameCheck watch(const Bench& bench, double duration_s, int& frames) {
  GroupListener listener(bench.listener.port());
  FrameCheck out;
  frames = 0;
  const auto start = Clock::now();
  while (seconds_since(start) < duration_s) {
    out += bench.scene->check(next_frame(listener));
    ++frames;
  }
  return out;
}

std::string median_and_worst(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return fmt::format("median {:.2f}, worst {:.2f}", values[values.size() / 2], values.back());
}

/// Statistics of the simulated camera 1 during `happens`, as table cells.
template <class Happens>
std::string other_camera(const Bench& bench, const RunningDaemon& daemon, Happens happens) {
  const auto skipped = [&] { return daemon.get("/api/status")["cameras"][1]["frames_dropped"].get<int>(); };
  const int before = skipped();
  FrameNumbers other(bench.listener.port(), 1);
  happens();
  other.stop();
  return fmt::format("{} | {} | {} | {:.1f}", other.frames(), other.missing(), skipped() - before,
                     other.longest_gap_s() * 1e3);
}

void restarts() {
  constexpr int kCycles = 10;
  const Bench bench = half_field();
  auto camera = bench.start_camera();
  const auto daemon = bench.start_daemon();
  const auto is_well = [](const Json& s) { return s["cameras"][0]["robots"] > 0; };
  std::puts(
      "\n| restart | lost after s | picture after s | other camera: frames | numbers missing | never drawn | "
      "longest gap ms |\n|--:|--:|--:|--:|--:|--:|--:|");
  daemon->wait_for_status(is_well);
  const std::string undisturbed =
      other_camera(bench, *daemon, [] { std::this_thread::sleep_for(std::chrono::seconds(30)); });
  std::printf("| none | | | %s |\n", undisturbed.c_str());
  std::vector<double> losses, returns;
  for (int i = 1; i <= kCycles; ++i) {
    daemon->wait_for_status(is_well);
    const std::string other = other_camera(bench, *daemon, [&] {
      const auto killed = Clock::now();
      camera->send_signal(SIGKILL);
      daemon->wait_for_status([](const Json& s) { return s["cameras"][0]["state"] == "lost"; });
      losses.push_back(seconds_since(killed));
      GroupListener listener(bench.listener.port());
      camera.reset();
      camera = bench.start_camera();
      const auto ready = Clock::now();
      next_frame(listener);
      returns.push_back(seconds_since(ready));
    });
    std::printf("| %d | %.2f | %.2f | %s |\n", i, losses.back(), returns.back(), other.c_str());
    std::fflush(stdout);
  }
  std::printf("\nLost: %s s. Back: %s s.\n", median_and_worst(losses).c_str(),
              median_and_worst(returns).c_str());
}

void loss() {
  constexpr double kSeconds = 20;
  std::puts(
      "\n| 1 % of packets lost | whole pictures | damaged | missing | resent | robots | missed | wrong |\n"
      "|---|--:|--:|--:|--:|--:|--:|--:|");
  for (const bool resend : {true, false}) {
    Bench bench = half_field();
    bench.scene->served["lost_packets"] = 0.01;
    bench.settings["cameras"][0]["source"]["resend"] = resend;
    const auto camera = bench.start_camera();
    const auto daemon = bench.start_daemon();
    daemon->wait_for_status([](const Json& s) { return s["cameras"][0]["frames"] > 0; });
    const Json before = daemon->get("/api/status")["cameras"][0];
    int frames = 0;
    const FrameCheck seen = watch(bench, kSeconds, frames);
    const Json after = daemon->get("/api/status")["cameras"][0];
    const auto more = [&](const char* pointer) {
      const Json::json_pointer at(pointer);
      return after[at].get<int>() - before[at].get<int>();
    };
    std::printf("| resend %s | %d | %d | %d | %d | %d | %d | %d |\n", resend ? "on" : "off", frames,
                more("/frames_incomplete"), more("/packets/missing"), more("/packets/resent"), seen.robots,
                seen.missed, seen.wrong);
  }
}

/// CPU time of each thread so far in s, summed by name.
std::map<std::string, double> thread_times_s(pid_t pid) {
  std::map<std::string, double> out;
  for (const auto& task : std::filesystem::directory_iterator(fmt::format("/proc/{}/task", pid))) {
    std::ifstream file(task.path() / "stat");
    std::string line;
    if (!std::getline(file, line)) continue;  // the thread has ended
    const auto open = line.find('('), close = line.rfind(')');
    std::istringstream rest(line.substr(close + 1));
    std::string skipped;
    for (int field = 3; field < 14; ++field) rest >> skipped;
    double user = 0, system = 0;
    rest >> user >> system;
    out[line.substr(open + 1, close - open - 1)] +=
        (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
  }
  return out;
}

double total_s(const std::map<std::string, double>& times_s) {
  double out = 0;
  for (const auto& [name, time_s] : times_s) out += time_s;
  return out;
}

/// One camera over a whole Division B field.
void five_megapixels() {
  constexpr double kSeconds = 10, kRateHz = 72;
  Bench bench({{"focal_length", 1150.0},
               {"principal_point_x", 1224.0},
               {"principal_point_y", 1024.0},
               {"q0", 1.0},
               {"q1", 0.0},
               {"q2", 0.0},
               {"q3", 0.0},
               {"tx", 0.0},
               {"ty", 0.0},
               {"tz", 5000.0}},
              2448, 2048, kRateHz);
  bench.settings["cameras"].erase(1);
  const std::string recorded = bench.folder.file("frames");
  const Finished drawn =
      run_to_end({lab_program(), "simulate", "--raw", "--frames", "4", "--settings",
                  bench.folder.write("simulated.json", bench.simulated.dump()), "--output", recorded});
  if (drawn.exit_code != 0) throw std::runtime_error(drawn.output);
  bench.scene->served["source"] = {
      {"backend", "files"},      {"path", recorded}, {"loop", true},
      {"width", 2448},           {"height", 2048},   {"pixel_format", "bayer_rg8"},
      {"frame_rate_hz", kRateHz}};
  const auto camera = bench.start_camera();
  const auto daemon = bench.start_daemon();
  daemon->wait_for_status([](const Json& s) { return s["cameras"][0]["frames"] > 100; });

  const Json before = daemon->get("/api/status")["cameras"][0];
  auto times = thread_times_s(daemon->process().pid());
  const double served_before_s = total_s(thread_times_s(camera->pid()));
  const auto start = Clock::now();
  int frames = 0;
  const FrameCheck seen = watch(bench, kSeconds, frames);
  const double duration_s = seconds_since(start);
  const auto times_after = thread_times_s(daemon->process().pid());
  const double served_s = total_s(thread_times_s(camera->pid())) - served_before_s;
  const Json after = daemon->get("/api/status")["cameras"][0];

  const double rate_hz = frames / duration_s;
  std::printf(
      "\n2448x2048 bayer_rg8, packets of 8900 bytes, %g Hz asked for: %.1f pictures a second, %d damaged, "
      "%d robots looked for, %d missed, %d wrong, mean error %.2f mm.\n",
      kRateHz, rate_hz, after["frames_incomplete"].get<int>() - before["frames_incomplete"].get<int>(),
      seen.robots, seen.missed, seen.wrong, seen.error_mm / std::max(1, seen.robots - seen.missed));
  std::puts("\n| thread | % of a core |\n|---|--:|");
  for (const auto& [name, time_s] : times_after) {
    const double share = (time_s - times[name]) / duration_s;
    if (share > 0.001) std::printf("| %s | %.1f |\n", name.c_str(), share * 100);
  }
  std::printf("| (the simulated camera) | %.1f |\n", served_s / duration_s * 100);
  std::puts("\n| stage | p50 us | p99 us | % of a core at this rate | at 72 Hz |\n|---|--:|--:|--:|--:|");
  for (const Json& stage : after["stages"]) {
    const double p50_us = stage["p50_us"];
    std::printf("| %s | %.0f | %.0f | %.1f | %.1f |\n", stage["name"].get<std::string>().c_str(), p50_us,
                stage["p99_us"].get<double>(), p50_us * 1e-4 * rate_hz, p50_us * 1e-4 * kRateHz);
  }
}

void print_machine() {
  std::ifstream info("/proc/cpuinfo");
  std::string line, model = "unknown processor";
  while (std::getline(info, line)) {
    if (line.starts_with("model name")) model = line.substr(line.find(':') + 2);
  }
  double load = 0;
  getloadavg(&load, 1);
  const std::time_t now = std::time(nullptr);
  char date[16];
  std::strftime(date, sizeof date, "%Y-%m-%d", std::gmtime(&now));
  std::printf("%s: %u x %s, load before %.1f\n", date, std::thread::hardware_concurrency(), model.c_str(),
              load);
}

}  // namespace
}  // namespace sslv::test

int main(int argument_count, char** arguments) {
  using namespace sslv::test;
  const std::map<std::string, void (*)()> figures{
      {"restarts", restarts}, {"loss", loss}, {"five_megapixels", five_megapixels}};
  const std::set<std::string> wanted(arguments + 1, arguments + argument_count);
  try {
    print_machine();
    for (const auto& [name, print] : figures) {
      if (wanted.empty() || wanted.contains(name)) print();
      std::fflush(stdout);
    }
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "camera_figures: %s\n", error.what());
    return 1;
  }
}
