// SPDX-License-Identifier: Apache-2.0
// The real daemon with its simulator, real multicast, real HTTP.
#include "base/params_json.h"
#include "capture/simulator/simulator.h"
#include "capture/simulator/simulator_world.h"
#include "e2e/running_daemon.h"
#include "geometry/camera_model.h"
#include "support/paths.h"

#include <cmath>
#include <csignal>
#include <map>
#include <numbers>

#include <gmock/gmock.h>

namespace sslv::test::daemon_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::MatchesRegex;
using ::testing::StartsWith;

class Daemon : public DaemonTest {};

/// Ground truth from the simulator.
struct Truth {
  explicit Truth(const Json& settings) {
    Json options = settings["cameras"][0]["source"];
    options.erase("backend");
    world.emplace(simulator_options(options, ""), FieldSize{}, std::array<double, 2>{140, 140});
    for (const Json& camera : settings["cameras"]) {
      cameras.emplace(camera["id"],
                      CameraModel(params_from_json<CameraCalibration>(camera["calibration"], "")));
    }
  }
  /// An object this far inside the image is completely visible: a robot's disc has a radius of about 11 px
  /// here.
  bool sees(int camera, double x_mm, double y_mm, double z_mm) const {
    constexpr double kMargin_px = 16;
    const auto pixel = cameras.at(camera).project({x_mm, y_mm, z_mm});
    return pixel && pixel->x() > kMargin_px && pixel->x() < 780 - kMargin_px && pixel->y() > kMargin_px &&
           pixel->y() < 580 - kMargin_px;
  }
  std::optional<SimulatedWorld> world;
  std::map<int, CameraModel> cameras;
};

TEST_F(Daemon, SendsAllRobotsAndTheBallWhereTheyAre) {
  const Truth truth(settings_);
  RunningDaemon daemon(settings_file(), state_);

  std::map<std::uint32_t, int> frames;
  std::map<std::uint32_t, std::uint32_t> last_number;
  int robots = 0, balls = 0, geometries = 0;
  double robot_error_mm = 0, ball_error_mm = 0, worst_turn_rad = 0;
  while (frames[0] < 150 || frames[1] < 150 || geometries < 2) {
    const SSL_WrapperPacket packet = receive(listener_);
    EXPECT_EQ(packet.source(), SSL_SOURCE_OTHER);
    if (packet.has_geometry()) {
      ++geometries;
      EXPECT_EQ(packet.geometry().field().field_length(), 9000);
      ASSERT_EQ(packet.geometry().calib_size(), 2);
      EXPECT_NEAR(packet.geometry().calib(1).derived_camera_world_tz(), 4000, 1);
    }
    if (!packet.has_detection()) continue;
    const SSL_DetectionFrame& frame = packet.detection();
    const auto camera = frame.camera_id();
    ASSERT_LT(camera, 2u);
    if (frames[camera]++ > 0) {
      EXPECT_GT(frame.frame_number(), last_number[camera]);
    }
    last_number[camera] = frame.frame_number();
    EXPECT_GE(frame.t_sent(), frame.t_capture());

    const SimulatedScene scene = truth.world->at(frame.t_capture());
    for (const SimulatedRobot& robot : scene.robots) {
      if (!truth.sees(static_cast<int>(camera), robot.x_mm, robot.y_mm, robot.height_mm)) continue;
      const auto& seen = robot.team == Team::kBlue ? frame.robots_blue() : frame.robots_yellow();
      const auto found = std::find_if(seen.begin(), seen.end(), [&](const SSL_DetectionRobot& one) {
        return one.robot_id() == static_cast<std::uint32_t>(robot.id);
      });
      ASSERT_NE(found, seen.end()) << "camera " << camera << " does not report robot " << robot.id << "\n"
                                   << frame.DebugString();
      const double error_mm = std::hypot(found->x() - robot.x_mm, found->y() - robot.y_mm);
      EXPECT_LT(error_mm, 12);
      robot_error_mm += error_mm;
      ++robots;
      worst_turn_rad = std::max(
          worst_turn_rad,
          std::abs(std::remainder(found->orientation() - robot.orientation_rad, 2 * std::numbers::pi)));
      EXPECT_FLOAT_EQ(found->height(), 140);
    }
    // No false detections: everything reported matches the truth, with its id.
    for (const auto& [team, seen] :
         {std::pair{Team::kYellow, &frame.robots_yellow()}, {Team::kBlue, &frame.robots_blue()}}) {
      for (const SSL_DetectionRobot& one : *seen) {
        EXPECT_TRUE(std::any_of(scene.robots.begin(), scene.robots.end(),
                                [&, team = team](const SimulatedRobot& robot) {
                                  return robot.team == team && robot.id == static_cast<int>(one.robot_id()) &&
                                         std::hypot(one.x() - robot.x_mm, one.y() - robot.y_mm) < 50;
                                }))
            << one.DebugString();
      }
    }
    for (const SimulatedBall& ball : scene.balls) {
      if (!truth.sees(static_cast<int>(camera), ball.x_mm, ball.y_mm, 21.5)) continue;
      ASSERT_GE(frame.balls_size(), 1);
      ball_error_mm += std::hypot(frame.balls(0).x() - ball.x_mm, frame.balls(0).y() - ball.y_mm);
      ++balls;
    }
  }
  ASSERT_GT(robots, 1000);
  ASSERT_GT(balls, 100);
  std::printf("mean error: robots %.2f mm, ball %.2f mm; worst heading error %.2f degrees\n",
              robot_error_mm / robots, ball_error_mm / balls, worst_turn_rad * 180 / std::numbers::pi);
  EXPECT_LT(robot_error_mm / robots, 3);
  EXPECT_LT(ball_error_mm / balls, 5);
  EXPECT_LT(worst_turn_rad, 0.12);
}

TEST_F(Daemon, TilesOfOneCameraFindWhatItShows) {
  constexpr int kWidth = 440;
  const Truth truth(settings_);
  const Json whole = settings_["cameras"][0];
  settings_["cameras"] = Json::array();
  for (const int i : {0, 1}) {
    Json tile = whole;
    const int x = 340 * i;
    tile["id"] = i;
    tile["source"] = {{"backend", "tile"}, {"of", whole["source"]}, {"x", x}, {"y", 0},
                      {"width", kWidth},   {"height", 580}};
    tile["calibration"]["principal_point_x"] = whole["calibration"]["principal_point_x"].get<double>() - x;
    tile["calibration"]["pixel_image_width"] = kWidth;
    settings_["cameras"].push_back(tile);
  }
  RunningDaemon daemon(settings_file(), state_);
  std::array<int, 2> frames{}, robots{};
  while (frames[0] < 40 || frames[1] < 40) {
    const SSL_WrapperPacket packet = receive(listener_);
    if (!packet.has_detection()) continue;
    const SSL_DetectionFrame& frame = packet.detection();
    const auto camera = frame.camera_id();
    ASSERT_LT(camera, 2U);
    ++frames[camera];
    for (const SimulatedRobot& robot : truth.world->at(frame.t_capture()).robots) {
      // The image of the whole camera; a tile shows a part of it.
      const auto pixel = truth.cameras.at(0).project({robot.x_mm, robot.y_mm, robot.height_mm});
      const double x = pixel ? pixel->x() - 340.0 * camera : 0;
      if (!pixel || x < 20 || x > kWidth - 20 || pixel->y() < 20 || pixel->y() > 560) continue;
      const auto& seen = robot.team == Team::kBlue ? frame.robots_blue() : frame.robots_yellow();
      const auto found = std::find_if(seen.begin(), seen.end(), [&](const SSL_DetectionRobot& one) {
        return one.robot_id() == static_cast<std::uint32_t>(robot.id);
      });
      ASSERT_NE(found, seen.end()) << "tile " << camera << " does not report robot " << robot.id;
      EXPECT_LT(std::hypot(found->x() - robot.x_mm, found->y() - robot.y_mm), 12);
      ++robots[camera];
    }
  }
  EXPECT_GT(robots[0], 40);
  EXPECT_GT(robots[1], 40);
  const Json status = daemon.get("/api/status");
  EXPECT_EQ(status["cameras"][1]["width"], kWidth);
  EXPECT_EQ(status["cameras"][1]["backend"], "tile");
}

TEST_F(Daemon, EndsCleanlyWhenAsked) {
  for (const int signal : {SIGTERM, SIGINT}) {
    RunningDaemon daemon(settings_file(), state_);
    daemon.process().send_signal(signal);
    EXPECT_EQ(daemon.process().wait_for_exit(), 0) << daemon.process().output();
  }
}

TEST_F(Daemon, SendsGeometryWithoutAnyCamera) {
  settings_["cameras"] = Json::array();
  settings_["network"]["vision"]["geometry_interval_s"] = 0.1;
  RunningDaemon daemon(settings_file(), state_);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(receive(listener_).geometry().calib_size(), 0);
}

TEST_F(Daemon, SendsTheGeometryThatIsSetAndServesTheLeagues) {
  settings_["field"] = {
      {"goal_substitution_area_width", 400},
      {"field_lines", {{{"name", "HalfwayLine"}, {"y1", -2990}, {"y2", 2985}, {"thickness", 25}}}},
      {"field_arcs", Json::array()}};
  settings_["ball_models"] = {{"acc_roll", -0.5}};
  RunningDaemon daemon(settings_file(), state_);
  const auto next_geometry = [&] {
    for (;;) {
      SSL_WrapperPacket packet = receive(listener_);
      if (packet.has_geometry()) return packet.geometry();
    }
  };
  const SSL_GeometryData given = next_geometry();
  EXPECT_EQ(given.field().goal_substitution_area_width(), 400);
  ASSERT_EQ(given.field().field_lines_size(), 1);
  EXPECT_EQ(given.field().field_lines(0).type(), HalfwayLine);
  EXPECT_EQ(given.field().field_lines(0).p2().y(), 2985);
  EXPECT_EQ(given.field().field_lines(0).thickness(), 25);
  EXPECT_EQ(given.field().field_arcs_size(), 0);
  EXPECT_EQ(given.models().straight_two_phase().acc_roll(), -0.5);
  EXPECT_EQ(given.models().straight_two_phase().acc_slide(), -3.4);
  EXPECT_EQ(given.calib_size(), 2);

  const Json presets = daemon.get("/api/field/presets");
  ASSERT_EQ(presets[0]["name"], "division-a");
  daemon.patch(Json::array({{{"op", "replace"}, {"path", "/field"}, {"value", presets[0]["field"]}},
                            {{"op", "replace"}, {"path", "/ball_models"}, {"value", nullptr}}}));
  SSL_GeometryData changed = next_geometry();
  while (changed.field().field_length() != 12000) changed = next_geometry();  // skip those sent before
  EXPECT_EQ(changed.field().boundary_width_goal_line(), 600);
  EXPECT_EQ(changed.field().field_lines_size(), 12);
  EXPECT_EQ(changed.field().field_arcs_size(), 1);
  EXPECT_EQ(changed.field().goal_substitution_area_width(), 300);
  EXPECT_FALSE(changed.has_models());
}

TEST_F(Daemon, SendsEmptyFramesToo) {
  for (Json& camera : settings_["cameras"]) {
    camera["source"].update(Json{{"robots_yellow", 0}, {"robots_blue", 0}, {"balls", 0}});
  }
  RunningDaemon daemon(settings_file(), state_);
  for (int frames = 0; frames < 10;) {
    const SSL_WrapperPacket packet = receive(listener_);
    if (!packet.has_detection()) continue;
    EXPECT_EQ(packet.detection().balls_size() + packet.detection().robots_blue_size(), 0);
    ++frames;
  }
}

TEST_F(Daemon, ReportsItsStatus) {
  RunningDaemon daemon(settings_file(), state_);
  const Json status = daemon.wait_for_status(
      [](const Json& s) { return s["cameras"][0]["fps"] > 0 && s["cameras"][1]["fps"] > 0; });
  EXPECT_THAT(status["alerts"], IsEmpty());
  const Json& camera = status["cameras"][0];
  EXPECT_EQ(camera["state"], "running");
  EXPECT_EQ(camera["width"], 780);
  EXPECT_EQ(camera["pixel_format"], "uyvy");
  EXPECT_EQ(camera["stages"].size(), 4u);
  EXPECT_NEAR(camera["calibration"]["derived_camera_world_tx"].get<double>(), -2350, 5);
  const auto told = run_to_end({ctl_program(), "--daemon", daemon.address(), "status"});
  EXPECT_EQ(told.exit_code, 0);
  EXPECT_THAT(told.output, AllOf(HasSubstr("Demo field"), HasSubstr("running"), HasSubstr("780x580")));
  const auto file = folder_.file("picture.jpg");
  EXPECT_EQ(
      run_to_end({ctl_program(), "--daemon", daemon.address(), "snapshot", "--camera", "1", "--output", file})
          .exit_code,
      0);
  EXPECT_GT(std::filesystem::file_size(file), 10'000u);
}

TEST_F(Daemon, AChangeIsLiveSavedAndSurvivesAKill) {
  const Json three = Json::array(
      {{{"op", "replace"}, {"path", "/cameras/0/stages/detect_robots/min_confidence"}, {"value", 1.0}},
       {{"op", "replace"}, {"path", "/site"}, {"value", "Field B"}}});
  {
    RunningDaemon daemon(settings_file(), state_);
    daemon.wait_for_status([](const Json& s) { return s["cameras"][0]["robots"] >= 4; });
    EXPECT_EQ(daemon.patch(three)["saved"], true);
    // No detection reaches confidence 1: the robots vanish as soon as the change is live.
    daemon.wait_for_status([](const Json& s) { return s["cameras"][0]["robots"] <= 2; });
    daemon.process().send_signal(SIGKILL);
    daemon.process().wait_for_exit();
  }
  RunningDaemon daemon(settings_file(), state_);
  const Json settings = daemon.get("/api/settings");
  EXPECT_EQ(settings["revision"], 2);
  EXPECT_EQ(settings["settings"]["site"], "Field B");
  EXPECT_EQ(settings["settings"]["cameras"][0]["stages"]["detect_robots"]["min_confidence"], 1.0);
}

TEST_F(Daemon, AChangeIsUndoneFromTheCommandLine) {
  RunningDaemon daemon(settings_file(), state_);
  const std::string site = settings_["site"].get<std::string>();
  daemon.set("/site", "Field B");
  daemon.set("/cameras/1/name", "left");
  const auto ctl = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {ctl_program(), "--daemon", daemon.address()});
    return run_to_end(words);
  };
  EXPECT_THAT(ctl({"history"}).output,
              AllOf(HasSubstr("/site: \"" + site + "\" -> \"Field B\""), HasSubstr("127.0.0.1")));
  EXPECT_EQ(ctl({"undo", "2"}).output, "Undone; the settings are at revision 4.\n");
  const Json settings = daemon.get("/api/settings")["settings"];
  EXPECT_EQ(settings["site"], site);
  EXPECT_EQ(settings["cameras"][1]["name"], "left");
  const Finished again = ctl({"undo", "2"});
  EXPECT_NE(again.exit_code, 0);
  EXPECT_THAT(again.output,
              AllOf(StartsWith("ssl-visionctl: the values of revision 2 have changed since; "),
                    HasSubstr("127.0.0.1 made revision 4: /site: \"Field B\" -> \"" + site + "\"")));
}

TEST_F(Daemon, ARefusedChangeNamesItsKeyAndChangesNothing) {
  RunningDaemon daemon(settings_file(), state_);
  const Json before = daemon.get("/api/settings");
  const auto refusal = [&](const char* path, const Json& value) {
    return daemon.set(path, value, 422)["error"].get<std::string>();
  };
  EXPECT_THAT(refusal("/cameras/0/stages/detect_balls/max_balls", 0),
              AllOf(HasSubstr("/cameras/0/stages/detect_balls/max_balls: 0"), HasSubstr("1 .. 1000")));
  EXPECT_THAT(refusal("/cameras/1/id", 0), HasSubstr("/cameras/1/id: 0 is the id of /cameras/0 already"));
  EXPECT_THAT(refusal("/cameras/0/stack", Json{"find_runs"}),
              HasSubstr("stage 'find_runs' needs 'labels', which no earlier stage provides"));
  EXPECT_THAT(refusal("/cameras/0/colors/lut_file", "/no/such.lut"), HasSubstr("/no/such.lut"));
  EXPECT_THAT(refusal("/field/field_lines", Json::parse(R"([{"name": "A"}, {"name": "A"}])")),
              HasSubstr("/field/field_lines/1/name: \"A\""));
  EXPECT_THAT(refusal("/network/vision/group", "10.0.0.1"), HasSubstr("/network/vision/group"));
  EXPECT_EQ(daemon.get("/api/settings"), before);
}

TEST_F(Daemon, ACameraMayComeGoAndChangeItsStackWhileRunning) {
  const Json second = settings_["cameras"][1];
  settings_["cameras"].erase(1);
  RunningDaemon daemon(settings_file(), state_);
  daemon.patch(Json::array({{{"op", "add"}, {"path", "/cameras/-"}, {"value", second}}}));
  daemon.wait_for_status(
      [](const Json& s) { return s["cameras"].size() == 2 && s["cameras"][1]["robots"] > 0; });
  daemon.set("/cameras/1/stack", {"threshold", "find_runs"});
  daemon.wait_for_status([](const Json& s) { return s["cameras"][1]["stages"].size() == 2; });
  daemon.patch(Json::array({{{"op", "remove"}, {"path", "/cameras/0"}}}));
  daemon.wait_for_status(
      [](const Json& s) { return s["cameras"].size() == 1 && s["cameras"][0]["id"] == 1; });
}

TEST_F(Daemon, WarnsIfTheCalibrationIsForAnotherImageSize) {
  Json& camera = settings_["cameras"][1];
  camera["source"] = {
      {"backend", "files"}, {"path", source_path("/tests/golden/division_b.jpg")}, {"loop", true}};
  camera["calibration"].update(Json{{"pixel_image_width", 1280}, {"pixel_image_height", 952}});
  RunningDaemon daemon(settings_file(), state_);
  const Json status =
      daemon.wait_for_status([](const Json& s) { return has_alert(s, "calibration_other_size"); });
  EXPECT_EQ(alert_of(status, "calibration_other_size")["camera"], 1);
  EXPECT_THAT(title_of_alert(status, "calibration_other_size"),
              AllOf(HasSubstr("780x580"), HasSubstr("1280x952")));
}

TEST_F(Daemon, RefusesToStartOnAPortThatIsTaken) {
  RunningDaemon daemon(settings_file(), state_);
  const std::string port = daemon.address().substr(daemon.address().rfind(':') + 1);
  settings_["panel"]["port"] = std::stoi(port);
  const auto second =
      run_to_end({daemon_program(), "--config", folder_.write("second.json", settings_.dump())},
                 {"STATE_DIRECTORY=" + folder_.file("second")});
  EXPECT_EQ(second.exit_code, 75);
  EXPECT_THAT(second.output, AllOf(HasSubstr("/panel/port"), HasSubstr(port), HasSubstr("taken")));
}

TEST_F(Daemon, GoesOnWhenTheNetworkCardIsNotThereAndSaysSo) {
  settings_["network"]["vision"]["interface"] = "nocard0";
  RunningDaemon daemon(settings_file(), state_);
  const Json status = daemon.wait_for_status(
      [](const Json& s) { return s["network"]["send_errors"] > 10 && s["cameras"][0]["robots"] > 0; });
  EXPECT_THAT(status["network"]["error"].get<std::string>(), HasSubstr("nocard0"));
  EXPECT_EQ(alert_of(status, "not_sending")["severity"], "bad");
  daemon.set("/network/vision/interface", "lo");
  receive(listener_);
  daemon.wait_for_status([](const Json& s) { return s["network"]["error"] == "" && s["alerts"].empty(); });
}

// ---- unusable settings: exit code 78 and one line with file, key, value and what is allowed

struct BadSettings {
  const char* name;
  const char* patch;  // applied to the demo's settings
  std::vector<std::string> words;
};
void PrintTo(const BadSettings& bad, std::ostream* out) {
  *out << bad.name;
}
class BadSettingsTest : public ::testing::TestWithParam<BadSettings> {};

TEST_P(BadSettingsTest, AreNamedAtStart) {
  const TemporaryFolder folder;
  const Json settings = demo_settings(12345).patch(Json::parse(GetParam().patch));
  const std::string file = folder.write("field.json", settings.dump(2));
  for (const char* option : {"--check-config", "--config"}) {
    const auto run =
        run_to_end({daemon_program(), option, file}, {"STATE_DIRECTORY=" + folder.path().string()});
    EXPECT_EQ(run.exit_code, 78) << run.output;
    EXPECT_THAT(run.output, HasSubstr(file));
    for (const std::string& word : GetParam().words) EXPECT_THAT(run.output, HasSubstr(word));
    EXPECT_EQ(std::count(run.output.begin(), run.output.end(), '\n'), 1) << run.output;
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, BadSettingsTest,
    ::testing::Values(
        BadSettings{"UnknownKey",
                    R"([{"op": "add", "path": "/feild", "value": {}}])",
                    {"/feild: no such parameter", "field"}},
        BadSettings{"OutOfRange",
                    R"([{"op": "add", "path": "/panel/port", "value": 70000}])",
                    {"/panel/port: 70000", "0 .. 65535"}},
        BadSettings{
            "WrongType",
            R"([{"op": "add", "path": "/cameras/0/stages", "value": {"detect_balls": {"max_balls": "many"}}}])",
            {"/cameras/0/stages/detect_balls/max_balls: \"many\"", "a whole number 1 .. 1000"}},
        BadSettings{
            "MisspeltParameter",
            R"([{"op": "add", "path": "/cameras/0/stages", "value": {"detect_balls": {"max_bals": 3}}}])",
            {"/cameras/0/stages/detect_balls/max_bals: no such parameter", "max_balls"}},
        BadSettings{
            "MissingInput",
            R"([{"op": "add", "path": "/cameras/1/stack", "value": ["threshold", "find_regions"]}])",
            {"/cameras/1/stack/1: stage 'find_regions' needs 'runs', which no earlier stage provides"}},
        BadSettings{"UnknownStage",
                    R"([{"op": "add", "path": "/cameras/1/stack", "value": ["treshold"]}])",
                    {"/cameras/1/stack/0: unknown stage 'treshold'", "threshold"}},
        BadSettings{
            "UnknownBackend",
            R"([{"op": "replace", "path": "/cameras/0/source/backend", "value": "firewire"}])",
            {"/cameras/0/source/backend", "firewire", "aravis, dc1394, files, simulator, tile, v4l2"}},
        BadSettings{"UnknownOption",
                    R"([{"op": "add", "path": "/cameras/0/source/robots", "value": 3}])",
                    {"/cameras/0/source/robots: no such parameter", "robots_yellow"}},
        BadSettings{"OneIdTwice",
                    R"([{"op": "replace", "path": "/cameras/1/id", "value": 0}])",
                    {"/cameras/1/id: 0 is the id of /cameras/0 already"}},
        BadSettings{"NoRotation",
                    R"([{"op": "replace", "path": "/cameras/0/calibration/q0", "value": 0.1}])",
                    {"/cameras/0/calibration", "quaternion"}},
        BadSettings{"NotOneToOne",
                    R"([{"op": "replace", "path": "/cameras/0/calibration/distortion", "value": -0.9}])",
                    {"/cameras/0/calibration/distortion: -0.9"}},
        BadSettings{"NoMulticastGroup",
                    R"([{"op": "replace", "path": "/network/vision/group", "value": "192.168.0.1"}])",
                    {"/network/vision/group", "192.168.0.1"}},
        BadSettings{"MissingLut",
                    R"([{"op": "add", "path": "/cameras/0/colors/lut_file", "value": "/no/such.lut"}])",
                    {"/cameras/0/colors/lut_file", "/no/such.lut", "No such file"}},
        BadSettings{"NoLutFile",
                    R"([{"op": "add", "path": "/cameras/0/colors/lut_file", "value": "/etc/passwd"}])",
                    {"/cameras/0/colors/lut_file", "does not begin with", "SSLVLUT2"}},
        BadSettings{"MissingPatterns",
                    R"([{"op": "add", "path": "/patterns_file", "value": "/no/such.json"}])",
                    {"/patterns_file", "/no/such.json"}}),
    [](const auto& one) { return one.param.name; });

TEST(Arguments, WrongOnesExitWithCode64) {
  EXPECT_EQ(run_to_end({daemon_program(), "--no-such-option"}).exit_code, 64);
  EXPECT_EQ(run_to_end({daemon_program()}).exit_code, 64);
  const auto unknown = run_to_end({ctl_program(), "no-such-command"});
  EXPECT_EQ(unknown.exit_code, 64);
  EXPECT_EQ(unknown.output, "ssl-visionctl: no command \"no-such-command\" (--help lists all)\n");
  EXPECT_EQ(run_to_end({ctl_program(), "chekc"}).output,
            "ssl-visionctl: no command \"chekc\"; did you mean \"check\"? (--help lists all)\n");
  EXPECT_EQ(run_to_end({ctl_program(), "match-log", "lst"}).output,
            "ssl-visionctl match-log: no command \"lst\"; did you mean \"list\"? (--help lists all)\n");
  EXPECT_THAT(run_to_end({ctl_program(), "snapshot", "image.jpg"}).output, HasSubstr("--output is required"));
  EXPECT_THAT(run_to_end({daemon_program(), "--config", "/no/such.json"}).output,
              AllOf(HasSubstr("/no/such.json"), HasSubstr("No such file")));
  EXPECT_THAT(run_to_end({daemon_program(), "--version"}).output,
              MatchesRegex("ssl-visiond [0-9]+\\.[0-9]+\\.[0-9]+\n"));
  EXPECT_THAT(run_to_end({ctl_program(), "--daemon", "http://127.0.0.1:1", "status"}).output,
              HasSubstr("no daemon answers"));
}

TEST(Arguments, EverySampleOfSettingsCanBeUsed) {
  int samples = 0;
  for (const auto& entry : std::filesystem::directory_iterator(source_path("/config"))) {
    if (entry.path().extension() != ".json") continue;
    const auto run = run_to_end({daemon_program(), "--check-config", entry.path().string()});
    EXPECT_EQ(run.exit_code, 0) << run.output;
    ++samples;
  }
  EXPECT_GE(samples, 2);
}

TEST(Arguments, PrintConfigIsAWholeTreeThatCanBeUsed) {
  const auto printed =
      run_to_end({daemon_program(), "--print-config", "--config", source_path("/config/demo.json")});
  EXPECT_EQ(printed.exit_code, 0);
  const TemporaryFolder folder;
  const std::string file = folder.write("whole.json", printed.output);
  EXPECT_EQ(run_to_end({daemon_program(), "--check-config", file}).exit_code, 0);
  EXPECT_EQ(Json::parse(printed.output)["cameras"][0]["stages"]["detect_balls"]["max_balls"], 20);
}

}  // namespace
}  // namespace sslv::test::daemon_test
