// SPDX-License-Identifier: Apache-2.0
#include "services/verdict/field_watch.h"

#include "base/background.h"
#include "base/clock.h"
#include "capture/source.h"

#include <condition_variable>
#include <utility>

namespace sslv {
namespace {

/// Lines farther from their expected position are not found.
constexpr double kWindowMm = 250;

/// Returns the better of two checks of the same lines.
LinesNow better(const LinesNow& a, const LinesNow& b) {
  if (a.verdict.missing_share != b.verdict.missing_share)
    return a.verdict.missing_share < b.verdict.missing_share ? a : b;
  return a.verdict.worst_mm <= b.verdict.worst_mm ? a : b;
}

/// Returns nothing if no line can be judged. It is unknown whether the field's sizes were measured to the
/// middle or to the outer edge of the lines, so the better fit counts, as in calibration.
std::optional<LinesNow> lines_in(const ImageView& image, const Scene& scene, const FieldCurves& curves) {
  std::optional<LinesNow> best;
  for (const LinesMeasured to : {LinesMeasured::kToMiddle, LinesMeasured::kToOuterEdge}) {
    const auto measured = curves.measured(to);
    const LinesVerdict verdict = judge_lines(check_lines(image, *scene.camera, measured, kWindowMm));
    if (verdict.lines == 0) continue;
    const LinesNow now{verdict, measured[verdict.worst].name};
    best = best ? better(*best, now) : now;
  }
  if (best) best->better_size = find_better_size(image, *scene.camera, scene.field, best->verdict, kWindowMm);
  return best;
}

}  // namespace

FieldWatch::FieldWatch(Cameras& cameras, Pace pace)
    : cameras_(cameras), pace_(pace), started_s_(steady_s()), thread_([this](const std::stop_token& ending) {
        become_background_thread("verdict");
        serve(ending);
      }) {}

FieldWatch::Seen FieldWatch::seen(std::optional<double> match_since_s, const SubstitutionAreas& areas) const {
  const double now_s = steady_s();
  const std::lock_guard lock(mutex_);
  return {sightings_.now(now_s, match_since_s, areas), lines_, now_s - started_s_};
}

void FieldWatch::forget(const std::set<int>& camera_ids) {
  const std::lock_guard lock(mutex_);
  for (const int id : camera_ids) {
    sightings_.forget(id);
    lines_.erase(id);
  }
  to_forget_.insert(camera_ids.begin(), camera_ids.end());
}

void FieldWatch::expect_nothing_of(const std::set<int>& camera_ids) {
  const std::lock_guard lock(mutex_);
  for (const int id : camera_ids) sightings_.expect_nothing_of(id);
}

void FieldWatch::robots_are_handled(bool are) {
  const std::lock_guard lock(mutex_);
  sightings_.robots_are_handled(are);
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
      // With another calibration or other robot heights, the same robots have other positions.
      if (std::exchange(watched.seen_with, camera.context().scene) != camera.context().scene)
        sightings_.forget(camera.id);
      sightings_.add(camera.id, now_s, frame->t_capture_s, frame->robots, frame->balls, frame->second_robots);
    }
    if (const auto now = Clock::now(); now >= watched.lines_due) {
      watched.lines_due = now + pace_.between_lines;
      look_at_lines(camera, *frame, watched);
    }
  } catch (const CaptureError&) {  // the camera no longer exists; the next list lacks it
  }
}

void FieldWatch::look_at_lines(const CameraNow& camera, const LentFrame& frame, Watched& watched) {
  const std::shared_ptr<const Scene>& scene = camera.context().scene;
  if (watched.scene != scene) {
    watched.scene = scene;
    watched.curves.emplace(scene->field);
    watched.before.reset();
  }
  std::optional<LinesNow> now;
  const ImageView& image = frame.image;
  if (scene->camera && image.width == scene->camera->calibration().pixel_image_width &&
      image.height == scene->camera->calibration().pixel_image_height)
    now = lines_in(image, *scene, *watched.curves);
  // A hand or a lamp that is switched on may spoil a single image: use the better of two successive checks.
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
