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

namespace sslv {

/// What is left over of the cameras' calibrations and clocks, and of the robots' heights, learnt from robots
/// that two cameras see: each camera's error as squares of the place, its time offset, each robot's own
/// height. Only what cameras do not agree on can be learnt; what all have in common stays.
///
/// Cameras of other computers are corrected by what ours see, never the other way round: what is known of our
/// own cameras, and of robots' heights, is the same with and without them.
class CameraAgreement {
 public:
  /// What two cameras differ by in one part of the field, without what their clocks make, and what robots of
  /// different heights do.
  struct Difference {
    int camera, other;
    Eigen::Vector2d place_mm;      // the middle of the part
    Eigen::Vector2d off_mm{0, 0};  // where `camera` sees robots, from where `other` does
    double samples = 0, t_s = 0;   // how many, and when the last was
  };
  /// The parts are squares of this size.
  static constexpr double kPartMm = 500;

  /// A robot as a camera sees it again and again, at that camera's time.
  struct Seen {
    RobotName robot;
    Eigen::Vector2d place_mm;  // on the plane z = height_mm
    double height_mm;
    double t_s;
  };

  /// Where the camera hangs. To be called before the sightings of each image; another place means that it was
  /// calibrated, and forgets its errors.
  void set_camera(int camera, const Eigen::Vector3d& center_mm, bool is_of_other_computer = false);

  /// Compares with what other cameras saw just before.
  void see(int camera, const Seen& seen);

  /// Lets what is taken off follow what was learnt, slowly, so that no track jumps when something is learnt.
  void follow(double passed_s);

  /// To be taken off a robot's place as the camera has it.
  Eigen::Vector2d error_of(int camera, const Eigen::Vector2d& place_mm) const;
  /// Likewise, for a robot that is higher or lower than the plane on which the camera has it.
  Eigen::Vector2d height_error_of(int camera, const RobotName& robot, const Eigen::Vector2d& place_mm,
                                  double height_mm) const;
  /// To be taken off the camera's times.
  double time_offset_s(int camera) const;
  /// A robot's own height, over that of its plane, and how sure that is.
  struct Height {
    double more_mm, sigma_mm;
  };
  std::optional<Height> height_of(const RobotName& robot) const;

  /// Calls use(camera) for each that was set.
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
  /// Lets go of differences that were seen last before then.
  void forget_differences(double before_s);
  /// How often it was not finite and was reset.
  std::uint64_t repaired() const { return repaired_; }

 private:
  static constexpr int kTerms = 6, kPerCamera = 2 * kTerms + 1;
  struct Camera {
    Eigen::Vector3d center_mm;
    int at;  // its first state
    bool is_of_other_computer;
    std::uint64_t heard;  // when, last: see heard_
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
    int at;  // its height's state
    double seen_s = 0;
    bool is_ours = false;                            // our own cameras have seen it
    std::array<Compared, 2> compared{};              // our own cameras; with another computer's
    std::map<int, std::pair<Last, Last>> by_camera;  // before, now
  };
  using Row = std::vector<std::pair<int, double>>;

  int add_states(int count);
  void forget(const Camera& camera, double error_mm);
  void forget_sightings(int camera);
  std::optional<int> place_for_camera();
  Track* track_of(const RobotName& robot, double t_s, bool is_of_other);
  Eigen::Matrix<double, kTerms, 1> terms(const Camera& camera, const Eigen::Vector2d& place_mm) const;
  Eigen::Vector2d outwards(const Camera& camera, const Eigen::Vector2d& place_mm, double height_mm) const;
  /// A robot that two cameras saw at the same moment.
  struct Pair {
    int a, b;  // the cameras
    Eigen::Vector2d place_a_mm, place_b_mm, velocity_mm_s;
    double passed_s;  // between the two images of `a` among which b's is
    double height_mm, t_s;
  };
  bool compare(const Pair& pair, const Track& track);
  void keep_own();
  void begin_again();
  void note_difference(const Pair& pair, const Eigen::Vector2d& off_mm);

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
  std::map<std::pair<int, int>, int> surprises_;  // of two cameras, one after the other
  Eigen::VectorXd states_, taken_off_;
  Eigen::MatrixXd cov_;
  std::uint64_t repaired_ = 0;
  Row row_;
  Eigen::VectorXd gain_;
};

}  // namespace sslv
