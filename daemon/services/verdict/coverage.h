// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/cameras/cameras.h"

#include <span>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// Coverage of the field by the cameras.
struct Coverage {
  static constexpr int kGridMm = 250;
  bool is_known = false;                         // every camera is calibrated
  int places = 0;                                // grid points of the field
  std::vector<Eigen::Vector2d> uncovered_mm;     // grid points that no running camera covers
  std::vector<Eigen::Vector2d> out_of_reach_mm;  // uncovered even if all cameras were running
  std::vector<int> blind;                        // ids of cameras whose masks hide the whole image
};

/// The grid point nearest to the middle of the largest connected group of these grid points, of which there
/// is at least one.
Eigen::Vector2d middle_of_largest(const std::vector<Eigen::Vector2d>& places_mm);

/// Coverage of the floor between the outer lines of the field. Considers only calibrations and masks;
/// obstacles are unknown.
Coverage coverage_of(std::span<const CameraNow> cameras, const FieldSize& field);

}  // namespace sslv
