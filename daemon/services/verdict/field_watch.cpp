// SPDX-License-Identifier: Apache-2.0
#include "services/verdict/field_watch.h"

#include "base/background.h"
#include "base/clock.h"
#include "capture/source.h"

#include <condition_variable>
#include <utility>

namespace sslv {
namespace {

/// A line that is farther off than this is not found.
constexpr double kWindowMm = 250;

/// Of two looks at the same lines: the better one. A single image may be spoilt, by a hand or a lamp that
/// goes on.
LinesNow better(const LinesNow& a, const LinesNow& b) {
  if (a.verdict.missing_share != b.verdict.missing_share)
    return a.verdict.missing_share < b.verdict.missing_share ? a : b;
  return a.verdict.worst_mm <= b.verdict.worst_mm ? a : b;
}

}  // namespace

FieldWatch::FieldWatch(Cameras& cameras, Pace pace)
    : cameras_(cameras), pace_(pace), started_s_(steady_s()), thread_([this](const std::stop_token& ending) {
        become_background_thread("verdict");
        serve(ending);
      }) {}

FieldWatch::Seen FieldWatch::seen() const {
  const double now_s = steady_s();
  const std::lock_guard lock(mutex_);
  return {sightings_.now(now_s), lines_, now_s - started_s_};
}

void FieldWatch::forget(const std::set<int>& camera_ids) {
  const std::lock_guard lock(mutex_);
  for (const int id : camera_ids) {
    sightings_.forget(id);
    lines_.erase(id);
  }
  to_forget_.insert(camera_ids.begin(), camera_ids.end());
}

void FieldWatch::serve(const std::stop_token& ending) {
  std::map<int, Watched> watched;
  std::mutex sleep;
  std::condition_variable_any never;
  while (!ending.stop_requested()) {
    {
      std::unique_lock lock(sleep);
      never.wait_for(lock, ending, pace_.between_looks, [] { return false; });
    }
    {
      const std::lock_guard lock(mutex_);
      for (const int id : std::exchange(to_forget_, {})) watched.erase(id);
    }
    for (const CameraNow& camera : cameras_.all()) {
      if (ending.stop_requested()) return;
      look_at(camera, watched[camera.id]);
    }
  }
}

void FieldWatch::look_at(const CameraNow& camera, Watched& watched) {
  try {
    const auto frame = cameras_.wait_frame(camera.id, watched.version, std::chrono::milliseconds(0));
    if (!frame) return;
    watched.version = frame->version;
    {
      const double now_s = steady_s();
      const std::lock_guard lock(mutex_);
      if (to_forget_.contains(camera.id)) return;
      sightings_.add(camera.id, now_s, frame->t_capture_s, frame->robots, frame->balls);
    }
    if (const auto now = Clock::now(); now >= watched.lines_due) {
      watched.lines_due = now + pace_.between_lines;
      look_at_lines(camera, *frame, watched);
    }
  } catch (const CaptureError&) {  // the camera is gone: so it will be from the next list
  }
}

void FieldWatch::look_at_lines(const CameraNow& camera, const LentFrame& frame, Watched& watched) {
  const std::shared_ptr<const Scene>& scene = camera.context().scene;
  if (watched.scene != scene) {
    watched.scene = scene;
    watched.curves = painted_curves(scene->field, LinesMeasured::kToOuterEdge);
    watched.before.reset();
  }
  std::optional<LinesNow> now;
  const ImageView& image = frame.image;
  if (scene->camera && image.width == scene->camera->calibration().pixel_image_width &&
      image.height == scene->camera->calibration().pixel_image_height) {
    const auto lines = check_lines(image, *scene->camera, watched.curves, kWindowMm);
    const LinesVerdict verdict = judge_lines(lines);
    if (verdict.lines > 0) {
      now = LinesNow{verdict, watched.curves[verdict.worst].name,
                     find_better_size(image, *scene->camera, scene->field, verdict, kWindowMm)};
    }
  }
  const std::optional<LinesNow> before = std::exchange(watched.before, now);
  const std::lock_guard lock(mutex_);
  if (to_forget_.contains(camera.id)) return;
  if (now && before) {
    lines_[camera.id] = better(*now, *before);
  } else {
    lines_.erase(camera.id);
  }
}

}  // namespace sslv
