// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/running_camera.h"

#include "base/clock.h"
#include "base/log.h"
#include "base/params_json.h"
#include "config/backends.h"

#include <algorithm>
#include <exception>
#include <utility>

namespace sslv {
namespace {

const Json& controls_in(const Json& source) {
  static const Json kNone = Json::object();
  const auto found = source.find("controls");
  return found == source.end() ? kNone : *found;
}

Json without_controls(Json source) {
  source.erase("controls");
  return source;
}

/// Identifies a camera.
Json camera_of(const Json& source) {
  const Json& camera = camera_source(source);
  return {{"backend", camera.at("backend")}, {"camera", camera.value("camera", "")}};
}

CameraSetup noted(RecordedCamera& recorded, CameraSetup setup, std::shared_ptr<const Config> config) {
  recorded.note(setup, std::move(config));
  return setup;
}

}  // namespace

std::uint64_t RunningCamera::LastOpened::begin() {
  const std::lock_guard lock(mutex);
  return ++begun;
}

void RunningCamera::LastOpened::hand_over(std::uint64_t number, const Json& source,
                                          const Json& settings_of_controls,
                                          const std::shared_ptr<Controls>& opened) {
  const std::lock_guard lock(mutex);
  if (number < handed_over) return;
  handed_over = number;
  const bool is_same = std::exchange(camera, camera_of(source)) == camera_of(source);
  auto before = std::exchange(controls, opened);
  settings = settings_of_controls;
  if (!opened) return;
  try {
    opened->queue().begin(is_same ? std::move(before) : nullptr);
  } catch (const std::exception& error) {
    log::warning("camera controls: unsaved values are dropped: {}", error.what());
  }
}

std::function<ControlQueue::Refusals()> RunningCamera::LastOpened::follow(
    const Snapshot<CameraSettings>& newest) {
  const std::lock_guard lock(mutex);
  const Json wanted = controls_in(newest.load()->source);
  if (!controls || settings == wanted) return {};
  return controls->queue().apply(std::exchange(settings, wanted), wanted);
}

RunningCamera::RunningCamera(const CameraSettings& settings, CameraSetup setup,
                             std::shared_ptr<const Config> config, MulticastSender& multicast,
                             std::shared_ptr<SightingsQueue> field, std::shared_ptr<CameraTotals> totals)
    : settings_(std::make_shared<Snapshot<CameraSettings>>(settings)),
      last_opened_(std::make_shared<LastOpened>()),
      totals_(std::move(totals)),
      sink_(multicast, std::move(field), *totals_),
      pipeline_(static_cast<std::uint32_t>(settings.id), sink_, noted(*recorded_, std::move(setup), config),
                recorded_.get()),
      thread_(make_thread(settings, *pipeline_.setup()->context.scene)) {}

RunningCamera::~RunningCamera() {
  thread_.reset();
  pipeline_.close();
}

void RunningCamera::start() noexcept {
  const std::lock_guard lock(thread_mutex_);
  thread_->start();
}

void RunningCamera::ask_to_stop() {
  const std::lock_guard lock(thread_mutex_);
  thread_->ask_to_stop();
}

void RunningCamera::end_control_calls() {
  const std::lock_guard lock(last_opened_->mutex);
  if (last_opened_->controls) last_opened_->controls->queue().ask_to_stop();
}

bool RunningCamera::has_stopped() {
  const std::lock_guard lock(thread_mutex_);
  return thread_->try_stop();
}

std::unique_ptr<CameraThread> RunningCamera::make_thread(const CameraSettings& settings, const Scene& scene,
                                                         ControlValues controls) {
  auto open = [newest = settings_, last = last_opened_, scene, unsaid = std::move(controls)]() mutable {
    const std::uint64_t number = last->begin();
    const auto now = newest->load();
    Json source = now->source;
    for (const auto& [name, value] : unsaid) {
      if (!source["controls"].contains(name)) source["controls"][name] = value;
    }
    auto camera = open_source(source, {static_cast<std::uint32_t>(now->id), scene});
    unsaid.clear();  // used once: values that are set later must survive a reopening
    last->hand_over(number, source, controls_in(now->source), camera->controls());
    last->follow(*newest);  // applies changes of settings made during the opening
    return camera;
  };
  auto on_image = [this](CapturedImage&& captured) {
    pipeline_.process(std::move(captured.image), captured.times, captured.whole);
    totals_->frames.fetch_add(1, std::memory_order_relaxed);
  };
  return std::make_unique<CameraThread>("camera " + std::to_string(settings.id), settings.thread,
                                        std::move(open), std::move(on_image), CameraDelays{},
                                        std::shared_ptr<CaptureTotals>(totals_, &totals_->capture),
                                        [this] { return pipeline_.give_back(); });
}

RunningCamera::Change RunningCamera::plan(const CameraSettings& settings,
                                          std::shared_ptr<const Config> config, std::optional<NewSetup> setup,
                                          std::string path) const {
  const auto old = settings_->load();
  Change out{std::make_shared<const CameraSettings>(settings), std::move(config), std::move(setup),
             std::move(path)};
  out.reopens = without_controls(old->source) != without_controls(settings.source) ||
                params_to_json(old->thread) != params_to_json(settings.thread);
  if (const auto open = controls(); open && !out.reopens) {
    out.controls = open->queue().plan(controls_in(old->source), controls_in(settings.source), out.path);
    out.reopens = out.controls.reopens;
  }
  return out;
}

void RunningCamera::get_ready(Change& change) {
  if (change.setup) change.setup->make_stages(*change.settings);
  if (!change.reopens) return;
  const auto now = pipeline_.setup();
  const CameraSetup& setup = change.setup ? change.setup->setup : *now;
  change.thread = make_thread(*change.settings, *setup.context.scene, change.controls.unsaid);
}

bool RunningCamera::apply(Change& change, const std::array<double, 2>& robot_height_mm) noexcept {
  settings_->store(std::move(change.settings));
  if (change.setup) {
    CameraSetup& setup = change.setup->setup;
    if (change.setup->keeps_colors) {
      // Keep adaptations to the light made while the change was planned and saved.
      const auto before = pipeline_.setup();
      setup.context.adapted_lut = before->context.adapted_lut;
      setup.context.accepted_lut = before->context.accepted_lut;
    }
    use(with_robot_heights(std::move(setup), robot_height_mm), std::move(change.config));
  }
  if (!change.thread) {
    change.control_outcome = last_opened_->follow(*settings_);
    return false;
  }
  ++reopenings_;
  reopened_s_ = steady_s();
  const std::lock_guard lock(thread_mutex_);
  // Only one thread at a time may feed the pipeline, so the new thread waits until the old thread ends. This
  // call does not wait.
  change.thread->start(std::move(thread_));
  thread_ = std::move(change.thread);
  return true;
}

std::vector<std::string> RunningCamera::outcome(const Change& change) const {
  std::vector<std::string> out;
  if (!change.control_outcome) return out;
  try {
    for (const std::string& refusal : change.control_outcome()) out.push_back(change.path + '/' + refusal);
  } catch (const std::exception& error) {
    if (controls()) out.push_back(change.path + ": not set yet: " + error.what());
  }
  return out;
}

void RunningCamera::use(CameraSetup setup, std::shared_ptr<const Config> config) {
  pipeline_.change(noted(*recorded_, std::move(setup), std::move(config)));
}

void RunningCamera::change_robot_heights(const std::array<double, 2>& robot_height_mm) {
  const auto setup = pipeline_.setup();
  if (setup->context.scene->robot_height_mm == robot_height_mm) return;
  use(with_robot_heights(*setup, robot_height_mm));
}

bool RunningCamera::change_light(const std::shared_ptr<const Lut>& accepted,
                                 std::shared_ptr<const Lut> adapted) {
  CameraSetup setup = *pipeline_.setup();
  if (setup.context.accepted_lut != accepted) return false;
  setup.context.adapted_lut = std::move(adapted);
  use(std::move(setup));
  return true;
}

CameraState RunningCamera::try_now() const {
  const std::lock_guard lock(thread_mutex_);
  return thread_->try_now();
}

CameraHealth RunningCamera::health() const {
  CameraHealth health;
  {
    const std::lock_guard lock(thread_mutex_);
    health = thread_->health();
  }
  health.incomplete = totals_->capture.incomplete.load(std::memory_order_relaxed);
  health.dropped = totals_->capture.dropped.load(std::memory_order_relaxed);
  health.reconnects = totals_->capture.reconnects.load(std::memory_order_relaxed);
  if (const auto open = controls()) {
    for (std::string& refusal : open->queue().refused()) health.warnings.push_back(std::move(refusal));
  }
  return health;
}

CameraProgress RunningCamera::progress() const {
  CameraProgress out{settings()->id, health()};
  if (const auto mark = sink_.mark.read()) out.stage = hang_of(stage_table(), *mark);
  return out;
}

std::shared_ptr<Controls> RunningCamera::controls() const {
  const std::lock_guard lock(thread_mutex_);
  return thread_->controls();
}

std::vector<UnsavedControl> RunningCamera::unsaved_controls() const {
  const auto open = controls();
  return open ? open->queue().unsaved(saved_controls()) : std::vector<UnsavedControl>{};
}

Json RunningCamera::saved_controls() const {
  return controls_in(settings()->source);
}

void RunningCamera::Sink::publish(const FrameInfo& info, const Scene& scene, const RobotList& robots,
                                  const BallList& balls) noexcept {
  const double t_sent_s = sender.send(info, robots, balls);
  latency.add_ns(steady_ns() - info.times.arrived_ns);
  field->hand_over(info, scene, robots, balls);
  const auto age_ns = static_cast<std::int64_t>((t_sent_s - info.times.t_capture_s) * 1e9);
  age.add_ns(age_ns);
  totals.capture_to_send.add_ns(age_ns);
  const auto yellow = static_cast<std::uint64_t>(
      std::ranges::count(robots.robots, Team::kYellow, [](const Robot& robot) { return robot.team; }));
  totals.robots_yellow.fetch_add(yellow, std::memory_order_relaxed);
  totals.robots_blue.fetch_add(robots.robots.size() - yellow, std::memory_order_relaxed);
  totals.balls.fetch_add(balls.balls.size(), std::memory_order_relaxed);
}

}  // namespace sslv
