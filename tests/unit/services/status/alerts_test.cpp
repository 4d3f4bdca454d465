// SPDX-License-Identifier: Apache-2.0
// The reports of all services, combined as the status service does.
#include "services/calibration/calibration_report.h"
#include "services/cameras/camera_report.h"
#include "services/colors/color_report.h"
#include "services/field/field_report.h"
#include "services/network/network_report.h"
#include "services/recording/recording_report.h"
#include "services/settings/settings_report.h"
#include "services/status/alert_times.h"
#include "services/status/computer_report.h"
#include "services/verdict/verdict_report.h"
#include "support/paths.h"

#include <cmath>
#include <fstream>
#include <iterator>
#include <set>

#include <gmock/gmock.h>

namespace sslv::alerts_test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct AnyCamera : CameraFacts {
  std::optional<CameraCalibration> calibration;
  bool field_changed_since_calibrated = false;
  std::optional<ColorFacts::Margin> min_margin;
  std::vector<std::string> missing_labels, swapped_labels;
  std::string grey_format;
};

struct Input {
  MulticastStatus network;
  std::vector<OtherVision> other_visions;
  bool another_host_sends = false;
  std::string listening_error;
  RefereeStatus referee;
  std::string settings_problem, save_problem, state_problem, reload_problem;
  std::vector<std::string> lost_tables;
  ComputerFigures computer;
  std::optional<ClockFigures> clock;
  CardsUsed cards;
  std::vector<AnyCamera> cameras;
  TeamsSettings teams;
  FieldWatch::Seen seen;
  Coverage coverage;
  std::array<std::optional<int>, 2> robots_allowed{};
  bool half_is_next = true;
  bool match_runs = false, robots_are_handled = false;
};

HealthReport report_of(const Input& input) {
  std::vector<CameraFacts> cameras;
  std::vector<CalibrationFacts> calibrations;
  std::vector<ColorFacts> colors;
  auto config = std::make_shared<Config>();
  for (const AnyCamera& camera : input.cameras) {
    cameras.push_back(camera);
    calibrations.push_back({camera.id, camera.health.width, camera.health.height, camera.calibration,
                            camera.field_changed_since_calibrated});
    colors.push_back(
        {camera.id, camera.min_margin, camera.missing_labels, camera.swapped_labels, camera.grey_format});
    config->cameras.emplace_back().id = camera.id;
  }
  config->teams = input.teams;
  HealthReport report;
  report_verdict({*config, input.seen, input.coverage, input.robots_allowed, input.match_runs,
                  input.half_is_next, input.robots_are_handled},
                 report);
  report_cameras(cameras, report);
  report_calibrations(calibrations, report);
  report_colors(colors, input.lost_tables, report);
  report_network({.config = config,
                  .multicast = input.network,
                  .geometry = std::make_shared<const Geometry>(),
                  .other_visions = input.other_visions,
                  .another_host_sends = input.another_host_sends,
                  .cards = input.cards,
                  .listening_error = input.listening_error,
                  .referee = input.referee},
                 report);
  report_recording({}, report);
  report_last_seconds({}, report);
  report_computer(input.computer, input.clock, report);
  report_settings({input.settings_problem, input.save_problem, input.state_problem, input.reload_problem},
                  report);
  report.finish();
  return report;
}

class Alerts : public ::testing::Test {
 protected:
  Alerts() {
    input_.network.packets_per_s = 122.4;
    input_.referee.silent_s = 0.2;
    input_.referee.followed = {"gc", "192.168.1.7"};
    input_.computer.memory_bytes = 8'000'000'000;
    input_.computer.memory_available_bytes = 5'000'000'000;
    input_.computer.disk = {"/var/lib/ssl-visiond", 100'000'000'000, 50'000'000'000};
    input_.clock = ClockFigures{true, 0.01, 0.5};
    input_.seen.field.ids = {{{0, 1, 2}, {4, 5}}};
    input_.seen.field.team_gone_s = {0.1, 0.1};
    input_.seen.field.overlaps = {{{0, 1}, 4, 50}};
    input_.seen.field.ball = true;
    input_.seen.lines = {{0, {{9, 3, 2, 0.1}, "CenterLine"}}, {1, {{8, 6, 0, 0.1}, "TopTouchLine"}}};
    input_.seen.watched_s = 60;
    input_.coverage = {true, 1000, {}, {}, {}};
    for (int id = 0; id < 2; ++id) {
      AnyCamera& camera = input_.cameras.emplace_back();
      camera.id = id;
      camera.backend = "simulator";
      camera.wanted_fps = 60;
      camera.health.state = CameraState::kRunning;
      camera.health.fps = 60 + id;
      camera.health.width = 780;
      camera.health.height = 580;
      camera.calibration.emplace();
      camera.calibration->pixel_image_width = 780;
      camera.calibration->pixel_image_height = 580;
      camera.latency_p99_ms = 0.9;
      camera.latency_images = 100;
      camera.last_minute = {60, 3600, 0, 0, 0};
      camera.last_seconds = {10, 600, 0, 0, 0};
      camera.exposure = Exposure{0.005, 0.01, 90};
    }
  }

  std::vector<Alert> alerts() const { return report_of(input_).alerts; }
  std::vector<std::string> kinds() const {
    std::vector<std::string> out;
    for (const Alert& alert : alerts()) out.push_back(alert.id);
    return out;
  }
  Alert only_alert() const {
    EXPECT_THAT(kinds(), testing::SizeIs(1));
    return alerts().at(0);
  }
  Check check(const std::string& id) const {
    for (Check& one : report_of(input_).checks) {
      if (one.id == id) return std::move(one);
    }
    throw std::logic_error("no such check");
  }
  bool is_go() const { return report_of(input_).is_go(); }

  Input input_;
};

TEST_F(Alerts, AreNoneWhenAllIsWell) {
  EXPECT_THAT(kinds(), IsEmpty());
}

TEST_F(Alerts, NameTheFloodingLabelAndItsPlace) {
  AnyCamera& camera = input_.cameras[1];
  camera.last_minute = {60, 3600, 0, 0, 120};
  EXPECT_EQ(only_alert().title, "Camera 1: too much to process, in 120 of 3600 images of the last minute");
  EXPECT_EQ(only_alert().severity, Severity::kInfo);
  camera.last_minute.capped = 1800;
  EXPECT_EQ(only_alert().severity, Severity::kWarn);
  camera.last_minute.capped = 120;
  camera.flood = "green floods the image between (0, 64) and (1279, 511) px";
  EXPECT_EQ(only_alert().id, "frames_capped");
  EXPECT_EQ(only_alert().severity, Severity::kWarn);
  EXPECT_EQ(
      only_alert().title,
      "Camera 1: green floods the image between (0, 64) and (1279, 511) px, in 120 of 3600 images of the "
      "last minute");
}

/// All alerts that the field can report.
std::vector<Alert> field_alerts() {
  FieldFacts facts;
  facts.config = std::make_shared<Config>();
  facts.sending_error = "no card";
  facts.now_s = 1000;
  facts.conflicts = {{3, "192.168.1.8", "192.168.1.7"}};
  facts.uncalibrated = {{4, "192.168.1.7"}};
  for (int i = 0; i < 3; ++i)
    facts.agreement.differences[static_cast<std::size_t>(i)] = {
        0, 1, 250, 250.0F + 500.0F * static_cast<float>(i), 7, 0, 100, 999};
  facts.agreement.difference_count = 3;
  facts.hang = Hang{0, "x", ""};
  HealthReport report;
  for (const auto why : {LeftOut::Why::kTime, LeftOut::Why::kTooMany}) {
    facts.images_off_time_lately = 5;
    facts.left_out.why = why;
    facts.left_out.camera = 2;
    facts.left_out.t_s = 995;
    report_field(facts, report);
  }
  return report.alerts;
}

TEST(FieldAlerts, InvalidOutputWithAnInvalidTimeRaisesNoAlert) {
  FieldFacts facts;
  facts.config = std::make_shared<Config>();
  facts.now_s = 1000;
  facts.left_out.why = LeftOut::Why::kTooMany;
  facts.left_out.camera = 2;
  for (const double t_s : {std::nan(""), HUGE_VAL, -HUGE_VAL, 995.0}) {
    facts.left_out.t_s = t_s;
    HealthReport report;
    report_field(facts, report);
    EXPECT_EQ(report.alerts.empty(), t_s != 995) << t_s;
  }
}

TEST_F(Alerts, AreOfTheKindsThatTheInterfaceNames) {
  AnyCamera& camera = input_.cameras[0];
  camera.health.state = CameraState::kLost;
  camera.health.warnings = {"Gain: 99"};
  camera.health.width = 640;
  camera.last_minute = {60, 3000, 300, 300, 300};
  camera.last_seconds = {10, 300, 0, 0, 0};
  camera.exposure = Exposure{0.5, 0.5, 10};
  camera.field_changed_since_calibrated = true;
  camera.min_margin = ColorFacts::Margin{0.2, "carpet becomes green at +20 %"};
  camera.missing_labels = {"orange"};
  camera.swapped_labels = {"green for pink"};
  camera.sends = false;
  camera.controls_unsaved = 2;
  camera.hang = Hang{};
  camera.running.missing = {"gone"};
  camera.newest_seconds = {3, 60, 160, 0, 0};
  camera.last_seconds.dropped = 400;
  input_.cameras[1].latency_p99_ms = 20;
  camera.stages = {
      {.name = "x", .mean_ms = 50, .left_out = {1, 0, 0}, .note = {StageNotes::Kind::kWarning, "no"}}};
  input_.cameras[1].origin = ImageOrigin::kSimulation;
  input_.cameras[1].last_seconds = {10, 300, 0, 0, 0};
  input_.cameras[1].calibration.reset();
  input_.teams.yellow.ids = {9};
  camera.grey_format = "mono8";
  input_.cards = {.sender = "eth1 (10.0.0.2)", .others = "eth0", .unused = "eth0", .without_link = "eth1"};
  input_.seen.field.lost = {{Team::kYellow, 7, 3, {0, 0}}};
  input_.seen.field.doubles = {{Team::kYellow, 8, {0, 1}, {Eigen::Vector2d(0, 0), Eigen::Vector2d(900, 0)}}};
  input_.seen.field.overlaps.push_back({{5, 6}, 40, 50});
  input_.seen.lines[0].verdict.worst_mm = 40;
  input_.seen.lines[1].verdict.missing_share = 0.8;
  input_.seen.lines[1].better_size = &field_presets().front();
  input_.seen.field.ball_gone_s = 5;
  input_.robots_allowed = {2, 9};
  input_.coverage = {true, 10, {{0, 0}, {1, 1}}, {{0, 0}, {1, 1}}, {1}};
  input_.listening_error = "no card";
  input_.referee.other = GameController{"other", "192.168.1.8"};
  input_.referee.team_names = {"Nobody knows us", ""};
  OtherVision same, other;
  same.address = "192.168.1.9";
  same.cameras = {0};
  same.field.emplace().set_field_length(1);
  other.address = "192.168.1.10";
  input_.other_visions = {same, other};
  input_.another_host_sends = true;
  input_.clock->synchronised = false;
  input_.computer.disk->free_bytes = 1;
  input_.computer.memory_available_bytes = 1;
  input_.settings_problem = "saved changes were set aside";
  input_.save_problem = "cannot write";
  input_.state_problem = "/state: Read-only file system";
  input_.reload_problem = "/etc/x.json: line 1";
  input_.lost_tables = {"no such table"};
  std::vector<Alert> all = alerts();
  input_.cards.heard_on = "eth0";
  for (Alert& alert : alerts()) all.push_back(std::move(alert));
  input_.network.error = "no card";
  input_.match_runs = true;
  input_.seen.field.team_gone_s = {};
  for (Alert& alert : alerts()) all.push_back(std::move(alert));
  for (Alert& alert : field_alerts()) all.push_back(std::move(alert));
  HealthReport left_out;
  report_left_out(std::vector<LeftOutLibrary>{{"/stages/x.so", "is not a shared object"}}, left_out);
  RecordingFacts recording;
  recording.refused = 100;
  report_recording(recording, left_out);
  EXPECT_EQ(left_out.alerts.size(), 1U) << "a few datagrams of others harm nothing";
  recording.refused = 101;
  recording.lost = 1;
  recording.refused = 1000;
  recording.cut = 101;
  recording.problem = "the disk is full";
  report_recording(recording, left_out);
  recording.problem.clear();
  recording.no_room_problem = "the quota is used up";
  recording.left_out = "192.0.2.1 stopped its log";
  report_recording(recording, left_out);
  LastSecondsFacts last_seconds;
  last_seconds.problem = "there is little memory";
  last_seconds.clip_problem = "the disk is full";
  last_seconds.crash = "The service crashed and was restarted";
  report_last_seconds(last_seconds, left_out);
  for (Alert& alert : left_out.alerts) all.push_back(std::move(alert));
  std::set<std::string> found;
  for (const Alert& alert : all) found.insert(alert.id);

  const Json file = Json::parse(std::ifstream(source_path("/docs/openapi.json")));
  EXPECT_EQ(found, file["components"]["schemas"]["AlertId"]["enum"].get<std::set<std::string>>());

  // The first column of the tables in docs/alerts.md names each alert.
  std::ifstream reference(source_path("/docs/alerts.md"));
  std::set<std::string> described;
  for (std::string line; std::getline(reference, line);) {
    const std::string cell = line.starts_with("| ") ? line.substr(2, line.find(" |", 2) - 2) : "";
    for (std::size_t from = 0; (from = cell.find('`', from)) != std::string::npos;) {
      const std::size_t to = cell.find('`', from + 1);
      described.insert(cell.substr(from + 1, to - from - 1));
      from = to + 1;
    }
  }
  EXPECT_EQ(found, described);

  // Each alert's page must exist: otherwise the panel shows no button.
  std::ifstream router(source_path("/webui/src/router.ts"));
  const std::string pages{std::istreambuf_iterator<char>(router), {}};
  for (const Alert& alert : all) {
    if (alert.page.empty()) continue;
    ASSERT_EQ(alert.page.substr(0, 2), "#/") << alert.id;
    const std::string page = alert.page.substr(2, alert.page.find('/', 2) - 2);
    if (page.empty()) continue;  // the first page
    EXPECT_THAT(pages, HasSubstr("{ name: '" + page + "'")) << alert.id;
  }
}

TEST_F(Alerts, NameTheCardOnWhichPacketsLeave) {
  input_.cards = {.sender = "cam0 (192.168.10.1)", .others = "fld0 (10.5.0.1)"};
  EXPECT_EQ(check("network").state, CheckState::kWarn);
  std::vector<Alert> all = alerts();
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].title, "No network card is chosen: packets leave on cam0 (192.168.10.1)");
  EXPECT_THAT(all[0].fix, HasSubstr("fld0 (10.5.0.1)"));

  input_.cards.heard_on = "fld0";
  input_.cards.heard = "10.5.0.9";
  all = alerts();
  ASSERT_EQ(all.size(), 1U) << "one alert for one cause";
  EXPECT_EQ(
      all[0].title,
      "Packets leave on network card cam0 (192.168.10.1), but the field's computer 10.5.0.9 is on fld0");

  input_.cards = {.sender = "fld0 (10.5.0.1)"};
  EXPECT_THAT(alerts(), IsEmpty());
  EXPECT_THAT(check("network").text, HasSubstr(" on fld0 (10.5.0.1)"));
}

TEST_F(Alerts, CountControlsThatAreNotSavedAndDoNotStopAMatch) {
  input_.cameras[1].controls_unsaved = 1;
  std::vector<Alert> all = alerts();
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].title, "Camera 1: 1 control is set and not saved");
  EXPECT_EQ(all[0].severity, Severity::kInfo);
  input_.cameras[1].controls_unsaved = 3;
  EXPECT_EQ(alerts().at(0).title, "Camera 1: 3 controls are set and not saved");
}

TEST_F(Alerts, APartSeenOnlyByALostCameraIsNotUncovered) {
  input_.coverage = {true, 10, {{0, 0}, {1, 1}}, {}, {}};
  for (const Alert& alert : alerts()) EXPECT_NE(alert.id, "field_uncovered");
  input_.coverage.out_of_reach_mm = {{0, 0}};
  const auto all = alerts();
  const auto named = std::ranges::find(all, "field_uncovered", &Alert::id);
  ASSERT_NE(named, all.end());
  EXPECT_THAT(named->title, HasSubstr("10 % of the field"));
}

TEST_F(Alerts, ComeWorstFirstEachWithItsPage) {
  input_.cameras[0].calibration.reset();
  input_.cameras[1].health.state = CameraState::kLost;
  input_.cameras[1].health.error = "no answer";
  const auto found = alerts();
  ASSERT_EQ(found.size(), 2u);
  const Json lost = to_json(found[0]), uncalibrated = to_json(found[1]);
  EXPECT_EQ(lost["id"], "camera_lost");
  EXPECT_EQ(lost["severity"], "bad");
  EXPECT_EQ(lost["title"], "Camera 1 is lost: no answer");
  EXPECT_EQ(lost["camera"], 1);
  EXPECT_EQ(lost["page"], "#/camera/1");
  EXPECT_EQ(uncalibrated["page"], "#/calibration/0");
}

TEST_F(Alerts, OfLostPicturesBeginAtOneInAThousand) {
  input_.cameras[0].last_minute.dropped = 3;
  EXPECT_THAT(kinds(), IsEmpty());
  input_.cameras[0].last_minute.dropped = 4;
  EXPECT_THAT(only_alert().title, HasSubstr("4 of 3604 images"));
  input_.cameras[0].last_minute = {5, 300, 3, 3, 0};  // it has just started
  EXPECT_THAT(kinds(), IsEmpty());
  input_.cameras[0].last_minute = {60, 3600, 0, 4, 0};
  EXPECT_EQ(only_alert().id, "frames_incomplete");
  input_.cameras[0].last_minute = {60, 3600, 0, 0, 1};
  EXPECT_EQ(only_alert().page, "#/colours/0");
}

TEST_F(Alerts, OfExposureBeginAboveTheShareOfPaintedLines) {
  input_.cameras[1].exposure = Exposure{0.02, 0, 90};
  EXPECT_THAT(kinds(), IsEmpty());
  input_.cameras[1].exposure->clipped_share = 0.021;
  EXPECT_EQ(only_alert().id, "picture_clipped");
  input_.cameras[1].exposure = Exposure{0, 0.3, 24};
  EXPECT_EQ(only_alert().id, "picture_dark");
  input_.cameras[1].exposure.reset();
  EXPECT_THAT(kinds(), IsEmpty());
}

TEST_F(Alerts, OfThinMarginsNameTheirSurfaceAndLabel) {
  input_.cameras[0].min_margin = ColorFacts::Margin{0.30, "carpet becomes green at +30 %"};
  input_.cameras[1].min_margin = ColorFacts::Margin{ColorFacts::Margin::kMax, ""};
  EXPECT_THAT(kinds(), IsEmpty());
  input_.cameras[1].min_margin = ColorFacts::Margin{0.29, "carpet becomes orange at \u221229 %"};
  const Alert thin = only_alert();
  EXPECT_EQ(thin.id, "margin_thin");
  EXPECT_EQ(thin.title, "Camera 1: carpet becomes orange at \u221229 %");
  EXPECT_EQ(thin.page, "#/colours/1");
  EXPECT_EQ(thin.severity, Severity::kWarn);
  input_.cameras[1].min_margin->share = 0.099;
  EXPECT_EQ(only_alert().severity, Severity::kBad);
}

TEST_F(Alerts, TellASlowCameraFromASlowComputer) {
  input_.cameras[0].last_seconds = {10, 530, 0, 0, 0};
  EXPECT_THAT(only_alert().title, AllOf(HasSubstr("53.0"), HasSubstr("instead of 60")));
  input_.cameras[0].last_seconds.dropped = 70;  // they arrived, but were not processed
  EXPECT_THAT(kinds(), IsEmpty());
  input_.cameras[0].last_seconds = {9, 100, 0, 0, 0};  // it has just started
  EXPECT_THAT(kinds(), IsEmpty());
  input_.cameras[0].newest_seconds = {3, 151, 0, 0, 0};  // a short break
  EXPECT_THAT(kinds(), IsEmpty());
  input_.cameras[0].newest_seconds = {3, 120, 0, 0, 0};
  EXPECT_THAT(only_alert().title, AllOf(HasSubstr("40.0"), HasSubstr("instead of 60")));
}

TEST_F(Alerts, NameTheSlowestStageWhereTheStagesTakeTooLong) {
  AnyCamera& camera = input_.cameras[0];
  camera.newest_seconds = {3, 72, 108, 0, 0};  // 24 of 60 images a second
  camera.last_seconds = {10, 240, 360, 0, 0};
  camera.stages = {{.name = "segment", .mean_ms = 1, .max_ms = 2},
                   {.name = "x", .mean_ms = 40.6, .max_ms = 50}};
  EXPECT_EQ(only_alert().id, "stage_slow");
  EXPECT_EQ(only_alert().title, "Camera 0: the stage 'x' takes 41 ms an image; images arrive every 17 ms");
  EXPECT_EQ(only_alert().severity, Severity::kBad);
  EXPECT_EQ(only_alert().camera, 0);
  camera.last_minute.dropped = 360;
  EXPECT_THAT(kinds(), ElementsAre("frames_dropped", "stage_slow"));
  EXPECT_EQ(alerts()[0].fix, "The stage 'x' takes 41 ms an image; images arrive every 17 ms.");
  camera.last_minute.dropped = 0;

  // Some drivers do not count images that are not fetched.
  camera.newest_seconds = {3, 72, 0, 0, 0};
  camera.last_seconds = {10, 240, 0, 0, 0};
  EXPECT_EQ(only_alert().id, "stage_slow") << "and not camera_slow";
  // If the stages are fast enough, it is the camera that sends too few.
  camera.stages[1].mean_ms = 5;
  EXPECT_EQ(only_alert().id, "camera_slow");

  // Two stages that are too slow together.
  camera.newest_seconds = {3, 150, 30, 0, 0};
  camera.last_seconds = {10, 500, 100, 0, 0};
  camera.stages = {{.name = "one", .mean_ms = 8, .max_ms = 9},
                   {.name = "other", .mean_ms = 12, .max_ms = 13}};
  EXPECT_EQ(
      only_alert().title,
      "Camera 0: the stage 'other' takes 12 ms an image, all stages together 20 ms; images arrive every "
      "17 ms");
  // This stage is slow for single images only.
  camera.stages = {{.name = "one", .library = "lib.so", .mean_ms = 3, .max_ms = 300}};
  EXPECT_EQ(only_alert().title,
            "Camera 0: the stage 'one' (lib.so) took up to 300 ms for an image; images arrive every 17 ms");
  EXPECT_EQ(only_alert().severity, Severity::kWarn);
  // Without lost images there is no alert. If images are lost although the stages are fast, the computer is
  // busy and no stage is to blame.
  camera.last_seconds = {10, 600, 0, 0, 0};
  EXPECT_THAT(kinds(), IsEmpty());
  camera.last_seconds = {10, 500, 100, 0, 0};
  camera.stages[0].max_ms = 20;
  EXPECT_THAT(kinds(), IsEmpty());
}

TEST_F(Alerts, NameTheStageThatMakesLatePackets) {
  input_.cameras[0].latency_p99_ms = 6;
  EXPECT_EQ(only_alert().id, "latency_high");
  EXPECT_EQ(only_alert().severity, Severity::kWarn);
  EXPECT_THAT(only_alert().fix, HasSubstr("Close other programs"));
  input_.cameras[0].stages = {{.name = "segment", .mean_ms = 1}, {.name = "x", .mean_ms = 4}};
  EXPECT_THAT(only_alert().fix, HasSubstr("the stage 'x', which takes 4.0 ms an image"));
  input_.cameras[0].latency_p99_ms = 18;
  EXPECT_EQ(only_alert().severity, Severity::kBad);
  EXPECT_EQ(check("latency").value, "18.00");
}

TEST_F(Alerts, OfInvalidOutputNameItsStageAndCounts) {
  input_.cameras[1].stages = {{.name = "x", .library = "lib.so", .left_out = {1, 2, 3}}};
  EXPECT_EQ(
      only_alert().title,
      "Camera 1: the stage 'x' (lib.so) gave invalid results: 1 robot, 2 balls, 3 times or kicks dropped in "
      "the last 10 s");
}

TEST_F(Alerts, OfTheClockOnlyWhereAnotherVisionsTimesAreComparedWithIt) {
  input_.clock->synchronised = false;
  EXPECT_THAT(kinds(), IsEmpty());
  OtherVision other;
  other.address = "192.168.1.9";
  input_.other_visions = {other};
  EXPECT_THAT(kinds(), ElementsAre("vision_other"));  // it runs on this computer
  input_.another_host_sends = true;
  EXPECT_THAT(kinds(), ElementsAre("clock_not_synchronised", "vision_other"));
  input_.clock.reset();
  EXPECT_THAT(kinds(), ElementsAre("vision_other"));
}

TEST_F(Alerts, SayThatAProgramSendsTheGeometryOnly) {
  OtherVision publisher;
  publisher.address = "10.0.0.3";
  input_.other_visions = {publisher};
  EXPECT_EQ(only_alert().title, "10.0.0.3 also sends other messages to the vision group");
  input_.other_visions[0].field.emplace();
  EXPECT_EQ(only_alert().title, "10.0.0.3 also sends a geometry to the vision group");
}

TEST_F(Alerts, SayWhichComputerIsHeardAndNotNamed) {
  OtherVision named, stranger;
  named.address = "10.0.0.2";
  named.is_named = true;
  stranger.address = "10.0.0.3";
  named.cameras = stranger.cameras = {7};
  input_.other_visions = {named};
  EXPECT_THAT(kinds(), IsEmpty());
  input_.other_visions = {named, stranger};
  EXPECT_THAT(kinds(), ElementsAre("vision_other"));
  EXPECT_EQ(only_alert().title,
            "10.0.0.3 also sends to the vision group; its cameras are shown, but not used for tracks");
  EXPECT_EQ(only_alert().fix,
            "If it is a computer of this field, add 10.0.0.3 to field/other_computers; otherwise stop it.");
}

TEST_F(Alerts, SayWhetherPacketsStillLeaveOneWay) {
  input_.network.error = "no subnet of this computer has the broadcast address 10.0.0.255";
  EXPECT_EQ(only_alert().title, "No packets are sent");
  input_.network.some_leave = true;
  EXPECT_EQ(only_alert().title, "Packets do not leave both ways");
  FieldFacts facts;
  facts.config = std::make_shared<Config>();
  facts.sending_error = input_.network.error;
  for (const char* title : {"No tracks are sent", "Tracks do not leave both ways"}) {
    HealthReport report;
    report_field(facts, report);
    ASSERT_EQ(report.alerts.size(), 1U);
    EXPECT_EQ(report.alerts[0].title, title);
    facts.some_leave = true;
  }
}

TEST_F(Alerts, OfManyStrangersAreOneOfEachKind) {
  for (int i = 0; i < 16; ++i) {
    OtherVision& stranger = input_.other_visions.emplace_back();
    stranger.address = "10.0.0." + std::to_string(i + 10);
    stranger.cameras = {i % 2 == 0 ? 0 : 7};
  }
  EXPECT_THAT(kinds(), testing::UnorderedElementsAre("vision_other", "vision_same_camera"));
  EXPECT_THAT(alerts().front().title, HasSubstr("10.0.0.10 (and 7 more)"));
  EXPECT_EQ(alerts().front().about, "") << "the same one, whoever comes and goes";
}

TEST_F(Alerts, OfADiskBeginAtHundredMegabytesOrTwoPercent) {
  auto& disk = *input_.computer.disk;
  disk.free_bytes = 1'900'000'000;
  EXPECT_EQ(only_alert().id, "disk_full");
  disk = {"/", 1'000'000'000, 99'000'000};
  EXPECT_EQ(only_alert().id, "disk_full");
  disk.free_bytes = 101'000'000;
  EXPECT_THAT(kinds(), IsEmpty());
}

TEST_F(Alerts, KeepTheTimeSinceWhenTheyHaveBeenThere) {
  AlertTimes times;
  input_.cameras[0].last_minute.dropped = 100;
  auto alerts = this->alerts();
  times.stamp(alerts, 1050, 50);
  EXPECT_EQ(alerts[0].since_s, 1050);
  input_.cameras[0].last_minute.dropped = 101;  // a different title
  input_.cameras[1].last_minute.dropped = 100;
  alerts = this->alerts();
  times.stamp(alerts, 1060, 60);
  EXPECT_EQ(alerts[0].since_s, 1050);
  EXPECT_EQ(alerts[1].since_s, 1060);
  times.stamp(alerts, 4670, 70);  // the clock was set forward by an hour meanwhile
  EXPECT_EQ(alerts[0].since_s, 4650) << "20 s ago, as it is";
  std::vector<Alert> none;
  times.stamp(none, 4675, 75);
  times.stamp(alerts, 4680, 80);
  EXPECT_EQ(alerts[0].since_s, 4680);
}

using Checks = Alerts;

TEST_F(Checks, AllPassWithFacts) {
  const auto checks = report_of(input_).checks;
  for (const Check& one : checks)
    EXPECT_EQ(one.state, one.id == "colors" ? CheckState::kUnknown : CheckState::kPass) << one.text;
  EXPECT_TRUE(is_go());
  const auto words = [&](const char* id) {
    const Check one = check(id);
    return one.value + " " + one.unit + ", " + one.text;
  };
  EXPECT_EQ(words("cameras"), "2 of 2, all are running");
  EXPECT_THAT(words("pictures"), HasSubstr("60.0 per second, none lost in 60 s"));
  EXPECT_EQ(words("calibration"), "2 of 2, all calibrated");
  EXPECT_EQ(words("network"), "122 packets/s, to 224.5.23.2:10006");
  EXPECT_EQ(words("referee"), "heard , from 192.168.1.7");
}

TEST_F(Checks, AreThoseThatTheInterfaceNames) {
  std::vector<std::string> names;
  for (const Check& one : report_of(input_).checks) names.push_back(to_json(one)["id"]);
  const Json file = Json::parse(std::ifstream(source_path("/docs/openapi.json")));
  EXPECT_EQ(Json(names), file["components"]["schemas"]["Check"]["properties"]["id"]["enum"]);
}

TEST_F(Checks, ALostCameraIsNoGo) {
  input_.cameras[1].health.state = CameraState::kLost;
  EXPECT_EQ(check("cameras").state, CheckState::kFail);
  EXPECT_THAT(check("cameras").text, HasSubstr("Camera 1 is lost"));
  EXPECT_FALSE(is_go());
}

TEST_F(Checks, NoCameraAtAllIsNoGo) {
  input_.cameras.clear();
  EXPECT_FALSE(is_go());
}

TEST_F(Checks, ACameraThatIsNotCalibratedIsNoGo) {
  input_.cameras[0].calibration.reset();
  input_.cameras[1].calibration.reset();
  const Check calibration = check("calibration");
  EXPECT_EQ(calibration.state, CheckState::kFail);
  EXPECT_EQ(calibration.text, "Camera 0 is not calibrated (and 1 more)");
  EXPECT_FALSE(is_go());
}

TEST_F(Checks, BeforeAHalfNoMoreRobotsThanMayPlayAreExpected) {
  input_.robots_allowed = {3, 3};  // 3 and 2 are seen
  EXPECT_THAT(kinds(), IsEmpty()) << "a team may play with fewer";
  input_.robots_allowed = {2, 2};
  EXPECT_EQ(only_alert().id, "robots_many");
  EXPECT_EQ(only_alert().title, "yellow: 3 robots are seen, the game controller allows 2");
  EXPECT_EQ(check("robots").state, CheckState::kWarn);
  EXPECT_TRUE(is_go());
  input_.half_is_next = false;
  EXPECT_THAT(kinds(), IsEmpty()) << "robots leave within seconds of a card, and after the match";
}

TEST_F(Checks, RobotsThatWaitBehindTheirGoalDoNotCount) {
  input_.robots_allowed = {2, 2};
  input_.seen.field.waiting = {{{1}, {}}};
  EXPECT_THAT(kinds(), IsEmpty());
  EXPECT_EQ(check("robots").value, "2 / 2");
  EXPECT_EQ(check("robots").text, "and a ball; 1 / 0 more wait behind their own goals; 2 / 2 may play");
  input_.robots_allowed = {2, 1};
  EXPECT_EQ(only_alert().title, "blue: 2 robots are seen, the game controller allows 1");
  input_.seen.field.waiting = {{{1}, {4}}};
  EXPECT_THAT(kinds(), IsEmpty());
}

TEST_F(Checks, DuringAMatchAnUnseenTeamIsNoPass) {
  input_.match_runs = true;
  input_.half_is_next = false;
  input_.seen.field.team_gone_s[1] = 2.5;
  EXPECT_THAT(kinds(), IsEmpty()) << "a moment";
  input_.seen.field.team_gone_s[1] = 3.5;
  EXPECT_EQ(only_alert().title, "No blue robot is seen while a match is played");
  EXPECT_EQ(check("robots").state, CheckState::kWarn);
  input_.robots_allowed = {3, 0};
  EXPECT_THAT(kinds(), IsEmpty()) << "they all have cards";
  input_.robots_allowed = {};
  input_.seen.field.team_gone_s[0].reset();
  EXPECT_EQ(only_alert().title, "No robot is seen while a match is played");
  EXPECT_FALSE(is_go());
  input_.robots_are_handled = true;
  EXPECT_THAT(kinds(), IsEmpty()) << "a timeout: they are at their teams";
  input_.robots_are_handled = false;
  input_.seen.watched_s = 3;
  EXPECT_THAT(kinds(), IsEmpty()) << "the service was just started";
  input_.seen.watched_s = 60;
  input_.match_runs = false;
  EXPECT_THAT(kinds(), IsEmpty());
  input_.seen.field.ids = {};
  EXPECT_EQ(check("robots").state, CheckState::kWarn);
}

TEST_F(Checks, ManyRobotsThatVanishAtOnceAreNoGo) {
  for (int id = 6; id < 10; ++id) input_.seen.field.lost.push_back({Team::kYellow, id, 3.0 * id, {0, 0}, 1});
  EXPECT_EQ(only_alert().severity, Severity::kWarn) << "one after the other";
  for (LostRobot& lost : input_.seen.field.lost) lost.at_once = 3;
  EXPECT_EQ(only_alert().severity, Severity::kBad);
  EXPECT_THAT(only_alert().fix, HasSubstr("after a minute"));
  input_.match_runs = true;
  EXPECT_THAT(only_alert().fix, HasSubstr("fewer than three are missing"));
  for (LostRobot& lost : input_.seen.field.lost) lost.was_handled = true;
  EXPECT_EQ(only_alert().severity, Severity::kWarn) << "people took them";
}

TEST_F(Checks, BeforeAMatchABallIsWanted) {
  input_.seen.field.ball = false;
  EXPECT_EQ(check("robots").state, CheckState::kWarn);
  EXPECT_THAT(check("robots").text, HasSubstr("no ball is seen"));
  EXPECT_TRUE(is_go());
  input_.seen.field.ball_gone_s = 2;
  EXPECT_EQ(check("robots").state, CheckState::kPass) << "hidden for a moment";
  input_.seen.field.ball_gone_s.reset();
  input_.match_runs = true;
  EXPECT_EQ(check("robots").state, CheckState::kPass) << "robots hide it";
}

TEST_F(Checks, ATeamsHeightIsKnownOnceTheSettingsNameTheTeam) {
  input_.referee.team_names = {"Nobody knows us", ""};
  EXPECT_EQ(only_alert().id, "team_unknown");
  input_.teams.yellow.name = "nobody knows US";
  EXPECT_THAT(kinds(), IsEmpty());
  EXPECT_EQ(check("teams").state, CheckState::kPass);
}

TEST_F(Checks, ACardWithoutLinkIsNoGo) {
  input_.cards.without_link = "eth0";
  EXPECT_EQ(only_alert().title, "Network card eth0 has no link: no packet reaches the teams");
  EXPECT_FALSE(is_go());
}

TEST_F(Checks, ImagesWithoutColoursAreNoGo) {
  input_.cameras[1].grey_format = "mono8";
  EXPECT_EQ(only_alert().title, "Camera 1 sends images without colours (mono8)");
  EXPECT_FALSE(is_go());
}

TEST_F(Checks, ABallThatVanishesWarns) {
  input_.seen.field.ball = false;
  input_.seen.field.ball_gone_s = 4;
  EXPECT_EQ(only_alert().id, "ball_lost");
  input_.match_runs = true;
  EXPECT_THAT(kinds(), IsEmpty()) << "robots hide it";
  input_.seen.field.ball_gone_s = 20;
  EXPECT_EQ(only_alert().id, "ball_lost");
}

TEST_F(Checks, LinesThatSuitTheOtherDivisionAreNoGo) {
  input_.seen.lines[1].better_size = &field_presets().front();
  EXPECT_EQ(only_alert().id, "field_size");
  EXPECT_EQ(only_alert().title,
            "Camera 1: the painted lines match Division A, 2026 (12 x 9 m), not the field's sizes (9 x 6 m)");
  EXPECT_FALSE(is_go());
}

TEST_F(Alerts, TellAMovedCameraOnce) {
  input_.seen.lines[1].verdict.worst_mm = 40;
  input_.seen.field.overlaps[0].apart_mm = 38;
  EXPECT_EQ(only_alert().id, "lines_off");
  EXPECT_EQ(only_alert().page, "#/calibration/1");
  input_.seen.field.overlaps[0].apart_mm = 70;
  EXPECT_THAT(kinds(), ElementsAre("cameras_disagree", "lines_off")) << "it is worse than its lines say";
  EXPECT_EQ(alerts()[0].page, "#/calibration/1") << "the camera that moved";
  input_.seen.lines[1].verdict.worst_mm = 1;
  EXPECT_EQ(only_alert().page, "#/calibration");
}

TEST_F(Checks, OfLatencyWaitForEnoughImages) {
  for (AnyCamera& camera : input_.cameras) camera.latency_p99_ms = 20;
  EXPECT_EQ(check("latency").state, CheckState::kFail);
  for (AnyCamera& camera : input_.cameras) camera.latency_images = 99;
  EXPECT_EQ(check("latency").text, "known after 100 images");
  EXPECT_EQ(check("latency").state, CheckState::kUnknown);
}

TEST_F(Checks, OfColoursAreTheLeastMarginOfAllCameras) {
  EXPECT_EQ(check("colors").state, CheckState::kUnknown);
  EXPECT_THAT(check("colors").text, HasSubstr("not known"));
  input_.cameras[0].min_margin = ColorFacts::Margin{ColorFacts::Margin::kMax, ""};
  EXPECT_EQ(check("colors").value, "> 150");
  EXPECT_EQ(check("colors").text, "the carpet stays clear");
  input_.cameras[1].min_margin = ColorFacts::Margin{0.45, "carpet becomes green at +45 %"};
  EXPECT_EQ(check("colors").value, "45");
  EXPECT_EQ(check("colors").text, "carpet becomes green at +45 %");
  input_.cameras[1].min_margin = ColorFacts::Margin{0.2, "carpet becomes green at +20 %"};
  EXPECT_EQ(check("colors").state, CheckState::kWarn);
  EXPECT_TRUE(is_go());
  input_.cameras[0].min_margin = ColorFacts::Margin{0.09, "carpet becomes blue at +9 %"};
  EXPECT_EQ(check("colors").state, CheckState::kFail);
  EXPECT_EQ(check("colors").value, "9");
  EXPECT_EQ(check("colors").text, "Camera 0: carpet becomes blue at +9 % (and 1 more)");
  EXPECT_FALSE(is_go());
}

TEST_F(Checks, AnAlertThatOnlyInformsPasses) {
  OtherVision other;
  other.address = "192.168.1.9";
  input_.other_visions = {other};
  EXPECT_EQ(check("other_visions").state, CheckState::kPass);
  EXPECT_EQ(check("other_visions").value, "1");
  EXPECT_EQ(check("other_visions").text, "with other cameras");
}

TEST_F(Checks, WarnWithoutAnAlertBeforeAMatch) {
  input_.referee.silent_s.reset();
  input_.clock.reset();
  EXPECT_THAT(kinds(), IsEmpty());
  for (const char* id : {"referee", "clock"}) EXPECT_EQ(check(id).state, CheckState::kWarn);
  input_.referee.silent_s = 12;
  EXPECT_EQ(check("referee").value, "12");
  EXPECT_EQ(check("referee").unit, "s silent");
}

}  // namespace
}  // namespace sslv::alerts_test
