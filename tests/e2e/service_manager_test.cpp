// SPDX-License-Identifier: Apache-2.0
// Messages to the service manager, and conditions under which it restarts the service.
#include "support/service_manager.h"

#include "clips/clip_writer.h"
#include "e2e/running_daemon.h"
#include "support/paths.h"

#include <algorithm>
#include <atomic>
#include <csignal>
#include <fstream>
#include <iterator>
#include <set>
#include <stop_token>
#include <thread>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <poll.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

namespace sslv::test::service_manager_test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

class Notifies : public DaemonTest {
 protected:
  Notifies() { make_images_small(settings_, 30); }
  std::vector<std::string> words() const { return {daemon_program(), "--config", settings_file()}; }
  std::vector<std::string> environment() const {
    return {"STATE_DIRECTORY=" + state_.string(), manager_.variable()};
  }

  ServiceManager manager_{folder_.path() / "notify"};
};

TEST_F(Notifies, ReadyAliveReloadingAndStopping) {
  ChildProcess daemon(words(), environment());
  manager_.wait_for("READY=1");
  manager_.wait_for("WATCHDOG=1");
  EXPECT_THAT(manager_.wait_for("STATUS="), HasSubstr("cameras"));
  daemon.send_signal(SIGHUP);
  EXPECT_THAT(manager_.wait_for("RELOADING=1"), StartsWith("RELOADING=1\nMONOTONIC_USEC="));
  manager_.wait_for("READY=1");
  manager_.wait_for("WATCHDOG=1");
  daemon.send_signal(SIGTERM);
  manager_.wait_for("STOPPING=1");
  EXPECT_EQ(daemon.wait_for_exit(), 0);
}

TEST_F(Notifies, EndsARefusedReload) {
  ChildProcess daemon(words(), environment());
  manager_.wait_for("READY=1");
  std::ofstream(folder_.file("settings.json")) << "{";
  daemon.send_signal(SIGHUP);
  manager_.wait_for("RELOADING=1");
  manager_.wait_for("READY=1");
  manager_.wait_for("WATCHDOG=1");
  daemon.send_signal(SIGTERM);
  EXPECT_EQ(daemon.wait_for_exit(), 0);
}

TEST_F(Notifies, IsAliveWhileAReloadWaitsForAStage) {
  const std::string starts = folder_.file("starts");
  std::vector<std::string> environment = this->environment(), words = this->words();
  environment.push_back("SSLV_STARTS_WITH=" + starts);
  words.insert(words.end(), {"--stages-apart", SSLV_KIT_LIBRARIES "/starts_late"});
  ChildProcess daemon(words, environment);
  manager_.wait_for("READY=1");
  settings_["cameras"][0]["stack"] = {"segment", "detect_robots", "detect_balls", "starts_late", "publish"};
  settings_file();  // written again
  daemon.send_signal(SIGHUP);
  manager_.wait_for("RELOADING=1");
  for (int alive = 0; alive < 2;) {
    const std::string message = manager_.wait_for("");
    ASSERT_THAT(message, ::testing::Not(StartsWith("READY"))) << "the stage is not there yet";
    alive += message.starts_with("WATCHDOG=1");
  }
  std::ofstream(starts) << "now";
  manager_.wait_for("READY=1");
  daemon.send_signal(SIGTERM);
  EXPECT_EQ(daemon.wait_for_exit(), 0);
}

/// A camera whose driver stops answering: a video read from a pipe that gets no more data.
class StuckFilm {
 public:
  explicit StuckFilm(const std::string& path) {
    if (::mkfifo(path.c_str(), 0600) != 0) throw std::runtime_error("no pipe " + path);
    std::ifstream in(source_path("/tests/golden/division_b.jpg"), std::ios::binary);
    picture_ = {std::istreambuf_iterator<char>(in), {}};
    pipe_ = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);  // does not wait for a reader
    writer_ = std::jthread([this](const std::stop_token& stop) {
      // Writes enough to detect the video's format and to deliver some frames, then nothing.
      for (int i = 0; i < kPictures; ++i) {
        for (std::size_t sent = 0; sent < picture_.size() && !stop.stop_requested();) {
          pollfd ready{pipe_, POLLOUT, 0};
          ::poll(&ready, 1, 100);
          const ssize_t n = ::write(pipe_, picture_.data() + sent, picture_.size() - sent);
          if (n > 0) sent += static_cast<std::size_t>(n);
        }
      }
      is_written_ = true;
    });
  }
  ~StuckFilm() {
    writer_.request_stop();
    writer_.join();
    ::close(pipe_);
  }
  StuckFilm(const StuckFilm&) = delete;
  StuckFilm& operator=(const StuckFilm&) = delete;

  /// Everything has been written.
  bool is_written() const { return is_written_; }

 private:
  static constexpr int kPictures = 200;
  std::string picture_;
  int pipe_ = -1;
  std::atomic<bool> is_written_{false};
  std::jthread writer_;
};

TEST_F(Notifies, AHangingCameraThreadStopsTheWatchdogUntilARestart) {
  const std::string film = folder_.file("film.mjpeg");
  settings_["cameras"][1]["source"] = {{"backend", "files"}, {"path", film}, {"frame_rate_hz", 100}};
  {
    StuckFilm stuck(film);
    ChildProcess daemon(words(), environment());
    manager_.wait_for("READY=1");
    manager_.wait_for("WATCHDOG=1");
    while (!stuck.is_written()) manager_.wait_for("");
    EXPECT_THAT(manager_.wait_for("STATUS=camera 1 has hung for "), HasSubstr(" s"));
    // Watchdog messages stop although everything else continues: the case for WatchdogSec.
    for (int statuses = 0; statuses < 3;) {
      const std::string message = manager_.wait_for("");
      EXPECT_THAT(message, ::testing::Not(StartsWith("WATCHDOG")));
      statuses += message.starts_with("STATUS=camera 1 has hung");
    }
    const double hung_s = unix_now_s();
    while (receive_frame(listener_, hung_s).camera_id() != 0) {  // camera 0 still sends
    }
    // Like the service manager, which then restarts it.
    daemon.send_signal(SIGABRT);
    EXPECT_EQ(daemon.wait_for_exit(), 128 + SIGABRT);
  }
  std::filesystem::remove(film);
  ChildProcess again(words(), environment());
  manager_.wait_for("READY=1");
  manager_.wait_for("WATCHDOG=1");
  again.send_signal(SIGTERM);
  EXPECT_EQ(again.wait_for_exit(), 0);
}

class HungDisk : public Notifies {
 protected:
  std::vector<std::string> environment() const {
    // By name, as LD_PRELOAD accepts no path with a space.
    const std::filesystem::path library = hung_disk_library();
    std::vector<std::string> out = Notifies::environment();
    out.insert(out.end(),
               {"LD_PRELOAD=" + library.filename().string(),
                "LD_LIBRARY_PATH=" + library.parent_path().string(), "SSLV_HUNG_FOLDER=" + state_.string(),
                "SSLV_HUNG_WHILE=" + hung_, "ASAN_OPTIONS=verify_asan_link_order=0"});
    return out;
  }
  void hang() {
    std::ofstream(hung_) << "now";
    while (!std::filesystem::exists(hung_ + ".reached")) manager_.wait_for("");  // until it is accessed
    manager_.hear_the_rest();
  }

  const std::string hung_ = folder_.file("hung");
};

TEST_F(HungDisk, LetsTheServiceEndBeforeItsManagerAbortsIt) {
  ChildProcess daemon(words(), environment());
  manager_.wait_for("READY=1");
  hang();
  daemon.send_signal(SIGTERM);
  EXPECT_EQ(daemon.wait_for_exit(), 0);
}

TEST_F(HungDisk, DoesNotEndTheService) {
  ChildProcess daemon(words(), environment());
  manager_.wait_for("READY=1");
  hang();
  const double hung_s = unix_now_s();
  for (int i = 0; i < 4; ++i) manager_.wait_for("WATCHDOG=1");
  std::set<unsigned> sending;
  while (sending.size() < 2) sending.insert(receive_frame(listener_, hung_s).camera_id());
  std::filesystem::remove(hung_);
  daemon.send_signal(SIGTERM);
  EXPECT_EQ(daemon.wait_for_exit(), 0);
}

TEST_F(Notifies, AStoppedProcessSendsNoWatchdog) {
  ChildProcess daemon(words(), environment());
  manager_.wait_for("WATCHDOG=1");
  daemon.send_signal(SIGSTOP);
  siginfo_t stopped{};
  ASSERT_EQ(::waitid(P_PID, static_cast<id_t>(daemon.pid()), &stopped, WSTOPPED | WNOWAIT), 0);
  manager_.hear_the_rest();
  EXPECT_FALSE(manager_.next(std::chrono::milliseconds(2500))) << "it is told every second otherwise";
  daemon.send_signal(SIGCONT);
  manager_.wait_for("WATCHDOG=1");
  daemon.send_signal(SIGTERM);
  EXPECT_EQ(daemon.wait_for_exit(), 0);
}

class Crashes : public Notifies {
 protected:
  Crashes() { settings_["recording"]["last_seconds"] = {{"memory_mb", 200}}; }

  RunningDaemon start() {
    return RunningDaemon(settings_file(), state_, {manager_.variable()}, manager_.kept());
  }
  /// Waits until the rings of both cameras are held by the manager and contain enough for a hundred images
  /// each.
  void wait_until_kept(const RunningDaemon& daemon) {
    daemon.wait_for_status([this](const Json& status) {
      manager_.hear_the_rest();
      return std::ranges::all_of(status["cameras"], [](const Json& one) { return one["frames"] > 40; });
    });
    daemon.wait_for("/api/recordings/clips", [this](const Json& answer) {
      manager_.hear_the_rest();
      const Json& cameras = answer["last_seconds"]["cameras"];
      return manager_.kept().size() == 2 && cameras.size() == 2 &&
             std::ranges::all_of(cameras, [](const Json& one) { return one["seconds"] > 1; });
    });
  }
  void crash(RunningDaemon& daemon, int signal) {
    daemon.process().send_signal(signal);
    daemon.process().wait_for_exit();
    manager_.hear_the_rest();
  }
  /// The crash clips, once the service has processed the rings of a crashed process.
  static Json crash_clips(const RunningDaemon& daemon) {
    const auto all = daemon.wait_for("/api/recordings/clips", [](const Json& answer) {
      return answer["clip"]["state"] != "writing" &&
             std::ranges::none_of(answer["clips"], [](const Json& one) {
               return one["begin_s"].is_null() && one["problem"] == "";
             });
    });
    Json out = Json::array();
    for (const Json& clip : all["clips"]) {
      if (clip["name"].get<std::string>().ends_with("_crash.clip")) out.push_back(clip);
    }
    return out;
  }
};

TEST_F(Crashes, LeaveAClipOfWhatTheCamerasSaw) {
  {
    RunningDaemon first = start();
    wait_until_kept(first);
    // Part of the clip has other settings.
    first.set("/cameras/1/colors/bits", 6);
    const double changed_s = unix_now_s();
    for (int i = 0; i < 60; ++i) receive_frame(listener_, changed_s);
    EXPECT_EQ(crash_clips(first), Json::array());
    crash(first, SIGSEGV);
    ASSERT_EQ(manager_.kept().size(), 2U);
  }
  // Clips of earlier crashes, one dated in the future by a wrong clock.
  const std::filesystem::path recordings = state_ / "recordings";
  for (const int days : {1, -1, -2, -3}) {
    const auto clip = recordings / ("2000-01-0" + std::to_string(4 + days) + "_00-00_crash.clip");
    std::filesystem::create_directories(recordings);
    ClipWriter(clip, {.kind = std::string(kCrashClip)}).finish();
    std::filesystem::last_write_time(
        clip, std::filesystem::file_time_type::clock::now() + std::chrono::hours(24 * days));
  }
  {
    RunningDaemon second = start();
    EXPECT_EQ(crash_clips(second).size(), 3U) << "many crashes do not fill the disk";
    for (const auto& entry : std::filesystem::directory_iterator(recordings)) {
      if (entry.path().filename().string().starts_with("2000")) std::filesystem::remove(entry.path());
    }
    const Json clips = second.wait_for(
        "/api/recordings/clips", [](const Json& answer) { return answer["clips"].size() == 1; })["clips"];
    EXPECT_EQ(clips[0]["why"], "the service crashed");
    EXPECT_GT(clips[0]["seconds"], 1);
    ASSERT_EQ(clips[0]["cameras"].size(), 2U);
    for (const Json& camera : clips[0]["cameras"]) {
      EXPECT_GT(camera["frames"], 20) << camera;
      EXPECT_EQ(camera["missing"], 0) << camera;
    }
    const std::string name = clips[0]["name"];
    const Json status = second.wait_for_status([](const Json& answer) {
      return std::ranges::any_of(answer["alerts"],
                                 [](const Json& alert) { return alert["id"] == "service_crashed"; });
    });
    EXPECT_EQ(title_of_alert(status, "service_crashed"),
              "The service crashed and was restarted; clip " + name + " shows what the cameras saw before");
    const Finished compared =
        run_to_end({ctl_program(), "replay", (state_ / "recordings" / name).string(), "--compare"});
    EXPECT_EQ(compared.exit_code, 0) << compared.output;

    // Repeated crashes must not fill the disk.
    wait_until_kept(second);
    crash(second, SIGKILL);
    // Dates the first clip now, so that the second crash counts as soon after it, however long this took.
    std::filesystem::last_write_time(recordings / name, std::filesystem::file_time_type::clock::now());
  }
  RunningDaemon third = start();
  EXPECT_EQ(crash_clips(third).size(), 1U);
  wait_until_kept(third);
  EXPECT_THAT(title_of_alert(third.get("/api/status"), "service_crashed"),
              HasSubstr("less than a minute ago"));
  third.process().send_signal(SIGTERM);
  EXPECT_EQ(third.process().wait_for_exit(), 0);
  manager_.hear_the_rest();
  EXPECT_EQ(manager_.kept().size(), 0U) << "a stop is no crash";
}

TEST_F(Crashes, LeaveNoClipWhereNoneIsWanted) {
  settings_["recording"]["clips"] = {{"on_crash", false}};
  {
    RunningDaemon first = start();
    wait_until_kept(first);
    crash(first, SIGKILL);
  }
  RunningDaemon second = start();
  EXPECT_EQ(crash_clips(second), Json::array());
  wait_until_kept(second);  // the first run's rings have been discarded
  EXPECT_EQ(title_of_alert(second.get("/api/status"), "service_crashed"),
            "The service crashed and was restarted");
}

}  // namespace
}  // namespace sslv::test::service_manager_test
