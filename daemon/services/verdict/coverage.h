// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/cameras/cameras.h"

#include <span>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// Which part of the field the cameras look at.
struct Coverage {
  static constexpr int kGridMm = 250;
  bool is_known = false;                         // every camera is calibrated
  int places = 0;                                // of the field, on a grid
  std::vector<Eigen::Vector2d> uncovered_mm;     // of them, those that no camera looks at that runs now
  std::vector<Eigen::Vector2d> out_of_reach_mm;  // of these, those that no other camera would look at either
  std::vector<int> blind;                        // ids of cameras whose masks leave nothing to look at
};

/// Between the outer lines of the field, on the floor. By calibrations and masks alone: what stands in the
/// way is not seen.
Coverage coverage_of(std::span<const CameraNow> cameras, const FieldSize& field);

}  // namespace sslv
