// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "ssl_vision_wrapper.pb.h"
#include "support/child_process.h"
#include "support/group_listener.h"
#include "support/patience.h"
#include "support/temporary_folder.h"

#include <filesystem>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace sslv::test {

/// config/demo.json, with the panel on any free port and packets to this test's own multicast group.
Json demo_settings(int multicast_port);

/// Quarters the image size and sets this frame rate, so that a busy computer keeps up.
void make_images_small(Json& settings, double frame_rate_hz);

/// The real program, started as the service manager would.
class RunningDaemon {
 public:
  /// Waits until it is ready. `state`: its state folder; `environment` and `kept` as in ChildProcess.
  RunningDaemon(const std::string& settings_file, const std::filesystem::path& state,
                std::vector<std::string> environment = {}, const std::vector<KeptFile>& kept = {});
  /// Kills it; prints its output if the test has failed.
  ~RunningDaemon();
  RunningDaemon(const RunningDaemon&) = delete;
  RunningDaemon& operator=(const RunningDaemon&) = delete;

  /// The panel API's answer. Throws std::runtime_error unless the HTTP status is `expected`.
  Json get(const std::string& path, int expected = 200) const;
  Json patch(const Json& json_patch, int expected = 200) const;
  /// Patches one value of the settings.
  Json set(const std::string& settings_path, const Json& value, int expected = 200) const;
  Json post(const std::string& path, const Json& body = Json::object(), int expected = 200) const;
  Json remove(const std::string& path, int expected = 200) const;
  /// Polls until `good` accepts the answer; throws std::runtime_error with the last answer after kPatience.
  template <class Good>
  Json wait_for(const std::string& path, Good good) const;
  template <class Good>
  Json wait_for_status(Good good) const {
    return wait_for("/api/status", good);
  }

  std::string address() const { return "http://127.0.0.1:" + port_; }
  ChildProcess& process() { return process_; }

 private:
  [[noreturn]] static void give_up(const Json& answer);
  ChildProcess process_;
  std::string port_;
};

template <class Good>
Json RunningDaemon::wait_for(const std::string& path, Good good) const {
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  for (;;) {
    const Json answer = get(path);
    if (good(answer)) return answer;
    if (std::chrono::steady_clock::now() > deadline) give_up(answer);
    // Leaves the processors to the programs under test.
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

/// A test of the daemon with the demo's settings, which the test may change before starting it.
class DaemonTest : public ::testing::Test {
 protected:
  std::string settings_file() const { return folder_.write("settings.json", settings_.dump(2)); }

  GroupListener listener_;
  TemporaryFolder folder_;
  Json settings_ = demo_settings(listener_.port());
  const std::filesystem::path state_ = folder_.path() / "state";
};

bool has_alert(const Json& status, const std::string& id);
/// The first alert of a kind, and its title; if there is none, both throw std::runtime_error with the other
/// alerts.
const Json& alert_of(const Json& status, const std::string& id);
std::string title_of_alert(const Json& status, const std::string& id);

double unix_now_s();

/// The group's next packet; throws std::runtime_error if none arrives.
SSL_WrapperPacket receive(GroupListener& listener);
/// The next frame sent after that time: a late reader still has older ones queued.
SSL_DetectionFrame receive_frame(GroupListener& listener, double sent_after_s = 0);

}  // namespace sslv::test
