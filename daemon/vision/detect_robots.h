// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"
#include "base/stage_notes.h"
#include "image/frame_info.h"
#include "image/image.h"
#include "vision/confidence.h"
#include "vision/detections.h"
#include "vision/lut.h"
#include "vision/mask.h"
#include "vision/pattern_fit.h"
#include "vision/patterns.h"
#include "vision/regions.h"
#include "vision/robot_memory.h"
#include "vision/row_times.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <tuple>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// Finds robots. Regions of the teams' and dots' colours give start positions, from which every dot is fitted
/// to the image's own samples (PatternFitter), all in field coordinates on the plane of the team's height. A
/// robot is reported only if its id is proven: if all codes of a table are in use, this requires the colours
/// of all dots, or of all dots but one if the roster, the other robots or the memory leave only one id.
class DetectRobots {
 public:
  enum class Duplicates { kDrop, kKeep };
  static constexpr std::array<Choice<Duplicates>, 2> kDuplicatesChoices{
      {{"drop", Duplicates::kDrop}, {"keep", Duplicates::kKeep}}};

  struct Params {
    double min_area_ratio = 0.2;
    double max_area_ratio = 2.5;
    double max_rms_mm = 6;
    double min_confidence = 0.6;
    Duplicates duplicates = Duplicates::kDrop;
    double memory_ms = 100;
    double rolling_shutter_ms = 0;
    double blur_px = kUsualBlurPx;
    int max_work = 3000;
    static constexpr auto fields() {
      return std::tuple{
          number("min_area_ratio", &Params::min_area_ratio, 0.0, 1.0, "",
                 "smallest region considered, as a share of a dot's true area"),
          number("max_area_ratio", &Params::max_area_ratio, 1.0, 10.0, "",
                 "largest region considered, as a multiple of a dot's true area"),
          number("max_rms_mm", &Params::max_rms_mm, 0.5, 30.0, "mm",
                 "largest rms distance of the dots from their places in a pattern"),
          number("min_confidence", &Params::min_confidence, 0.0, 1.0, "", "robots below it are not reported"),
          choice(
              "duplicates", &Params::duplicates, kDuplicatesChoices,
              "a second robot with the id of another of its team: drop it, or keep it with a quarter of its "
              "confidence"),
          number("memory_ms", &Params::memory_ms, 0.0, 2000.0, "ms",
                 "how long a robot's last position helps to find it again; it changes the reported position "
                 "only with a rolling shutter. 0: each image is processed alone"),
          number("rolling_shutter_ms", &Params::rolling_shutter_ms, 0.0, 100.0, "ms",
                 "time between the exposures of the image's first and last row, when one row follows the "
                 "other; robots are then reported where they were at the time of the middle row, the frame's "
                 "time, "
                 "computed from their speed in the last images (needs memory_ms). 0: all rows at once"),
          number("blur_px", &Params::blur_px, 0.1, 5.0, "px", "blur of the lens, as the sigma of a Gaussian"),
          number(
              "max_work", &Params::max_work, 100, 1'000'000, "",
              "maximum work for an image: number of fitted dots, or of other steps that take as long (about "
              "1 us); frames with more are counted"),
      };
    }
  };

  /// `mask` has already been applied to the regions. Here it prevents the search for a remembered robot that
  /// has moved into the hidden part of the image. Without a calibrated camera, or in an image without
  /// colours, the result is empty.
  void process(const Params& params, const Scene& scene, const PatternTable& patterns, const Lut& lut,
               const Mask& mask, const FrameInfo& info, const Image& image, const RegionList& regions,
               RobotList& robots, StageNotes& notes) noexcept;

  template <class Self>
  static auto remembered(Self& self) {
    return RobotMemory::stored(self.memory_);
  }

 private:
  /// A region that may be a side dot, projected to the plane of a team's height.
  struct Dot {
    double x_mm, y_mm;
    std::size_t region;
  };
  /// A pattern found in the image.
  struct Candidate {
    PatternFit fit;
    double height_mm;
    std::optional<Team> team;                         // the team, if the centre dot proves it
    std::array<bool, PatternTable::kMaxDots> proven;  // side dots with a proven colour
    int proven_dots;                                  // number of proven dots, including the centre dot
    double confidence;
  };
  /// A pose to try.
  struct Start {
    PatternPose pose;
    int matched;  // number of side dots with a region at their place
  };
  using Frame = PatternFitter::Frame;

  void collect_dots(const Params& params, const Frame& frame, double height_mm, const Mask& mask,
                    const RegionList& regions);
  std::vector<Dot>::iterator first_dot_right_of(double x_mm);
  void explain_dots(const PatternTable& patterns, const Candidate& found);
  Start arrange(const PatternTable& patterns, double x_mm, double y_mm);
  void search_from_centers(const Params& params, const Frame& frame, Team team, double height_mm,
                           const Mask& mask, const RegionList& regions);
  void search_around(const Params& params, const Frame& frame, double x_mm, double y_mm, double height_mm,
                     int min_matched);
  void search_from_side_dots(const Params& params, const Frame& frame, double height_mm);
  void search_from_memory(const Params& params, const Frame& frame, const Scene& scene, const Mask& mask);
  double work_done() const { return fitter_.work() + work_; }
  bool time_left(const Params& params) const { return work_done() < params.max_work; }

  /// Predicted pose of a remembered robot when the row that shows it is exposed.
  struct Expected {
    PatternPose pose;
    Eigen::Vector2d mm_per_row;  // motion from each row to the next
  };
  Expected expected_in_picture(const Frame& frame, const Scene& scene, const RobotMemory::Entry& entry,
                               double now_s) const;
  /// Motion (mm per row) of the remembered robot at this pose; 0 if no robot is remembered there.
  Eigen::Vector2d mm_per_row_at(const PatternPose& pose) const;

  /// Fits the pattern and rates it.
  Candidate examine(const Params& params, const Frame& frame, const PatternPose& start, double height_mm,
                    int max_passes);
  void keep(const Params& params, const Frame& frame, const Candidate& candidate);
  void miss(const Frame& frame, const Candidate& candidate, RobotMiss::Why why, double value = 0,
            double limit = 0);
  void stop_telling(StageNotes& notes);
  void report(const Params& params, double now_s, RobotList& robots, StageNotes& notes);
  void choose(const Params& params, const Frame& frame, const Scene& scene, RobotList& robots);

  PatternFitter fitter_;
  double work_ = 0;  // work done outside fitter_, in the fitter's unit
  RobotMemory memory_;
  RowTimes rows_;                        // row times of this image
  std::vector<Expected> expected_;       // poses in this image, for each entry of memory_
  std::vector<Dot> dots_;                // sorted by x
  std::vector<std::uint8_t> explained_;  // for each region: 1 if a found robot has this side dot
  std::vector<Candidate> candidates_;
  std::vector<const Candidate*> order_, chosen_;

  /// Regions of a team's colour in this image.
  struct Centers {
    int count = 0;       // as large as a centre dot
    int other = 0;       // smaller or larger
    double nearest = 0;  // the area nearest to a centre dot's, as a share of it
  };
  std::array<Centers, 2> centers_;
  std::vector<RobotMiss> misses_;
  double told_s_ = 0;
  bool is_telling_ = false;
};

}  // namespace sslv
