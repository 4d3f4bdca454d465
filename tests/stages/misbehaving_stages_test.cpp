// SPDX-License-Identifier: Apache-2.0
// Alerts about stages that hang, are slow, output invalid values, or have notes: read over HTTP from a whole
// daemon with one simulated camera.
#include "base/json.h"
#include "config/stages.h"
#include "daemon.h"
#include "kit/read_stamp.h"
#include "net/multicast_receiver.h"
#include "ssl_vision_wrapper.pb.h"
#include "ssl_vision_wrapper_tracked.pb.h"
#include "support/becomes.h"
#include "support/patience.h"
#include "support/temporary_folder.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <httplib.h>
#include <unistd.h>

namespace sslv {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

struct NoParams {
  static constexpr auto fields() { return std::tuple{}; }
};

/// Stages wait here while the gate is shut.
class Gate {
 public:
  void shut() { is_shut_.store(true); }
  void open() {
    is_shut_.store(false);
    is_shut_.notify_all();
  }
  void pass() const { is_shut_.wait(true); }

 private:
  std::atomic<bool> is_shut_{false};
};
Gate camera_gate, field_gate;

struct HangCamera {
  using Params = NoParams;
  void process(const Params&, const Image&) noexcept { camera_gate.pass(); }
};
struct HangField {
  using Params = NoParams;
  void process(const Params&, const CameraSightings&) noexcept { field_gate.pass(); }
};

/// Takes a given time.
struct BeSlow {
  struct Params {
    double ms = 0;
    static constexpr auto fields() {
      return std::tuple{number("ms", &Params::ms, 0.0, 10'000.0, "ms", "how long")};
    }
  };
  void process(const Params& params, const Image&) noexcept { wait(params); }
  static void wait(const Params& params) {
    std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(params.ms));
  }
};
struct BeSlowOnField {
  using Params = BeSlow::Params;
  void process(const Params& params, const CameraSightings&) noexcept { BeSlow::wait(params); }
};

/// Adds a robot and a ball with non-finite positions to the detected ones.
struct AddNowhere {
  using Params = NoParams;
  void process(const Params&, Update<RobotList> robots, Update<BallList> balls) noexcept {
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    robots->robots.push_back({Team::kBlue, 3, kNan, 0, 0, 140, 10, 10, 0.9});
    balls->balls.push_back({std::numeric_limits<double>::infinity(), 0, 10, 10, 30, 0.9});
  }
};
struct TrackNowhere {
  using Params = NoParams;
  void process(const Params&, Update<TrackedField> tracked) noexcept {
    tracked->robots.emplace_back().place_mm.x() = std::numeric_limits<double>::quiet_NaN();
  }
};

/// Reports its parameter as a note, or as a warning if the text ends with "!". Appends an incomplete UTF-8
/// character.
struct Say {
  struct Params {
    std::string text;
    static constexpr auto fields() { return std::tuple{sslv::text("text", &Params::text, "what it says")}; }
  };
  void process(const Params& params, const Image&, StageNotes& notes) noexcept {
    params.text.ends_with('!') ? notes.warn(params.text + "\xc3") : notes.say(params.text + "\xc3");
  }
};

template <class Type>
Type from_library(Type type) {
  type.library = "/usr/lib/ssl-visiond/stages/april_tags.so";
  return type;
}

class StageTable : public testing::Environment {
 public:
  void SetUp() override {
    EXPECT_THROW(add_stages({{stage<BeSlow>("publish", "")}, {}}), StageLibraryError);
    EXPECT_THROW(add_stages({{stage<BeSlow>("twice", ""), stage<BeSlow>("twice", "")}, {}}),
                 StageLibraryError);
    EXPECT_THROW(add_stages({{stage<BeSlow>("new", "")}, {field_stage<HangField>("track", "")}}),
                 StageLibraryError);
    add_stages({{stage<HangCamera>("hang", ""), stage<BeSlow>("be_slow", ""),
                 from_library(stage<AddNowhere>("add_nowhere", "")), from_library(stage<Say>("say", ""))},
                {field_stage<HangField>("hang", ""), from_library(field_stage<BeSlowOnField>("be_slow", "")),
                 field_stage<TrackNowhere>("track_nowhere", "")}});
    EXPECT_EQ(stage_table().back().name, "say");
    EXPECT_EQ(field_stage_table().back().name, "track_nowhere");
    EXPECT_THROW(add_stages({{stage<BeSlow>("late", "")}, {}}), std::logic_error);
  }
};

class MisbehavingStages : public testing::Test {
 protected:
  void start(const Json& camera, const Json& field = Json::object()) {
    Json settings{
        {"site", "test"},
        {"network",
         {{"vision", {{"group", "239.255.77.79"}, {"port", port_}, {"interface", "127.0.0.1"}}},
          {"referee", {{"enabled", false}}},
          {"tracker", {{"enabled", true}, {"group", "239.255.77.79"}, {"port", port_ + 1}}}}},
        {"panel", {{"port", 0}}},
        {"field", field},
        {"cameras",
         {{{"id", 4},
           {"source", {{"backend", "simulator"}, {"width", 320}, {"height", 240}, {"frame_rate_hz", 50}}},
           {"calibration",
            {{"focal_length", 190},
             {"principal_point_x", 160},
             {"principal_point_y", 120},
             {"distortion", 0.08},
             {"q0", 0.7071},
             {"q1", -0.7071},
             {"q2", 0},
             {"q3", 0},
             {"tx", 0},
             {"ty", 0},
             {"tz", 4000},
             {"pixel_image_width", 320},
             {"pixel_image_height", 240}}}}}}};
    settings["cameras"][0].update(camera);
    std::ofstream(folder_.path() / "settings.json") << settings;
    daemon_.emplace(
        Daemon::Options{folder_.path() / "settings.json", folder_.path() / "state", "/var/empty"});
  }
  ~MisbehavingStages() override {
    camera_gate.open();
    field_gate.open();
  }

  std::string ask(const std::string& path) {
    httplib::Client client("127.0.0.1", daemon_->panel_port());
    client.set_read_timeout(test::kPatience);
    const auto result = client.Get(path);
    if (!result) throw std::runtime_error(path + ": no answer");
    return result->body;
  }
  Json status() { return Json::parse(ask("/api/status")); }

  /// Waits for a status with an alert of this kind whose title begins with `title`.
  Json wait_for_alert(const std::string& id, const std::string& title = "") {
    for (;;) {
      Json now = status();
      const auto alert = alert_of(now, id);
      if (alert && alert->at("title").get<std::string>().starts_with(title)) return now;
      pause();
    }
  }
  static void pause() { std::this_thread::sleep_for(std::chrono::milliseconds(50)); }
  static std::optional<Json> alert_of(const Json& status, const std::string& id) {
    for (const Json& alert : status.at("alerts")) {
      if (alert.at("id") == id) return alert;
    }
    return std::nullopt;
  }
  static Json stage_of(const Json& stages, const std::string& name) {
    for (const Json& stage : stages) {
      if (stage.at("name") == name) return stage;
    }
    return nullptr;
  }

  const int port_ = 30000 + getpid() % 30000;
  const test::TemporaryFolder folder_;
  std::optional<Daemon> daemon_;
};

/// Counts a group's packets and the robots and balls in them with non-finite positions.
template <class Packet, class Count>
class Heard {
 public:
  Heard(int port, Count count) : count_(count) {
    receiver_.listen(GroupAddress{"239.255.77.79", port, "127.0.0.1"});
  }
  void wait_for(int packets) const {
    while (packets_.load() < packets) std::this_thread::yield();
  }
  int nowhere() const { return nowhere_.load(); }

 private:
  const Count count_;
  std::atomic<int> packets_{0}, nowhere_{0};
  MulticastReceiver receiver_{"test", [this](std::span<const std::byte> bytes, const auto&) {
                                Packet packet;
                                if (!packet.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())))
                                  return;
                                nowhere_ += count_(packet);
                                ++packets_;
                              }};
};

int nowhere_in(const SSL_WrapperPacket& packet) {
  int count = 0;
  for (const auto* robots : {&packet.detection().robots_yellow(), &packet.detection().robots_blue()}) {
    for (const auto& robot : *robots) count += !std::isfinite(robot.x());
  }
  for (const auto& ball : packet.detection().balls()) count += !std::isfinite(ball.x());
  return count;
}

int tracks_nowhere_in(const TrackerWrapperPacket& packet) {
  int count = 0;
  for (const auto& robot : packet.tracked_frame().robots()) count += !std::isfinite(robot.pos().x());
  return count;
}

Json stack_with(const std::string& name) {
  return {"segment", "detect_robots", "detect_balls", name, "publish"};
}

TEST_F(MisbehavingStages, AHangingStageIsReportedWithItsDuration) {
  start({{"stack", stack_with("hang")}});
  EXPECT_EQ(daemon_->hanging(), "");
  EXPECT_EQ(status()["cameras"][0]["hangs"], nullptr);
  camera_gate.shut();
  const Json now = wait_for_alert("camera_hangs");
  const Json alert = *alert_of(now, "camera_hangs");
  EXPECT_THAT(alert.at("title").get<std::string>(), StartsWith("Camera 4 has hung for "));
  EXPECT_THAT(alert.at("title").get<std::string>(), HasSubstr(" s in the stage 'hang'"));
  EXPECT_EQ(alert.at("severity"), "bad");
  EXPECT_EQ(alert.at("camera"), 4);
  const Json hangs = now["cameras"][0]["hangs"];
  EXPECT_EQ(hangs["stage"], "hang");
  EXPECT_EQ(hangs["library"], "");
  EXPECT_GE(now["time"].get<double>() - hangs["since"].get<double>(), 4);
  // The reason for the missed watchdog messages, which is also logged.
  EXPECT_THAT(daemon_->hanging(), StartsWith("camera 4 has hung for "));
  EXPECT_THAT(daemon_->hanging(), HasSubstr(" s in the stage 'hang'"));
  EXPECT_THAT(ask("/healthz"), HasSubstr("in the stage 'hang'"));
  camera_gate.open();
  while (!daemon_->hanging().empty()) std::this_thread::yield();
}

TEST_F(MisbehavingStages, AHangInARemovedCameraIsReportedAndBlocksNobody) {
  start({{"stack", stack_with("hang")}});
  camera_gate.shut();
  wait_for_alert("camera_hangs");
  httplib::Client client("127.0.0.1", daemon_->panel_port());
  client.set_read_timeout(test::kPatience);
  const auto removed =
      client.Patch("/api/settings", R"([{"op": "remove", "path": "/cameras/0"}])", "application/json");
  ASSERT_TRUE(removed);
  ASSERT_EQ(removed->status, 200) << removed->body;
  EXPECT_THAT(daemon_->hanging(), StartsWith("camera 4 has hung for ")) << "the watchdog must not be fed";
  // The heartbeat continues.
  const auto newest_s = [this] {
    return Json::parse(ask("/api/timeline?seconds=1"))["time_s"].back().get<double>();
  };
  const double before_s = newest_s();
  EXPECT_TRUE(test::becomes([&] { return newest_s() > before_s + 2; }));
  EXPECT_THAT(daemon_->hanging(), HasSubstr(" s in the stage 'hang'"));
  camera_gate.open();
  EXPECT_TRUE(test::becomes([&] { return daemon_->hanging().empty(); }));
}

TEST_F(MisbehavingStages, AHangingFieldStageDoesNotStopTheService) {
  start(Json::object(), {{"stack", {"gather", "hang", "clocks", "agreement", "track", "publish"}}});
  field_gate.shut();
  const Json now = wait_for_alert("field_hangs");
  EXPECT_THAT(alert_of(now, "field_hangs")->at("title").get<std::string>(), HasSubstr("in the stage 'hang'"));
  EXPECT_EQ(now["tracks"]["hangs"]["stage"], "hang");
  EXPECT_EQ(daemon_->hanging(), "") << "detections are still sent";
  while (ask("/api/log?level=error").find("in the stage 'hang'") == std::string::npos)
    std::this_thread::yield();
  field_gate.open();
  while (!status()["tracks"]["hangs"].is_null()) std::this_thread::yield();
}

TEST_F(MisbehavingStages, ASlowStageIsBlamedInsteadOfTheComputer) {
  // Much slower than anything else, even on a busy computer.
  start({{"stack", stack_with("be_slow")}, {"stages", {{"be_slow", {{"ms", 1000}}}}}});
  // Until rates are measured well, the title may contain the duration for one image instead.
  const Json now = wait_for_alert("stage_slow", "Camera 4: the stage 'be_slow' takes ");
  const std::string title = alert_of(now, "stage_slow")->at("title");
  EXPECT_THAT(title, HasSubstr(" ms an image; images arrive every "));
  EXPECT_FALSE(alert_of(now, "camera_slow")) << title;
  const auto fix = [this] {
    return alert_of(wait_for_alert("frames_dropped"), "frames_dropped")->at("fix").get<std::string>();
  };
  while (!fix().starts_with("The stage 'be_slow' takes ")) pause();
}

TEST_F(MisbehavingStages, ASlowFieldStageIsNamed) {
  start(Json::object(), {{"stack", {"gather", "be_slow", "clocks", "agreement", "track", "publish"}},
                         {"stages", {{"be_slow", {{"ms", 500}}}}}});
  const Json now = wait_for_alert("stage_slow", "Field: the stage 'be_slow' (april_tags.so) takes ");
  const Json alert = *alert_of(now, "stage_slow");
  EXPECT_EQ(alert.at("camera"), nullptr);
  EXPECT_EQ(stage_of(now["tracks"]["stages"], "be_slow")["library"], "april_tags.so");
}

TEST_F(MisbehavingStages, InvalidOutputIsDroppedAndItsStageNamed) {
  start({{"stack", stack_with("add_nowhere")}},
        {{"stack", {"gather", "clocks", "agreement", "track", "track_nowhere", "publish"}}});
  const Heard<SSL_WrapperPacket, decltype(&nowhere_in)> detections(port_, &nowhere_in);
  const Heard<TrackerWrapperPacket, decltype(&tracks_nowhere_in)> tracks(port_ + 1, &tracks_nowhere_in);
  detections.wait_for(20);
  tracks.wait_for(20);
  EXPECT_EQ(detections.nowhere(), 0);
  EXPECT_EQ(tracks.nowhere(), 0);
  const Json now = wait_for_alert("stage_senseless");
  std::vector<std::string> titles;
  Json both = now;
  while (titles.size() < 2) {
    titles.clear();
    for (const Json& alert : both.at("alerts")) {
      if (alert.at("id") == "stage_senseless") titles.push_back(alert.at("title"));
    }
    both = status();
  }
  EXPECT_THAT(titles, testing::Contains(testing::ContainsRegex(
                          "^Camera 4: the stage 'add_nowhere' \\(april_tags.so\\) gave invalid results: "
                          "[0-9]+ robots?, [0-9]+ balls? dropped in the last 10 s$")));
  EXPECT_THAT(titles, testing::Contains(testing::ContainsRegex(
                          "^Field: the stage 'track_nowhere' gave invalid results: [0-9]+ robots? dropped")));
  const std::string metrics = ask("/metrics");
  EXPECT_THAT(metrics, HasSubstr("sslv_senseless_total{camera=\"4\",stage=\"add_nowhere\",what=\"robot\"}"));
  EXPECT_THAT(metrics,
              HasSubstr("sslv_senseless_total{camera=\"4\",stage=\"detect_robots\",what=\"robot\"} 0\n"));
  EXPECT_THAT(metrics, HasSubstr("sslv_field_senseless_total{stage=\"track_nowhere\",what=\"robot\"}"));
  const Json field = Json::parse(ask("/api/field"));
  for (const Json& robot : field.at("robots")) EXPECT_TRUE(robot.at("x").is_number()) << robot;
}

TEST_F(MisbehavingStages, NotesAreShown) {
  start({{"stack", stack_with("say")}, {"stages", {{"say", {{"text", "12 tags are known"}}}}}});
  Json said;
  while ((said = stage_of(status()["cameras"][0]["stages"], "say")["note"]).is_null())
    std::this_thread::yield();
  EXPECT_EQ(said["kind"], "note");
  EXPECT_EQ(said["text"], "12 tags are known\\xc3");
  EXPECT_EQ(stage_of(status()["cameras"][0]["stages"], "say")["library"], "april_tags.so");
  EXPECT_EQ(stage_of(status()["cameras"][0]["stages"], "segment")["note"], nullptr);
  EXPECT_FALSE(alert_of(status(), "stage_warns"));
}

TEST_F(MisbehavingStages, AWarningIsAnAlert) {
  start({{"stack", stack_with("say")}, {"stages", {{"say", {{"text", "no tag is seen!"}}}}}});
  const Json now = wait_for_alert("stage_warns");
  EXPECT_EQ(alert_of(now, "stage_warns")->at("title"),
            "Camera 4: the stage 'say' (april_tags.so) warns: no tag is seen!\\xc3");
  EXPECT_EQ(alert_of(now, "stage_warns")->at("camera"), 4);
  EXPECT_EQ(stage_of(now["cameras"][0]["stages"], "say")["note"]["kind"], "warning");
}

}  // namespace
}  // namespace sslv

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  testing::AddGlobalTestEnvironment(new sslv::StageTable);
  return RUN_ALL_TESTS();
}
