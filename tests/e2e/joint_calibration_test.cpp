// SPDX-License-Identifier: Apache-2.0
// The real daemon calibrates its two simulated cameras jointly. The simulator keeps drawing with the
// calibrations that it was started with, so the calibrations in the settings can be spoilt and recovered.
#include "base/params_json.h"
#include "e2e/calibration_points.h"
#include "e2e/repeated_referee.h"
#include "e2e/running_daemon.h"
#include "support/becomes.h"
#include "support/paths.h"

#include <algorithm>
#include <array>
#include <csignal>

#include <gmock/gmock.h>
#include <httplib.h>

namespace sslv::test::joint_calibration_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr const char* kPath = "/api/calibration";
constexpr const char* kAccept = "/api/calibration/accept";
constexpr const char* kReject = "/api/calibration/reject";

CameraModel model_of(const Json& calibration) {
  return CameraModel(params_from_json<CameraCalibration>(calibration, ""));
}

class JointCalibration : public DaemonTest {
 protected:
  JointCalibration() {
    // Closer to the centre than in the demo, so that their images overlap by a metre; slow enough for a busy
    // computer.
    settings_["cameras"][0]["calibration"]["ty"] = -2000;
    settings_["cameras"][1]["calibration"]["ty"] = 2000;
    for (Json& camera : settings_["cameras"]) {
      camera["source"]["frame_rate_hz"] = 30;
      camera["source"]["speed"] = 0.5;
      truth_.push_back(model_of(camera["calibration"]));
    }
    settings_["network"]["referee"] = {{"group", GroupListener::kGroup}, {"port", referee_group_.port()}};
  }

  /// Applies calibrations that are some centimetres off, and returns them.
  Json spoil(const RunningDaemon& daemon) const {
    daemon.wait_for_status(
        [](const Json& s) { return s["cameras"][0]["fps"] > 0 && s["cameras"][1]["fps"] > 0; });
    Json patch = Json::array();
    for (const int camera : {0, 1}) {
      Json wrong = settings_["cameras"][camera]["calibration"];
      wrong["tx"] = wrong["tx"].get<double>() + (camera == 0 ? 25 : 20);
      wrong["tz"] = wrong["tz"].get<double>() + (camera == 0 ? 30 : -10);
      patch.push_back({{"op", "replace"},
                       {"path", "/cameras/" + std::to_string(camera) + "/calibration"},
                       {"value", wrong}});
    }
    daemon.patch(patch);
    return in_settings(daemon);
  }
  static Json wait_for_end(const RunningDaemon& daemon) {
    return daemon.wait_for(
        kPath, [](const Json& s) { return s["state"] != "collecting" && s["state"] != "solving"; });
  }
  /// Calibrates until both cameras have seen robots at the same moments, which takes longer on a busy
  /// computer.
  static Json calibrate_with_robots(RunningDaemon& daemon, Json request) {
    Json done;
    EXPECT_TRUE(becomes([&] {
      daemon.post(kPath, request, 202);
      done = wait_for_end(daemon);
      constexpr int kLong_s = 60;
      request["seconds"] = kLong_s;
      return done["ties"] > kFewTies;
    })) << done.dump(2);
    return done;
  }
  static constexpr int kFewTies = 3;
  static Json in_settings(const RunningDaemon& daemon) {
    const Json settings = daemon.get("/api/settings");
    Json out = Json::array();
    for (const Json& camera : settings["settings"]["cameras"]) out.push_back(camera["calibration"]);
    return out;
  }
  /// Largest distance in mm between the positions of one point according to the two calibrations, in the
  /// overlap.
  double worst_disagreement_mm(const Json& calibrations, double height_mm) const {
    const std::array models{model_of(calibrations[0]), model_of(calibrations[1])};
    double worst = 0;
    int places = 0;
    for (int y = -2800; y <= 2800; y += 200) {
      for (int x = -400; x <= 400; x += 100) {
        std::array<std::optional<Eigen::Vector2d>, 2> shown;
        for (std::size_t i = 0; i < 2; ++i) {
          const auto pixel = truth_[i].project({static_cast<double>(x), static_cast<double>(y), height_mm});
          const CameraCalibration& picture = truth_[i].calibration();
          if (pixel && pixel->x() > 0 && pixel->x() < picture.pixel_image_width - 1 && pixel->y() > 0 &&
              pixel->y() < picture.pixel_image_height - 1)
            shown[i] = models[i].unproject(*pixel, height_mm);
        }
        if (!shown[0] || !shown[1]) continue;
        worst = std::max(worst, (*shown[0] - *shown[1]).norm());
        ++places;
      }
    }
    EXPECT_GT(places, 50);
    return worst;
  }
  GroupListener referee_group_;
  RepeatedReferee referee_{referee_group_};
  std::vector<CameraModel> truth_;
};

TEST_F(JointCalibration, CamerasAgreeOnceItIsAccepted) {
  RunningDaemon daemon(settings_file(), state_);
  const Json wrong = spoil(daemon);
  const Json idle = daemon.get(kPath);
  EXPECT_EQ(idle["state"], "idle");
  EXPECT_TRUE(idle["request"].is_null());
  EXPECT_TRUE(idle["report"].is_null());

  const Json started = daemon.post(kPath, {{"seconds", 6}}, 202);
  EXPECT_EQ(started["state"], "collecting");
  EXPECT_EQ(started["request"]["cameras"], Json::array({0, 1}));
  EXPECT_EQ(started["who"], "127.0.0.1");
  Json done = wait_for_end(daemon);
  ASSERT_EQ(done["state"], "done") << done.dump(2);
  if (done["ties"] <= kFewTies) done = calibrate_with_robots(daemon, {{"seconds", 6}});
  const Json& report = done["report"];
  EXPECT_EQ(report["accepted"], true) << report.dump(2);
  EXPECT_EQ(done["frames_taken"], 10);
  EXPECT_GT(report["ties"], kFewTies) << report.dump(2);
  EXPECT_GT(report["on_floor"]["before_mm"], 10);
  EXPECT_LT(report["on_floor"]["after_mm"], 0.5);
  EXPECT_GT(report["of_robots"]["before_mm"], 10);
  EXPECT_LT(report["of_robots"]["after_mm"], 1);
  EXPECT_EQ(in_settings(daemon), wrong) << "before anybody accepted it";

  const auto revision = daemon.get("/api/settings")["revision"].get<int>();
  EXPECT_EQ(daemon.post(kAccept)["state"], "idle");
  EXPECT_EQ(daemon.get("/api/settings")["revision"], revision + 1);
  const Json found = in_settings(daemon);
  EXPECT_GT(worst_disagreement_mm(wrong, 0), 30);
  EXPECT_LT(worst_disagreement_mm(found, 0), 1);
  EXPECT_GT(worst_disagreement_mm(wrong, 150), 30);
  EXPECT_LT(worst_disagreement_mm(found, 150), 1);
  for (const std::size_t i : {0, 1}) {
    EXPECT_LT(worst_error_mm(truth_[i], model_of(found[i]), 0), 1.5);
    EXPECT_LT(worst_error_mm(truth_[i], model_of(found[i]), 150), 1.5);
    const Json camera = daemon.get("/api/cameras/" + std::to_string(i) + "/calibration");
    EXPECT_EQ(camera["calibration"], report["cameras"][i]["calibration"]);
    ASSERT_EQ(camera["history"].size(), 1u);
    EXPECT_EQ(camera["history"][0]["replaced"], wrong[i]);
    EXPECT_EQ(camera["history"][0]["who"], "127.0.0.1");
    EXPECT_EQ(camera["history"][0]["figures"]["together"], Json::array({0, 1}));
  }
  daemon.post(kAccept, Json::object(), 409);

  // Each camera can be reverted separately.
  EXPECT_EQ(daemon.post("/api/cameras/1/calibration/revert")["calibration"], wrong[1]);
  EXPECT_EQ(in_settings(daemon), Json::array({found[0], wrong[1]}));
}

TEST_F(JointCalibration, FromTheCommandLine) {
  RunningDaemon daemon(settings_file(), state_);
  const Json wrong = spoil(daemon);
  const std::string figures = folder_.file("report.json");
  const auto run =
      run_to_end({ctl_program(), "--daemon", daemon.address(), "calibrate", "--together", "--cameras", "1,0",
                  "--seconds", "2", "--frames", "3", "--accept", "--report", figures});
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_THAT(run.output, AllOf(HasSubstr("good enough"), HasSubstr("mm apart, before"),
                                HasSubstr("camera 1"), HasSubstr("in use")));
  EXPECT_LT(worst_disagreement_mm(in_settings(daemon), 0), 1);

  const auto unknown = run_to_end(
      {ctl_program(), "--daemon", daemon.address(), "calibrate", "--together", "--cameras", "0,7"});
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_THAT(unknown.output, HasSubstr("/cameras/1: no camera 7; known: 0, 1"));
  for (const auto& wrong_words : {std::vector<std::string>{"--together", "--camera", "0"},
                                  {"--together", "--points", "x"},
                                  {"--together", "--cameras", "0,x"},
                                  {"--camera", "0", "--cameras", "0,1"},
                                  {"--input", "x", "--field", "division-b", "--output", "o", "--accept"}}) {
    std::vector<std::string> words{ctl_program(), "calibrate"};
    words.insert(words.end(), wrong_words.begin(), wrong_words.end());
    const auto refused = run_to_end(words);
    EXPECT_EQ(refused.exit_code, 64) << refused.output;
  }
}

TEST_F(JointCalibration, BadRequestsAreNamedAndChangeNothing) {
  settings_["cameras"].push_back(settings_["cameras"][1]);
  settings_["cameras"][2]["id"] = 2;
  RunningDaemon daemon(settings_file(), state_);
  const auto refusal = [&](const char* body, int status) {
    return daemon.post(kPath, Json::parse(body), status)["error"].get<std::string>();
  };
  EXPECT_THAT(refusal(R"({"cameras": [0, 7]})", 422), HasSubstr("/cameras/1: no camera 7; known: 0, 1, 2"));
  EXPECT_THAT(refusal(R"({"cameras": [0]})", 422), HasSubstr("/cameras: 1 is too few"));
  EXPECT_THAT(refusal(R"({"cameras": [0, 0]})", 422), HasSubstr("/cameras/1: 0 is not allowed"));
  EXPECT_THAT(refusal(R"({"cameras": "all"})", 422), HasSubstr("/cameras: \"all\" is not allowed"));
  EXPECT_THAT(refusal(R"({"frames": 0})", 422), HasSubstr("/frames: 0 is not allowed"));
  EXPECT_THAT(refusal(R"({"seconds": -1})", 422), HasSubstr("/seconds: -1 is not allowed"));
  EXPECT_THAT(refusal(R"({"camera": 0})", 422), HasSubstr("/camera: no such parameter"));
  EXPECT_THAT(refusal("[0, 1]", 422), HasSubstr("expected an object"));
  const auto broken = httplib::Client(daemon.address()).Post(kPath, "{\"cameras\": [0,", "application/json");
  ASSERT_TRUE(broken);
  EXPECT_EQ(broken->status, 400);
  EXPECT_THAT(broken->body, HasSubstr("not JSON"));

  const auto uncalibrate = [&](int camera) {
    daemon.set("/cameras/" + std::to_string(camera) + "/calibration", nullptr);
  };
  uncalibrate(2);
  EXPECT_THAT(refusal(R"({"cameras": [0, 2]})", 409),
              HasSubstr("camera 2 is not calibrated: calibrate it first"));
  uncalibrate(1);
  EXPECT_THAT(refusal("{}", 409), HasSubstr("1 of 3 cameras is calibrated: calibrate two or more first"));
  daemon.post(kAccept, Json::object(), 409);
  daemon.post(kReject, Json::object(), 409);
  daemon.remove(kPath, 409);
  EXPECT_EQ(daemon.get(kPath)["state"], "idle");
}

TEST_F(JointCalibration, RunsOnceCanBeCancelledAndIsLockedWhileTheGameRuns) {
  RunningDaemon daemon(settings_file(), state_);
  const Json wrong = spoil(daemon);
  daemon.post(kPath, {{"seconds", 600}}, 202);
  EXPECT_THAT(daemon.post(kPath, Json::object(), 409)["error"].get<std::string>(), HasSubstr("already"));
  daemon.post(kAccept, Json::object(), 409);
  daemon.post(kReject, Json::object(), 409);
  EXPECT_EQ(daemon.remove(kPath)["state"], "cancelled");
  daemon.remove(kPath, 409);

  const auto wait_until_running = [&](bool running) {
    daemon.wait_for(kPath, [&](const Json& s) { return s["game_is_running"] == running; });
  };
  referee_.say(RepeatedReferee::kFirstHalf, RepeatedReferee::kForceStart);
  wait_until_running(true);
  const Json quick{{"seconds", 0}, {"frames", 1}};
  EXPECT_THAT(daemon.post(kPath, quick, 423)["error"].get<std::string>(), HasSubstr("the game is running"));
  Json forced = quick;
  forced["force"] = true;
  daemon.post(kPath, forced, 202);
  const Json done = wait_for_end(daemon);
  ASSERT_EQ(done["report"]["accepted"], true) << done.dump(2);
  daemon.post(kAccept, Json::object(), 423);
  EXPECT_EQ(in_settings(daemon), wrong);
  referee_.say(RepeatedReferee::kFirstHalf, RepeatedReferee::kHalt);
  wait_until_running(false);
  EXPECT_EQ(daemon.post(kReject)["state"], "idle");
  EXPECT_EQ(in_settings(daemon), wrong);

  daemon.post(kPath, {{"seconds", 600}}, 202);  // the daemon's shutdown does not wait for it
  daemon.process().send_signal(SIGTERM);
  EXPECT_EQ(daemon.process().wait_for_exit(), 0) << daemon.process().output();
}

TEST_F(JointCalibration, OfOtherPicturesIsNeverAccepted) {
  RunningDaemon daemon(settings_file(), state_);
  spoil(daemon);
  const auto expect_invalid = [&] {
    const Json state = daemon.get(kPath);
    EXPECT_EQ(state["state"], "failed");
    EXPECT_TRUE(state["report"].is_null());
    EXPECT_THAT(state["problem"].get<std::string>(), HasSubstr("has changed since"));
    daemon.post(kAccept, {{"force", true}}, 409);
  };
  // The calibration is done, then a camera gets another source.
  daemon.post(kPath, {{"seconds", 0}, {"frames", 1}}, 202);
  ASSERT_EQ(wait_for_end(daemon)["state"], "done");
  daemon.set("/cameras/1/source/speed", 0.7);
  expect_invalid();
  // The camera is removed while the calibration runs.
  daemon.post(kPath, {{"seconds", 600}}, 202);
  daemon.patch(Json::array({{{"op", "remove"}, {"path", "/cameras/1"}}}));
  expect_invalid();
}

TEST_F(JointCalibration, APoorResultIsAcceptedOnlyByForce) {
  RunningDaemon daemon(settings_file(), state_);
  spoil(daemon);
  // The robot heights are set too low: the robots' positions would agree only if the cameras were lower.
  daemon.patch(Json::array({{{"op", "replace"}, {"path", "/teams/yellow/robot_height"}, {"value", 110}},
                            {{"op", "replace"}, {"path", "/teams/blue/robot_height"}, {"value", 110}}}));
  const Json done = calibrate_with_robots(daemon, {{"seconds", 6}, {"frames", 3}});
  ASSERT_EQ(done["report"]["found"], true) << done.dump(2);
  ASSERT_EQ(done["report"]["accepted"], false) << done.dump(2);
  EXPECT_THAT(daemon.post(kAccept, Json::object(), 409)["error"].get<std::string>(),
              AllOf(HasSubstr("not good enough"), HasSubstr("robot heights")));
  daemon.post(kAccept, {{"force", true}});
  EXPECT_EQ(in_settings(daemon)[0], done["report"]["cameras"][0]["calibration"]);
}

}  // namespace
}  // namespace sslv::test::joint_calibration_test
