// SPDX-License-Identifier: Apache-2.0
#include "services/calibration/joint_calibration_jobs.h"

#include "base/log.h"
#include "capture/source.h"
#include "services/calibration/tie_collector.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Runs `act` and adds the camera's id to the message of a CaptureError.
template <class Act>
auto naming(int camera_id, Act act) {
  try {
    return act();
  } catch (const CaptureError& error) {
    throw CaptureError(fmt::format("camera {}: {}", camera_id, error.what()));
  }
}

/// Collects mean images and tie points (robots that two cameras saw at the same moment) from fresh frames;
/// incomplete when stopped. Throws CaptureError.
JointTask collect(const WaitFrame& wait_frame, std::chrono::milliseconds silence,
                  const JointCalibrationOrder& order, const JobProgress& progress,
                  const std::stop_token& stop) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kLook{5};  // below a frame interval: no camera's frame is missed
  JointTask task;
  task.field = order.field;
  std::vector<FreshFrames> fresh;
  for (const JointCalibrationOrder::Camera& camera : order.cameras) {
    task.cameras.push_back({camera.id, {}, camera.calibration});
    fresh.push_back(naming(camera.id, [&] { return FreshFrames(wait_frame, camera.id, silence); }));
  }
  TieCollector collector(order.cameras.size());
  const int wanted = order.request.frames;
  const auto frames = [&] {
    int least = wanted;
    for (const CalibratedView& camera : task.cameras) least = std::min(least, camera.picture.frames());
    return least;
  };
  const auto until = Clock::now() + std::chrono::duration<double>(order.request.seconds);
  while (Clock::now() < until || frames() < wanted) {
    for (std::size_t i = 0; i < fresh.size(); ++i) {
      if (stop.stop_requested()) return task;
      CalibratedView& camera = task.cameras[i];
      naming(camera.id, [&] {
        const auto frame = fresh[i].next(kLook);
        if (!frame) return;
        collector.add(i, frame->t_capture_s, frame->robots);
        if (camera.picture.frames() < wanted) add_frame(camera.picture, *frame);
      });
    }
    progress.collected(frames(), static_cast<int>(collector.count()));
  }
  task.ties = collector.ties();
  return task;
}

}  // namespace

JointCalibrationJobs make_joint_calibration_jobs(WaitFrame wait_frame, std::chrono::milliseconds silence) {
  const auto work = [wait_frame = std::move(wait_frame), silence](
                        int, const JointCalibrationOrder& order, const JobProgress& progress,
                        const std::stop_token& stop) -> JointReport {
    const JointTask task = collect(wait_frame, silence, order, progress, stop);
    if (stop.stop_requested()) return {};
    progress.solving();
    return calibrate_jointly(task, stop);
  };
  return {"joint calib", work, [](int, const std::string& problem) {
            log::warning("cameras not calibrated together: {}", problem);
          }};
}

void invalidate(JointCalibrationJobs& jobs, const std::set<int>& camera_ids) {
  jobs.invalidate_if([&](int, const JointCalibrationOrder& order) {
    return std::any_of(order.cameras.begin(), order.cameras.end(),
                       [&](const auto& camera) { return camera_ids.contains(camera.id); });
  });
}

}  // namespace sslv
