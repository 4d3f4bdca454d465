// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/background_jobs.h"
#include "calibration/calibrate_jointly.h"
#include "calibration/joint_calibration_json.h"
#include "services/cameras/fresh_frames.h"

#include <chrono>
#include <set>
#include <string>
#include <vector>

namespace sslv {

struct JointCalibrationOrder {
  struct Camera {
    int id;
    CameraCalibration calibration;  // the current calibration
  };
  JointCalibrationRequest request;
  std::vector<Camera> cameras;
  FieldSize field;
  std::string who;  // the client's address
  double time_s = 0;
};

/// Calibrates several cameras together while they keep running.
using JointCalibrationJobs = BackgroundJobs<JointCalibrationOrder, JointReport>;
/// The key of every job: only one job runs at a time, regardless of its cameras.
inline constexpr int kJointKey = 0;

JointCalibrationJobs make_joint_calibration_jobs(WaitFrame wait_frame,
                                                 std::chrono::milliseconds silence = kSilence);

/// Fails the job if one of its cameras was removed or its view has changed.
void invalidate(JointCalibrationJobs& jobs, const std::set<int>& camera_ids);

}  // namespace sslv
