// SPDX-License-Identifier: Apache-2.0
#include "services/colors/color_learning.h"

#include "base/error.h"
#include "base/log.h"
#include "capture/source.h"
#include "colors/table_edit.h"
#include "config/stages.h"
#include "pipeline/camera_pipeline.h"

#include <algorithm>
#include <cmath>
#include <stop_token>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

using StillPictures = std::vector<std::shared_ptr<const StillPicture>>;

/// Returns `wanted` fresh images, spaced in time so that objects move in between; fewer when stopped. Throws
/// CaptureError.
StillPictures collect_pictures(FreshFrames frames, int wanted, const JobProgress& progress,
                               const std::stop_token& stop) {
  constexpr std::chrono::milliseconds kLook{100};  // maximum delay of a cancellation
  constexpr double kSpacing_s = 0.3;
  StillPictures pictures;
  while (static_cast<int>(pictures.size()) < wanted && !stop.stop_requested()) {
    const auto frame = frames.next(kLook);
    if (!frame) continue;
    // Compare the absolute difference, because the clock may have been set back.
    if (!pictures.empty() && std::abs(frame->t_capture_s - pictures.back()->t_capture_s) < kSpacing_s)
      continue;
    if (frame->image.format == PixelFormat::kMono8)
      throw CaptureError("the camera's images have no colours: there is no table to learn");
    const auto& view = frame->image;
    if (!pictures.empty()) {
      const ImageView& first = pictures.front()->view;
      if (first.width != view.width || first.height != view.height || first.format != view.format)
        throw CaptureError("the camera's images have changed in the meantime; start again");
    }
    pictures.push_back(std::make_shared<const StillPicture>(view, frame->number, frame->t_capture_s));
    progress.collected(static_cast<int>(pictures.size()), 0);
  }
  return pictures;
}

struct NoSink : DetectionSink {
  void publish(const FrameInfo&, const Scene&, const RobotList&, const BallList&) noexcept override {}
};

/// Runs the camera's stack over still images with another table.
class Detector {
 public:
  Detector(const CameraSettings& settings, const CameraContext& context, std::shared_ptr<const Lut> lut) {
    CameraSetup setup;
    setup.pipeline = std::make_shared<Pipeline>(stage_table(), settings.running.stages, "/stack");
    setup.parameters = setup.pipeline->parameters_of(settings.stage_params);
    setup.context = context;
    setup.context.adapted_lut = std::move(lut);
    pipeline_ =
        std::make_unique<CameraPipeline>(static_cast<std::uint32_t>(settings.id), sink_, std::move(setup));
  }
  void detect(const StillPicture& picture, RobotList& robots, BallList& balls) {
    CaptureTimes times;
    times.t_capture_s = picture.t_capture_s;
    const Frame& frame = pipeline_->process(Image(picture.view, nullptr, nullptr, nullptr), times);
    robots = frame.robots;
    balls = frame.balls;
  }

 private:
  NoSink sink_;
  std::unique_ptr<CameraPipeline> pipeline_;
};

LearningReport::Cells cells_of(const ColorTable& table) {
  LearningReport::Cells cells{};
  for (const Label label : table.labels) ++cells[label];
  return cells;
}

LearningReport learn(const LearningOrder& order, const StillPictures& pictures, const std::stop_token& stop) {
  const auto begun = std::chrono::steady_clock::now();
  LearningReport report;
  report.calibrated = order.context.scene->camera.has_value();
  report.before = order.context.adapted_lut;
  LearnTask task{{},  *order.context.scene, *order.context.patterns, order.context.mask.get(), order.guide,
                 stop};
  for (const auto& picture : pictures) task.frames.push_back(picture->view);
  report.learnt = learn_colors(task);
  for (const auto& picture : pictures) report.pictures.push_back({picture, {}, {}, {}, {}});
  Detector before(order.settings, order.context, report.before);
  for (LearningPicture& one : report.pictures) {
    if (stop.stop_requested()) return report;
    before.detect(*one.picture, one.robots_before, one.balls_before);
  }
  if (report.learnt.lut) {
    Detector after(order.settings, order.context, report.learnt.lut);
    for (LearningPicture& one : report.pictures) {
      if (stop.stop_requested()) return report;
      after.detect(*one.picture, one.robots_after, one.balls_after);
    }
    const ColorTable old = report.before->color_table(), now = report.learnt.lut->color_table();
    report.cells_before = cells_of(old);
    report.cells_after = cells_of(now);
    if (old.bits == now.bits) {
      for (const CellRun& run : difference(old, now)) report.changed_cells += run.length;
    } else {
      report.changed_cells = now.labels.size();
    }
  }
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return report;
}

}  // namespace

ColorLearning make_color_learning(WaitFrame wait_frame, std::chrono::milliseconds silence) {
  const auto work = [wait_frame = std::move(wait_frame), silence](
                        int camera_id, const LearningOrder& order, const JobProgress& progress,
                        const std::stop_token& stop) -> LearningReport {
    const StillPictures pictures =
        collect_pictures({wait_frame, camera_id, silence}, order.frames, progress, stop);
    if (stop.stop_requested()) return {};
    progress.solving();
    return learn(order, pictures, stop);
  };
  return {"colours", work,
          [](int camera_id, const std::string& problem) {
            log::warning("camera {}: no colours learnt: {}", camera_id, problem);
          },
          become_idle_thread};
}

void invalidate(ColorLearning& jobs, const std::set<int>& camera_ids) {
  jobs.invalidate_if([&](int id, const LearningOrder&) { return camera_ids.contains(id); });
}

}  // namespace sslv
