// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/simulator/simulator_hall.h"
#include "capture/simulator/simulator_paint.h"
#include "geometry/field.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// Everything static beside the carpet or on its rim: floor, advertising boards, things, people. All of it is
/// outside the field's lines.
class SimulatedSurroundings {
 public:
  /// A thin horizontal slice of a thing; a thing is a stack of slices, the lowest first.
  struct Slice {
    bool is_round;
    Eigen::Vector3d center_mm;
    double turn_rad;
    double half_length_mm, half_width_mm;  // along its own axes
    Paint paint;
  };

  /// `hall` must be resolved.
  SimulatedSurroundings(const HallOptions& hall, const FieldSize& field);

  bool on_carpet(const Eigen::Vector2d& field_mm) const;
  /// Colour of the floor beside the carpet.
  Paint floor_at(const Eigen::Vector2d& field_mm) const;
  /// Factor on the light at a place on the floor or carpet.
  float shade_at(const Eigen::Vector2d& field_mm) const;
  /// The colour of the board that hides a place on the floor from an eye, if any.
  std::optional<Paint> board_before(const Eigen::Vector2d& floor_mm, const Eigen::Vector3d& eye_mm) const;
  bool has_boards() const { return !boards_.empty(); }
  /// Whether a place is on the far side of the boards.
  bool is_behind_boards(const Eigen::Vector2d& field_mm) const;
  std::span<const Slice> slices() const { return slices_; }

 private:
  struct Board {
    int axis;     // axis of its normal: 0: x, 1: y
    double sign;  // side of the field: -1 or 1
    double from_mm, to_mm;
    Paint face, letters, logo;
    std::uint64_t text;
  };
  struct Blob {
    Eigen::Vector2d middle_mm;
    float reach_mm;
  };
  class Furnisher;  // places boards, things and people

  const Board* board_at(int axis, double sign, double along_mm) const;
  Paint face_of(const Board& board, double along_mm, double up_mm) const;

  std::array<double, 2> half_carpet_mm_, half_boards_mm_;
  HallFloor floor_;
  float shadows_;
  double board_height_mm_ = 0;
  std::vector<Board> boards_;
  std::vector<Slice> slices_;
  std::vector<Blob> shadows_of_people_;
};

}  // namespace sslv
