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
  CameraSettings settings;  // its stack and stages say what would be detected
  CameraContext context;    // with the table to compare with
  std::string who;          // the client's address
  double time_s = 0;
};

/// An image it learnt from, and what is found in it with either table.
struct LearningPicture {
  std::shared_ptr<const StillPicture> picture;
  RobotList robots_before, robots_after;
  BallList balls_before, balls_after;
};

struct LearningReport {
  LearntColors learnt;
  bool calibrated = false;
  std::shared_ptr<const Lut> before;
  using Cells = std::array<std::size_t, label::kMaxCount>;  // of each label, in a table
  Cells cells_before{}, cells_after{};
  std::vector<LearningPicture> pictures;
  std::size_t changed_cells = 0;
  double seconds = 0;
};

/// Learns cameras' colours while they go on working. Keys are the cameras' ids.
using ColorLearning = BackgroundJobs<LearningOrder, LearningReport>;

ColorLearning make_color_learning(WaitFrame wait_frame, std::chrono::milliseconds silence = kSilence);

/// For cameras that show something else from now on, or are gone.
void invalidate(ColorLearning& jobs, const std::set<int>& camera_ids);

}  // namespace sslv
