// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/tracks.h"

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace sslv {

/// Estimates the remaining errors of the cameras' calibrations and clocks, and of the robots' heights, from
/// robots that two cameras see: for each camera, a quadratic function of the position and a time offset; for
/// each robot, its own height. Only differences between cameras are observable; errors common to all cameras
/// remain.
///
/// Our cameras correct other computers' cameras, never the reverse: the estimates of our own cameras and of
/// robots' heights do not depend on other computers.
class CameraAgreement {
 public:
  /// Mean difference between two cameras in one part of the field, without the effects of their clocks and of
  /// robots' different heights.
  struct Difference {
    int camera, other;
    Eigen::Vector2d place_mm;      // the middle of the part
    Eigen::Vector2d off_mm{0, 0};  // `camera`'s positions minus `other`'s
    double samples = 0, t_s = 0;   // number (limited); time of the last sample
  };
  /// Side of the parts, which are squares.
  static constexpr double kPartMm = 500;

  /// One camera's uncorrected measurement of a robot, at that camera's time.
  struct Seen {
    RobotName robot;
    Eigen::Vector2d place_mm;  // on the plane z = height_mm
    double height_mm;
    double t_s;
  };

  /// Sets the camera's position. Call it before see() for each image. A changed position means a new
  /// calibration: the camera's errors are reset.
  void set_camera(int camera, const Eigen::Vector3d& center_mm, bool is_of_other_computer = false);

  /// Notes how far the camera's times are evened out (see Evenness::share()).
  void set_evenness(int camera, double share);
  /// How far the camera's times are evened out; 0 if it is unknown.
  double evenness_of(int camera) const;

  /// Compares the measurement with other cameras' measurements since this camera's previous image.
  void see(int camera, const Seen& seen);

  /// Moves the applied corrections slowly towards the estimates, so that no track jumps.
  void follow(double passed_s);

  /// Error to subtract from a robot's position measured by the camera (mm).
  Eigen::Vector2d error_of(int camera, const Eigen::Vector2d& place_mm) const;
  /// Error to subtract from a robot's position measured by the camera (mm) because the robot is higher or
  /// lower than the plane on which the camera measures it.
  Eigen::Vector2d height_error_of(int camera, const RobotName& robot, const Eigen::Vector2d& place_mm,
                                  double height_mm) const;
  /// Offset to subtract from the camera's times.
  double time_offset_s(int camera) const;
  /// Estimate of a robot's height above the plane on which cameras measure it, and the estimate's sigma.
  struct Height {
    double more_mm, sigma_mm;
  };
  /// Empty while nothing is known about this robot.
  std::optional<Height> height_of(const RobotName& robot) const;

  /// Calls use(camera) for each camera that was set.
  template <class Use>
  void for_cameras(const Use& use) const {
    for (const auto& [camera, one] : cameras_) use(camera);
  }
  /// Calls use(name, height) for every robot.
  template <class Use>
  void for_heights(const Use& use) const {
    for (const auto& [name, track] : tracks_) use(name, *height_of(name));
  }
  /// Calls use(difference) for every part of the field that two cameras see.
  template <class Use>
  void for_differences(const Use& use) const {
    for (const auto& [key, one] : differences_) use(one);
  }
  /// Drops differences whose last sample is older than `before_s`.
  void forget_differences(double before_s);
  /// Number of times that the filter was not finite and was reset.
  std::uint64_t repaired() const { return repaired_; }

 private:
  static constexpr int kTerms = 6, kPerCamera = 2 * kTerms + 1;
  struct Camera {
    Eigen::Vector3d center_mm;
    int at;  // index of its first state
    bool is_of_other_computer;
    std::uint64_t heard;  // value of heard_ at its last image
    double evenness = 0;
  };
  struct Last {
    Eigen::Vector2d place_mm;
    double t_s;
  };
  struct Compared {
    double t_s = 0;
    int count = 0;
  };
  struct Track {
    int at;  // index of its height's state
    double seen_s = 0;
    bool is_ours = false;                            // our own cameras have seen it
    std::array<Compared, 2> compared{};              // between our cameras; with other computers' cameras
    std::map<int, std::pair<Last, Last>> by_camera;  // previous and current measurement
  };
  using Row = std::vector<std::pair<int, double>>;

  int add_states(int count);
  void forget(const Camera& camera, double error_mm);
  void forget_sightings(int camera);
  std::optional<int> place_for_camera();
  Track* track_of(const RobotName& robot, double t_s, bool is_of_other);
  Eigen::Matrix<double, kTerms, 1> terms(const Camera& camera, const Eigen::Vector2d& place_mm) const;
  Eigen::Vector2d outwards(const Camera& camera, const Eigen::Vector2d& place_mm, double height_mm) const;
  /// Positions of a robot measured by two cameras, at the time of b's image; interpolated for `a`.
  struct Pair {
    int a, b;  // the cameras
    Eigen::Vector2d place_a_mm, place_b_mm, velocity_mm_s;
    double passed_s;  // between the images of `a` before and after b's image
    double height_mm, t_s;
  };
  bool compare(const Pair& pair, const Track& track);
  void keep_own();
  void begin_again();
  /// `off_mm`: without the effects of robots' different heights; `of_height_mm`: the robot's height's effect
  /// on `apart_mm`.
  void note_difference(const Pair& pair, const Eigen::Vector2d& off_mm, const Eigen::Vector2d& apart_mm,
                       const Eigen::Vector2d& of_height_mm);
  Eigen::Vector2d estimate_of(const Camera& camera, const Eigen::Vector2d& place_mm) const;

  std::map<int, Camera> cameras_;
  std::uint64_t heard_ = 0;  // counts the images of all cameras
  std::map<RobotName, Track> tracks_;
  struct PartKey {
    int camera, other, column, row;
    bool operator<(const PartKey& b) const {
      return std::tie(camera, other, column, row) < std::tie(b.camera, b.other, b.column, b.row);
    }
  };
  std::map<PartKey, Difference> differences_;
  /// Where two cameras have compared robots, and how far they differ there at most.
  struct Overlap {
    Eigen::AlignedBox2d parts;
    double differs_mm = 0;
    double corrected_mm2 = 0, uncorrected_mm2 = 0;  // mean squares of recent differences
  };
  std::map<std::pair<int, int>, Overlap> overlaps_;  // by pair of cameras
  std::map<std::pair<int, int>, int> surprises_;     // recent outliers for each pair of cameras
  Eigen::VectorXd states_, taken_off_;
  Eigen::MatrixXd cov_;
  std::uint64_t repaired_ = 0;
  Row row_;
  Eigen::VectorXd gain_;
};

}  // namespace sslv
