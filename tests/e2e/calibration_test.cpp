// SPDX-License-Identifier: Apache-2.0
// The real daemon calibrates its simulated camera. The simulator keeps drawing with the calibration that it
// was started with, so the calibration in the settings can be spoilt and recovered.
#include "base/params_json.h"
#include "e2e/calibration_points.h"
#include "e2e/repeated_referee.h"
#include "e2e/running_daemon.h"
#include "support/paths.h"

#include <csignal>
#include <fstream>

#include <gmock/gmock.h>

namespace sslv::test::calibration_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class Calibration : public DaemonTest {
 protected:
  Calibration() {
    settings_["cameras"].erase(1);
    // On a busy computer a faster camera would leave no time for a calibration.
    settings_["cameras"][0]["source"]["frame_rate_hz"] = 10;
    settings_["network"]["referee"] = {{"group", GroupListener::kGroup}, {"port", referee_group_.port()}};
  }
  Json request() const { return {{"points", clicked_points(truth_)}, {"height_mm", 4000}, {"frames", 5}}; }

  /// Applies a calibration that is some centimetres off, and returns it.
  Json spoil(const RunningDaemon& daemon) const {
    daemon.wait_for_status([](const Json& s) { return s["cameras"][0]["fps"] > 0; });
    Json wrong = settings_["cameras"][0]["calibration"];
    wrong["tx"] = wrong["tx"].get<double>() + 80;
    return daemon.set("/cameras/0/calibration", wrong)["settings"]["cameras"][0]["calibration"];
  }
  /// Waits until the calibration is idle or done; returns its state.
  static Json wait_for_end(const RunningDaemon& daemon) {
    return daemon.wait_for(
        kPath, [](const Json& s) { return s["state"] != "collecting" && s["state"] != "solving"; });
  }
  static Json in_settings(const RunningDaemon& daemon) {
    return daemon.get("/api/settings")["settings"]["cameras"][0]["calibration"];
  }
  static CameraModel model_of(const Json& calibration) {
    return CameraModel(params_from_json<CameraCalibration>(calibration, ""));
  }
  static constexpr const char* kPath = "/api/cameras/0/calibration";
  static constexpr const char* kAccept = "/api/cameras/0/calibration/accept";
  static constexpr const char* kReject = "/api/cameras/0/calibration/reject";
  static constexpr const char* kRevert = "/api/cameras/0/calibration/revert";

  GroupListener referee_group_;
  RepeatedReferee referee_{referee_group_};
  const CameraModel truth_ = model_of(settings_["cameras"][0]["calibration"]);
};

TEST_F(Calibration, IsFoundAcceptedKeptAndReverted) {
  Json wrong, found;
  settings_["cameras"][0]["source"]["lines_measured_to"] = "outer_edge";
  {
    RunningDaemon daemon(settings_file(), state_);
    wrong = spoil(daemon);
    const Json idle = daemon.get(kPath);
    EXPECT_EQ(idle["state"], "idle");
    EXPECT_TRUE(idle["request"].is_null());
    EXPECT_TRUE(idle["started"].is_null());
    EXPECT_EQ(idle["calibration"], wrong);
    EXPECT_GT(idle["points"].size(), 10u);
    EXPECT_EQ(idle["lines_measured_to"], "middle") << "as the rules say";
    EXPECT_TRUE(idle["history"].empty());

    const Json started = daemon.post(kPath, request(), 202);
    EXPECT_EQ(started["request"]["height_mm"], 4000);
    EXPECT_EQ(started["who"], "127.0.0.1");
    EXPECT_GT(started["started"], 1e9);
    const Json done = wait_for_end(daemon);
    ASSERT_EQ(done["state"], "done") << done.dump(2);
    EXPECT_EQ(done["frames_taken"], 5);
    EXPECT_EQ(done["report"]["accepted"], true) << done["report"].dump(2);
    EXPECT_GT(done["report"]["moved_on_floor_mm"], 50);
    // Detected as painted; the points to click move accordingly.
    EXPECT_EQ(done["lines_measured_to"], "outer_edge");
    EXPECT_NE(done["points"], idle["points"]);
    found = done["report"]["calibration"];
    EXPECT_LT(worst_error_mm(truth_, model_of(found), 0), 1.5);
    EXPECT_LT(worst_error_mm(truth_, model_of(found), 150), 6);
    EXPECT_EQ(in_settings(daemon), wrong) << "before anybody accepted it";

    const Json accepted = daemon.post(kAccept);
    EXPECT_EQ(accepted["state"], "idle");
    EXPECT_EQ(accepted["calibration"], found);
    ASSERT_EQ(accepted["history"].size(), 1u);
    EXPECT_EQ(accepted["history"][0]["who"], "127.0.0.1");
    EXPECT_EQ(accepted["history"][0]["figures"]["rms_px"], done["report"]["rms_px"]);
    EXPECT_EQ(in_settings(daemon), found);
    // Teams receive the new geometry.
    for (;;) {
      const SSL_WrapperPacket packet = receive(listener_);
      if (!packet.has_geometry()) continue;
      ASSERT_EQ(packet.geometry().calib_size(), 1);
      if (packet.geometry().calib(0).focal_length() == found["focal_length"].get<float>()) break;
    }
    daemon.post(kAccept, Json::object(), 409);
    daemon.process().send_signal(SIGKILL);
    daemon.process().wait_for_exit();
  }
  RunningDaemon daemon(settings_file(), state_);
  EXPECT_EQ(in_settings(daemon), found);
  const Json reverted = daemon.post(kRevert);
  EXPECT_EQ(reverted["calibration"], wrong);
  EXPECT_EQ(reverted["history"][0]["reverted_by"], "127.0.0.1");
  EXPECT_EQ(in_settings(daemon), wrong);
  EXPECT_THAT(daemon.post(kRevert, Json::object(), 409)["error"].get<std::string>(),
              HasSubstr("no earlier calibration"));
}

TEST_F(Calibration, ATileOfABigCameraNeedsNoClicks) {
  constexpr int kX = 340, kWidth = 440;
  Json& camera = settings_["cameras"][0];
  camera["source"] = {{"backend", "tile"}, {"of", camera["source"]}, {"x", kX}, {"y", 0},
                      {"width", kWidth},   {"height", 580}};
  Json& calibration = camera["calibration"];
  calibration["distortion"] = 0.25;
  calibration["principal_point_x"] = calibration["principal_point_x"].get<double>() - kX;
  calibration["pixel_image_width"] = kWidth;
  const Json truth = calibration;
  RunningDaemon daemon(settings_file(), state_);
  spoil(daemon);
  daemon.post(kPath, {{"height_mm", 4000}, {"frames", 5}}, 202);
  const Json done = wait_for_end(daemon);
  ASSERT_EQ(done["state"], "done") << done.dump(2);
  const Json& report = done["report"];
  EXPECT_EQ(report["accepted"], true) << report.dump(2);
  EXPECT_LT(worst_error_mm(model_of(truth), model_of(report["calibration"]), 0), 2);
  // The principal point is that of the whole image, at the tile's edge.
  EXPECT_NEAR(report["calibration"]["principal_point_x"].get<double>(),
              truth["principal_point_x"].get<double>(), 12);
}

TEST_F(Calibration, FromTheCommandLine) {
  RunningDaemon daemon(settings_file(), state_);
  const Json wrong = spoil(daemon);
  const std::string points = folder_.write("points.json", clicked_points(truth_).dump());
  const std::string output = folder_.file("calibration.json");
  const auto run = run_to_end({ctl_program(), "--daemon", daemon.address(), "calibrate", "--camera", "0",
                               "--points", points, "--height", "4000", "--output", output, "--accept"});
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_THAT(run.output, AllOf(HasSubstr("good enough"), HasSubstr("in use")));
  EXPECT_EQ(in_settings(daemon), Json::parse(std::ifstream(output)));
  EXPECT_LT(worst_error_mm(truth_, model_of(in_settings(daemon)), 0), 1.5);

  const auto unknown =
      run_to_end({ctl_program(), "--daemon", daemon.address(), "calibrate", "--camera", "7"});
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_THAT(unknown.output, HasSubstr("no camera 7"));
  const auto both = run_to_end({ctl_program(), "calibrate", "--camera", "0", "--input", "x", "--field",
                                "division-b", "--output", "o.json"});
  EXPECT_EQ(both.exit_code, 64);
  EXPECT_THAT(both.output, HasSubstr("--camera"));
  EXPECT_EQ(run_to_end({ctl_program(), "calibrate"}).exit_code, 64);
}

TEST_F(Calibration, RunsOnceAndCanBeCancelledAndRejected) {
  settings_["cameras"][0]["source"]["frame_rate_hz"] = 2;  // 100 images take longer than this test
  RunningDaemon daemon(settings_file(), state_);
  Json slow = request();
  slow["frames"] = 100;
  daemon.post(kPath, slow, 202);
  EXPECT_THAT(daemon.post(kPath, slow, 409)["error"].get<std::string>(), HasSubstr("already"));
  daemon.post(kReject, Json::object(), 409);
  EXPECT_EQ(daemon.remove(kPath)["state"], "cancelled");
  daemon.remove(kPath, 409);
  daemon.post(kAccept, Json::object(), 409);
  Json quick = request();
  quick["frames"] = 1;
  daemon.post(kPath, quick, 202);
  EXPECT_EQ(wait_for_end(daemon)["state"], "done");
  EXPECT_EQ(daemon.post(kReject)["state"], "idle");
  daemon.post(kAccept, Json::object(), 409);
  daemon.post(kPath, slow, 202);  // the daemon's shutdown does not wait for it
  daemon.process().send_signal(SIGTERM);
  EXPECT_EQ(daemon.process().wait_for_exit(), 0) << daemon.process().output();
}

TEST_F(Calibration, OfOtherPicturesIsNeverAccepted) {
  RunningDaemon daemon(settings_file(), state_);
  const auto expect_none = [&] {
    const Json state = daemon.get(kPath);
    EXPECT_EQ(state["state"], "failed");
    EXPECT_THAT(state["problem"].get<std::string>(), HasSubstr("has changed since"));
    daemon.post(kAccept, {{"force", true}}, 409);
  };
  daemon.post(kPath, request(), 202);
  ASSERT_EQ(wait_for_end(daemon)["report"]["accepted"], true);
  daemon.set("/site", "Field B");
  daemon.set("/cameras/0/name", "another name");
  EXPECT_EQ(daemon.get(kPath)["state"], "done") << "of the same pictures";
  daemon.set("/cameras/0/source/frame_rate_hz", 30);
  expect_none();

  daemon.post(kPath, request(), 202);
  ASSERT_EQ(wait_for_end(daemon)["report"]["accepted"], true);
  daemon.set("/cameras/0/id", 5);
  daemon.set("/cameras/0/id", 0);
  expect_none();

  Json endless = request();
  endless["frames"] = 100;
  daemon.set("/cameras/0/source/frame_rate_hz", 2);
  daemon.post(kPath, endless, 202);
  daemon.set("/cameras/0/source/frame_rate_hz", 60);
  expect_none();
  daemon.post(kPath, request(), 202);
  EXPECT_EQ(wait_for_end(daemon)["report"]["accepted"], true);
}

TEST_F(Calibration, BadRequestsAreNamedAndChangeNothing) {
  RunningDaemon daemon(settings_file(), state_);
  const auto refusal = [&](const char* body) {
    return daemon.post(kPath, Json::parse(body), 422)["error"].get<std::string>();
  };
  EXPECT_THAT(refusal(R"({"frames": 0})"), HasSubstr("/frames: 0 is not allowed; expected a whole number"));
  EXPECT_THAT(refusal(R"({"points": [{"x": 1}]})"), HasSubstr("/points/0/y: is missing"));
  EXPECT_THAT(refusal(R"({"heigth_mm": 4000})"), HasSubstr("/heigth_mm: no such parameter"));
  EXPECT_THAT(refusal(R"({"force": 1})"), HasSubstr("/force: 1 is not allowed"));
  daemon.post("/api/cameras/7/calibration", Json::object(), 404);
  EXPECT_EQ(daemon.get(kPath)["state"], "idle");
  daemon.post(kRevert, Json::object(), 409);

  daemon.wait_for_status([](const Json& s) { return s["cameras"][0]["fps"] > 0; });
  Json unknown = request();
  unknown["points"][0]["name"] = "moon";
  daemon.post(kPath, unknown, 202);
  const Json failed = wait_for_end(daemon);
  EXPECT_EQ(failed["state"], "failed");
  EXPECT_THAT(failed["problem"].get<std::string>(), HasSubstr("moon"));
  daemon.post(kAccept, Json::object(), 409);
}

TEST_F(Calibration, APoorResultIsAcceptedOnlyByForce) {
  RunningDaemon daemon(settings_file(), state_);
  spoil(daemon);
  // A field other than the one drawn.
  daemon.patch(Json::array({{{"op", "replace"}, {"path", "/field/penalty_area_width"}, {"value", 2900}},
                            {{"op", "replace"}, {"path", "/field/penalty_area_depth"}, {"value", 1500}},
                            {{"op", "replace"}, {"path", "/field/center_circle_radius"}, {"value", 900}}}));
  daemon.post(kPath, request(), 202);
  const Json done = wait_for_end(daemon);
  ASSERT_EQ(done["report"]["found"], true) << done.dump(2);
  ASSERT_EQ(done["report"]["accepted"], false) << done.dump(2);
  EXPECT_THAT(daemon.post(kAccept, Json::object(), 409)["error"].get<std::string>(),
              HasSubstr("not good enough"));
  EXPECT_EQ(daemon.get(kPath)["state"], "done");
  EXPECT_EQ(daemon.post(kAccept, {{"force", true}})["calibration"], done["report"]["calibration"]);
  // Someone sets another calibration by hand: reverting would lose that.
  const Json by_hand = spoil(daemon);
  EXPECT_THAT(daemon.post(kRevert, Json::object(), 409)["error"].get<std::string>(),
              HasSubstr("changed by other means"));
  EXPECT_EQ(in_settings(daemon), by_hand);
  daemon.post(kRevert, {{"force", true}});
}

TEST_F(Calibration, IsLockedWhileTheGameRuns) {
  RunningDaemon daemon(settings_file(), state_);
  const Json wrong = spoil(daemon);
  const auto wait_until_running = [&](bool running) {
    daemon.wait_for(kPath, [&](const Json& s) { return s["game_is_running"] == running; });
  };
  referee_.say(RepeatedReferee::kFirstHalf, RepeatedReferee::kForceStart);
  wait_until_running(true);
  EXPECT_THAT(daemon.post(kPath, request(), 423)["error"].get<std::string>(),
              HasSubstr("the game is running"));
  Json forced = request();
  forced["force"] = true;
  daemon.post(kPath, forced, 202);
  ASSERT_EQ(wait_for_end(daemon)["report"]["accepted"], true);
  daemon.post(kAccept, Json::object(), 423);
  EXPECT_EQ(in_settings(daemon), wrong);
  EXPECT_EQ(daemon.get(kPath)["state"], "done") << "nothing is lost";
  daemon.post(kAccept, {{"force", true}});
  daemon.post(kRevert, Json::object(), 423);
  referee_.say(RepeatedReferee::kFirstHalf, RepeatedReferee::kHalt);
  wait_until_running(false);
  EXPECT_EQ(daemon.post(kRevert)["calibration"], wrong);
}

}  // namespace
}  // namespace sslv::test::calibration_test
