// SPDX-License-Identifier: Apache-2.0
#include "services/calibration/calibration_jobs.h"

#include "base/error.h"
#include "base/log.h"

#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Throws SettingsError for points outside the image: no calibration can fit them.
void check_points(const CalibrationRequest& request, const MeanPicture& picture) {
  for (std::size_t i = 0; i < request.points.size(); ++i) {
    const CalibrationPoint& point = request.points[i];
    const auto check = [&](const char* key, double value, int size) {
      if (value >= size) {
        throw SettingsError(
            fmt::format("/points/{}/{}: {:g} is not allowed; expected 0 .. {} px, as the image is", i, key,
                        value, size - 1));
      }
    };
    check("x", point.x.value(), picture.width());
    check("y", point.y.value(), picture.height());
  }
}

/// Returns the mean of `wanted` fresh frames, or of fewer when stopped. Throws CaptureError.
MeanPicture collect(FreshFrames frames, int wanted, const JobProgress& progress,
                    const std::stop_token& stop) {
  constexpr std::chrono::milliseconds kLook{100};  // maximum delay of a cancellation
  MeanPicture mean;
  while (mean.frames() < wanted && !stop.stop_requested()) {
    const auto frame = frames.next(kLook);
    if (!frame) continue;
    add_frame(mean, *frame);
    progress.collected(mean.frames(), 0);
  }
  return mean;
}

}  // namespace

CalibrationJobs make_calibration_jobs(WaitFrame wait_frame, std::chrono::milliseconds silence) {
  const auto work = [wait_frame = std::move(wait_frame), silence](
                        int camera_id, const CalibrationOrder& order, const JobProgress& progress,
                        const std::stop_token& stop) -> CalibrationReport {
    const MeanPicture picture =
        collect({wait_frame, camera_id, silence}, order.request.frames, progress, stop);
    if (stop.stop_requested()) return {};
    check_points(order.request, picture);
    progress.solving();
    return calibrate(picture, make_task(order.request, order.field, order.previous), stop);
  };
  return {"calibration", work, [](int camera_id, const std::string& problem) {
            log::warning("camera {}: not calibrated: {}", camera_id, problem);
          }};
}

void invalidate(CalibrationJobs& jobs, const std::set<int>& camera_ids) {
  jobs.invalidate_if([&](int id, const CalibrationOrder&) { return camera_ids.contains(id); });
}

}  // namespace sslv
