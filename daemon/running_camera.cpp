// SPDX-License-Identifier: Apache-2.0
#include "running_camera.h"

#include "base/clock.h"
#include "base/params_json.h"
#include "cameras.h"

#include <algorithm>
#include <utility>

namespace sslv {
namespace {

template <class P>
bool same(const P& a, const P& b) {
  return params_to_json(a) == params_to_json(b);
}

const Json& controls_in(const Json& source) {
  static const Json kNone = Json::object();
  const auto found = source.find("controls");
  return found == source.end() ? kNone : *found;
}

Json without_controls(Json source) {
  source.erase("controls");
  return source;
}

}  // namespace

RunningCamera::RunningCamera(const CameraSettings& settings, CameraSetup setup, MulticastSender& multicast,
                             std::shared_ptr<CameraTotals> totals)
    : settings_(std::make_shared<Snapshot<CameraSettings>>(settings)),
      totals_(std::move(totals)),
      sink_(multicast, *totals_),
      pipeline_(static_cast<std::uint32_t>(settings.id), sink_, std::move(setup)) {
  start_thread();
}

RunningCamera::~RunningCamera() {
  thread_.reset();
  pipeline_.close();
}

void RunningCamera::ask_to_stop() {
  const std::lock_guard lock(thread_mutex_);
  if (thread_) thread_->ask_to_stop();
}

void RunningCamera::start_thread() {
  const auto settings = settings_->load();
  const Scene scene = *pipeline_.setup()->world.scene;
  auto open = [in_force = settings_, scene] {
    const auto now = in_force->load();
    return open_source(now->source, {static_cast<std::uint32_t>(now->id), scene});
  };
  auto on_image = [this](CapturedImage&& captured) {
    pipeline_.process(std::move(captured.image), captured.times, captured.whole);
    totals_->frames.fetch_add(1, std::memory_order_relaxed);
  };
  auto thread = std::make_unique<CameraThread>("camera " + std::to_string(settings->id), settings->thread,
                                               std::move(open), std::move(on_image), RetryDelays{},
                                               std::shared_ptr<CaptureTotals>(totals_, &totals_->capture),
                                               [this] { return pipeline_.give_back(); });
  const std::lock_guard lock(thread_mutex_);
  std::unique_ptr<CameraThread> ended = std::exchange(thread_, std::move(thread));
  thread_->start(std::move(ended));
}

ControlChange RunningCamera::change_controls(const CameraSettings& settings, const std::string& path) const {
  const auto old = settings_->load();
  const auto open = controls();
  if (!open || without_controls(old->source) != without_controls(settings.source)) return {};
  return {open, controls_in(old->source), controls_in(settings.source), path};
}

bool RunningCamera::change(const CameraSettings& settings, CameraSetup setup, ControlChange& controls) {
  const auto old = settings_->load();
  settings_->store(settings);
  pipeline_.change(std::move(setup));
  controls.keep();
  const bool same_source = without_controls(old->source) == without_controls(settings.source);
  if (same_source && same(old->thread, settings.thread) && !controls.needs_opening()) return false;
  start_thread();
  return true;
}

void RunningCamera::change_robot_heights(const std::array<double, 2>& robot_height_mm) {
  const auto setup = pipeline_.setup();
  if (setup->world.scene->robot_height_mm == robot_height_mm) return;
  pipeline_.change(with_robot_heights(*setup, robot_height_mm));
}

bool RunningCamera::change_light(const std::shared_ptr<const Lut>& accepted,
                                 std::shared_ptr<const Lut> in_todays_light) {
  CameraSetup setup = *pipeline_.setup();
  if (setup.world.accepted_lut != accepted) return false;
  setup.world.lut = std::move(in_todays_light);
  pipeline_.change(std::move(setup));
  return true;
}

CameraHealth RunningCamera::health() const {
  CameraHealth health;
  {
    const std::lock_guard lock(thread_mutex_);
    if (thread_) health = thread_->health();
  }
  health.incomplete = totals_->capture.incomplete.load(std::memory_order_relaxed);
  health.dropped = totals_->capture.dropped.load(std::memory_order_relaxed);
  health.reconnects = totals_->capture.reconnects.load(std::memory_order_relaxed);
  return health;
}

std::shared_ptr<Controls> RunningCamera::controls() const {
  const std::lock_guard lock(thread_mutex_);
  return thread_ ? thread_->controls() : nullptr;
}

void RunningCamera::Sink::publish(const FrameInfo& info, const RobotList& robots,
                                  const BallList& balls) noexcept {
  const double t_sent_s = sender.send(info, robots, balls);
  latency.add_ns(steady_ns() - info.times.arrived_ns);
  const auto age_ns = static_cast<std::int64_t>((t_sent_s - info.times.t_capture_s) * 1e9);
  age.add_ns(age_ns);
  totals.capture_to_send.add_ns(age_ns);
  const auto yellow = static_cast<std::uint64_t>(
      std::ranges::count(robots.robots, Team::kYellow, [](const Robot& robot) { return robot.team; }));
  totals.robots_yellow.fetch_add(yellow, std::memory_order_relaxed);
  totals.robots_blue.fetch_add(robots.robots.size() - yellow, std::memory_order_relaxed);
  totals.balls.fetch_add(balls.balls.size(), std::memory_order_relaxed);
}

namespace {

/// Then colour classes and tables mean the same.
bool same_names(const LabelSet& a, const LabelSet& b) {
  return std::ranges::equal(a.all(), b.all(), [](const LabelInfo& one, const LabelInfo& other) {
    return one.value == other.value && one.name == other.name;
  });
}

}  // namespace

CameraSetup make_setup(const Config& config, std::size_t i, const CameraSettings* previous_settings,
                       const CameraSetup* previous, const LoadTable& load_table) {
  const CameraSettings& camera = config.cameras[i];
  const std::string path = "/cameras/" + std::to_string(i);
  CameraSetup setup;
  if (previous && previous->pipeline->stack() == camera.stack) {
    setup.pipeline = previous->pipeline;
  } else {
    setup.pipeline = std::make_shared<Pipeline>(stage_table(), camera.stack, path + "/stack");
  }
  setup.parameters = setup.pipeline->make_parameters(camera.stages, path + "/stages");
  const bool same_colors = previous && same(previous_settings->colors, camera.colors) &&
                           same_names(*previous->world.labels, LabelSet(config.own_labels, "/own_labels"));
  setup.world = make_world(config, i, same_colors ? previous->world.accepted_lut : nullptr, load_table);
  if (same_colors) setup.world.lut = previous->world.lut;
  return setup;
}

CameraSetup with_robot_heights(CameraSetup setup, const std::array<double, 2>& robot_height_mm) {
  Scene scene = *setup.world.scene;
  scene.robot_height_mm = robot_height_mm;
  setup.world.scene = std::make_shared<const Scene>(std::move(scene));
  return setup;
}

}  // namespace sslv
