// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/background_jobs.h"
#include "colors/learn_colors.h"
#include "config/config.h"
#include "pipeline/frame.h"
#include "services/cameras/fresh_frames.h"
#include "services/cameras/stills.h"
#include "vision/detections.h"
#include "vision/label.h"

#include <array>
#include <chrono>
#include <cstddef>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace sslv {

struct LearningOrder {
  int frames = 3;
  std::vector<ColorSample> guide;
  CameraSettings settings;  // its stack and stages are used for detection
  CameraContext context;    // contains the table that the learnt table is compared with
  std::string who;          // the client's address
  double time_s = 0;
};

/// An image from which colours were learnt, with the detections made with the old and the new table.
struct LearningPicture {
  std::shared_ptr<const StillPicture> picture;
  RobotList robots_before, robots_after;
  BallList balls_before, balls_after;
};

struct LearningReport {
  LearntColors learnt;
  bool calibrated = false;
  std::shared_ptr<const Lut> before;
  using Cells = std::array<std::size_t, label::kMaxCount>;  // number of cells of each label
  Cells cells_before{}, cells_after{};
  std::vector<LearningPicture> pictures;
  std::size_t changed_cells = 0;
  double seconds = 0;
};

/// Learns cameras' colours while they keep running. Keys are the cameras' ids.
using ColorLearning = BackgroundJobs<LearningOrder, LearningReport>;

ColorLearning make_color_learning(WaitFrame wait_frame, std::chrono::milliseconds silence = kSilence);

/// Fails the jobs of cameras that were removed or whose view has changed.
void invalidate(ColorLearning& jobs, const std::set<int>& camera_ids);

}  // namespace sslv
