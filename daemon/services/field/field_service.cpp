// SPDX-License-Identifier: Apache-2.0
#include "services/field/field_service.h"

#include "base/clock.h"
#include "base/log.h"
#include "config/stages.h"
#include "health/metrics_text.h"
#include "services/field/field_report.h"
#include "tracking/tracks_json.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <glib.h>

namespace sslv {
namespace {

constexpr std::size_t kMaxKicks = 100;

/// The game controller recognises the source by this uuid. Backups exclude it: a spare computer is another
/// source.
std::string stable_uuid(StateFolder& folder) {
  const std::filesystem::path file = folder.path() / "tracker-uuid";
  std::string uuid;
  std::ifstream(file) >> uuid;
  if (g_uuid_string_is_valid(uuid.c_str()) != 0) return uuid;
  gchar* made = g_uuid_string_random();
  uuid = made;
  g_free(made);
  try {
    folder.write(file, uuid + "\n");
  } catch (const StorageError& error) {
    log::warning("the tracks' source will have another uuid after the next start: {}", error.what());
  }
  return uuid;
}

/// Tracks use the network card of the detections.
MulticastSettings multicast_of(const NetworkSettings& network) {
  MulticastSettings out = network.vision;
  out.group = network.tracker.group;
  out.port = network.tracker.port;
  if (out.broadcast == out.group) out.broadcast.clear();
  return out;
}

std::set<int> ids_of(const Config& config) {
  std::set<int> ids;
  for (const CameraSettings& camera : config.cameras) ids.insert(camera.id);
  return ids;
}

/// Every image updates the tracks. If no image arrives or no stage tracks, the visibility of the last tracks
/// drops to 0, and then they are removed.
void fade(TrackedField& tracked, double age_s) {
  constexpr double kFresh_s = 0.2, kGone_s = 0.7;
  const double share = 1 - std::clamp((age_s - kFresh_s) / (kGone_s - kFresh_s), 0.0, 1.0);
  for (TrackedRobot& robot : tracked.robots) robot.visibility *= share;
  for (TrackedBall& ball : tracked.balls) ball.visibility *= share;
  if (share > 0) return;
  tracked.robots.clear();
  tracked.balls.clear();
}

}  // namespace

FieldService::FieldService(const Snapshot<Config>& config, FieldIntake& intake, SettingsEditor& settings,
                           StateFolder& folder, TracksForLog& for_log)
    : config_(config),
      intake_(intake),
      settings_(settings),
      uuid_(stable_uuid(folder)),
      sender_(multicast_of(config.load()->network), "/network/tracker"),
      heard_queue_(intake.add()),
      running_(intake, sender_, for_log, ball_, make_setup(*config.load())) {}

FieldSetup FieldService::make_setup(const Config& config, std::shared_ptr<FieldPipeline> before) const {
  FieldSetup setup;
  setup.pipeline = std::move(before);
  if (!setup.pipeline || setup.pipeline->stack() != config.field.running.stages) {
    setup.pipeline =
        std::make_shared<FieldPipeline>(field_stage_table(), config.field.running.stages, "/field/stack");
  }
  setup.parameters = setup.pipeline->parameters_of(config.field.stage_params);
  setup.field = config.field;
  setup.ball = ball_model_of(config);
  setup.source = {uuid_, config.network.tracker.source_name};
  setup.sends = config.network.tracker.enabled;
  return setup;
}

Plan FieldService::plan(const SettingsChange& change) const {
  const auto setup = std::make_shared<FieldSetup>();
  const auto config = std::make_shared<const Config>(change.next);
  return {.get_ready =
              [this, setup, config] {
                // If the stack is unchanged, keep the pipeline, because its stages have learnt state.
                *setup = make_setup(*config, running_.setup()->pipeline);
              },
          .apply =
              [&self = later(*this), setup, config]() noexcept {
                self.sender_.configure(multicast_of(config->network), "/network/tracker");
                {
                  const std::lock_guard lock(self.heard_mutex_);
                  self.heard_cameras_.set_own(ids_of(*config));
                }
                self.running_.change(std::move(*setup));
              }};
}

void FieldService::hear(const VisionMessage& message, const std::string& address, bool is_named,
                        double now_s) {
  const std::lock_guard lock(heard_mutex_);
  if (heard_cameras_.hear(message, address, is_named, now_s, unix_time_s(), heard_))
    heard_queue_->hand_over(heard_);
}

void FieldService::each_second() {
  intake_.drop_unused();
  take_kicks();
  look_at_stages();
  {
    const AgreementNow agreement = running_.agreement();
    // The agreement is updated only while images arrive.
    constexpr double kFresh_s = 5;
    const double now_s = unix_time_s();
    const bool is_fresh = std::abs(now_s - agreement.t_s) < kFresh_s;
    const auto pairs = is_fresh ? pairs_of(agreement) : std::vector<CameraPairNow>{};
    const std::lock_guard lock(history_mutex_);
    history_.add(pairs, now_s);
  }
  ball_.learn(ball_model_of(*config_.load()));
}

void FieldService::look_at_stages() {
  {
    const std::lock_guard lock(stages_mutex_);
    stage_watch_.look(running_.setup()->pipeline);
    loads_.push_back({running_.frames(), intake_.lost(), running_.left_out().images_off_time, steady_s()});
    if (loads_.size() > StageWatch::kSeconds + 1) loads_.pop_front();
  }
  const auto hung = hang();
  if (hung.has_value() == was_hanging_) return;
  was_hanging_ = hung.has_value();
  if (hung) {
    log::error("the field's thread has hung for {} s{}: there are no tracks until the service is restarted",
               (steady_ns() - hung->since_ns) / 1'000'000'000, place_text(*hung));
  } else {
    log::info("the field's thread continues");
  }
}

std::uint64_t FieldService::images_off_time_lately() const {
  const std::uint64_t now = running_.left_out().images_off_time;
  const std::lock_guard lock(stages_mutex_);
  if (loads_.empty()) return now;
  constexpr std::size_t kSeconds = 10;
  return now - loads_[loads_.size() - std::min(kSeconds, loads_.size())].images_off_time;
}

StackFacts FieldService::stack_facts() const {
  const std::lock_guard lock(stages_mutex_);
  StackFacts out{.camera = std::nullopt, .check = "latency", .stages = stage_watch_.figures()};
  const auto setup = running_.setup();
  for (std::size_t i = 0; i < std::min(out.stages.size(), setup->pipeline->stack().size()); ++i)
    out.stages[i].note = setup->pipeline->note(i);
  if (loads_.size() < 2) return out;
  const Load& now = loads_.back();
  const Load& before = loads_[loads_.size() - 1 - std::min(StageWatch::kNewestSeconds, loads_.size() - 1)];
  const double passed_s = now.steady_s - before.steady_s;
  out.processed_per_s = static_cast<double>(now.frames - before.frames) / passed_s;
  out.come_per_s = out.processed_per_s + static_cast<double>(now.lost - before.lost) / passed_s;
  out.loses = now.lost > loads_.front().lost;
  return out;
}

std::optional<Hang> FieldService::hang() const {
  const auto mark = running_.stage_now();
  if (!mark || steady_ns() - mark->since_ns < kHangs_ns) return std::nullopt;
  return hang_of(field_stage_table(), *mark);
}

void FieldService::take_kicks() {
  const std::vector<TrackedKick> newest = kicks_of(running_.now());
  const std::lock_guard lock(kicks_mutex_);
  for (const TrackedKick& kick : newest) {
    const auto known = std::find_if(kicks_.begin(), kicks_.end(), [&](const TrackedKick& one) {
      // Numbers restart at 1 with another stack, or after the clock was set.
      return one.number == kick.number && std::abs(one.t_s - kick.t_s) < 1;
    });
    if (known != kicks_.end()) {
      *known = kick;  // a better estimate
    } else {
      kicks_.push_back(kick);
    }
  }
  while (kicks_.size() > kMaxKicks) kicks_.pop_front();
}

Json FieldService::topic_data() {
  TrackedField tracked = tracked_of(running_.now());
  fade(tracked, std::abs(unix_time_s() - tracked.t_s));
  return to_json(tracked);
}

Json FieldService::field_json() {
  Json out = topic_data();
  const auto setup = running_.setup();
  const auto latency = running_.latency().percentiles();
  const MulticastStatus sent = sender_.status();
  out["source"] = {{"uuid", uuid_}, {"name", setup->source.name}};
  out["sends"] = setup->sends;
  out["packets_sent"] = sent.packets_sent;
  out["frames"] = running_.frames();
  out["latency_p50_us"] = latency.p50_us;
  out["latency_p99_us"] = latency.p99_us;
  out["stages"] = stages_json(*setup->pipeline);
  out["other_cameras"] = Json::array();
  const std::lock_guard lock(heard_mutex_);
  for (const auto& [id, heard] : heard_cameras_.cameras(steady_s())) {
    out["other_cameras"].push_back(
        {{"camera", id},
         {"address", heard.address},
         {"is_used", heard.is_used},
         {"robots", heard.robots},
         {"balls", heard.balls},
         {"clock_correction_ms", std::round(heard.clock_correction_s * 1e4) / 10}});
  }
  return out;
}

Json FieldService::kicks_json() {
  take_kicks();
  Json out = Json::array();
  const std::lock_guard lock(kicks_mutex_);
  for (auto kick = kicks_.rbegin(); kick != kicks_.rend(); ++kick) out.push_back(to_json(*kick));
  return {{"kicks", std::move(out)}};
}

Json FieldService::agreement_json() const {
  Json out = to_json(running_.agreement());
  const std::lock_guard lock(history_mutex_);
  out["trends"] = history_.to_json();
  return out;
}

std::vector<Route> FieldService::routes() {
  return {{"GET", "/api/field", [this](const Request&) { return json_response(field_json()); }},
          {"GET", "/api/field/agreement", [this](const Request&) { return json_response(agreement_json()); }},
          {"GET", "/api/field/kicks", [this](const Request&) { return json_response(kicks_json()); }},
          {"GET", "/api/field/ball_model",
           [this](const Request&) { return json_response(ball_.to_json(config_.load()->ball_models)); }},
          {"POST", "/api/field/ball_model/accept", [this](const Request& request) {
             ball_.accept(settings_, request.address);
             return json_response(ball_.to_json(config_.load()->ball_models));
           }}};
}

void FieldService::report(HealthReport& report) const {
  const MulticastStatus sent = sender_.status();
  const std::lock_guard history_lock(history_mutex_);
  FieldFacts facts{.config = config_.load(),
                   .agreement = running_.agreement(),
                   .history = &history_,
                   .left_out = running_.left_out(),
                   .images_off_time_lately = images_off_time_lately(),
                   .now_s = unix_time_s(),
                   .sending_error = running_.setup()->sends ? sent.error : "",
                   .some_leave = sent.some_leave,
                   .conflicts = {},
                   .stack = stack_facts(),
                   .hang = hang(),
                   .now_ns = steady_ns()};
  {
    const std::lock_guard lock(heard_mutex_);
    facts.conflicts = heard_cameras_.conflicts(steady_s());
    facts.uncalibrated = heard_cameras_.uncalibrated(steady_s());
  }
  report_field(facts, report);
  if (!report.status) return;
  (*report.status)["tracks"] = {{"stages", stages_json(*running_.setup()->pipeline)},
                                {"hangs", to_json(facts.hang, facts.now_s, facts.now_ns)}};
}

void FieldService::add_diagnostics(Json& diagnostics) const {
  const LeftOut left_out = running_.left_out();
  diagnostics["field"] = {{"frames", running_.frames()},
                          {"lost", intake_.lost()},
                          {"images_off_time", left_out.images_off_time},
                          {"images_of_too_many", left_out.images_of_too_many},
                          {"sightings_left_out", left_out.sightings},
                          {"filters_repaired", running_.repaired()}};
}

void FieldService::write_metrics(MetricsText& out) const {
  out.begin("sslv_field_frames_total", "counter", "Images of all cameras that went into the field's tracks.");
  out.add({}, running_.frames());
  out.begin("sslv_field_lost_total", "counter", "Images that the field's stack did not process in time.");
  out.add({}, intake_.lost());
  const LeftOut left_out = running_.left_out();
  out.begin("sslv_field_left_out_total", "counter", "Invalid data that the field dropped.");
  out.add({{"what", "image_off_time"}}, left_out.images_off_time);
  out.add({{"what", "image_of_too_many_cameras"}}, left_out.images_of_too_many);
  out.add({{"what", "sighting"}}, left_out.sightings);
  out.begin("sslv_field_filters_repaired_total", "counter",
            "Filters of tracks and of the cameras' agreement that were not finite and were reset.");
  out.add({}, running_.repaired());
  out.begin("sslv_field_latency_seconds", "histogram",
            "From the arrival of a camera's detections to the sending of tracks.");
  out.add({}, running_.latency_total().read());
  out.begin("sslv_field_stage_duration_seconds", "histogram",
            "Time that a stage of the field's stack takes.");
  for (std::size_t i = 0; i < running_.stage_totals().size(); ++i)
    out.add({{"stage", field_stage_table()[i].name}}, running_.stage_totals()[i].read());
  out.begin("sslv_field_senseless_total", "counter",
            "Invalid results of a stage of the field's stack that were dropped.");
  for (std::size_t i = 0; i < running_.invalid().size(); ++i) {
    const std::string& stage = field_stage_table()[i].name;
    const InvalidCounts invalid = running_.invalid()[i].read();
    out.add({{"stage", stage}, {"what", "robot"}}, invalid.robots);
    out.add({{"stage", stage}, {"what", "ball"}}, invalid.balls);
    out.add({{"stage", stage}, {"what", "time_or_kick"}}, invalid.others);
  }
  out.begin("sslv_tracker_packets_sent_total", "counter", "Packets of tracks sent.");
  out.add({}, sender_.status().packets_sent);
}

}  // namespace sslv
