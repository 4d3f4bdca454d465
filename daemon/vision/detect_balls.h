// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"
#include "geometry/camera_model.h"
#include "image/frame_info.h"
#include "image/image.h"
#include "vision/ball_fit.h"
#include "vision/ball_memory.h"
#include "vision/confidence.h"
#include "vision/detections.h"
#include "vision/lut.h"
#include "vision/mask.h"
#include "vision/regions.h"

#include <cstdint>
#include <optional>
#include <tuple>
#include <vector>

namespace sslv {

/// Finds balls. Regions of the ball's colour give start positions, from which a sphere is fitted to the
/// image's own samples (BallFitter). Size, roundness, colour and surroundings give the confidence. A region
/// on a robot's top is part of its pattern; parts of a ball that a robot hides are left out of the fit.
/// Objects that have not moved since they were first seen off the field are furniture and are not reported
/// (BallMemory).
class DetectBalls {
 public:
  struct Params {
    double min_area_ratio = 0.15;
    double max_area_ratio = 3.0;
    double max_outside_mm = 300;
    double on_robot_mm = 8;
    double min_confidence = 0.5;
    int max_balls = 20;
    double blur_px = 0.55;
    int max_fits = 200;
    static constexpr auto fields() {
      return std::tuple{
          number("min_area_ratio", &Params::min_area_ratio, 0.0, 1.0, "",
                 "smallest region considered, as a share of a ball's true area"),
          number("max_area_ratio", &Params::max_area_ratio, 1.0, 20.0, "",
                 "largest region considered, as a multiple of a ball's true area"),
          number("max_outside_mm", &Params::max_outside_mm, 0.0, 10'000.0, "mm",
                 "maximum distance of a ball beyond the touch and goal lines"),
          number("on_robot_mm", &Params::on_robot_mm, -100.0, 100.0, "mm",
                 "a region further than this inside a robot's outline is part of the robot; below 0: also a "
                 "region this close outside it"),
          number("min_confidence", &Params::min_confidence, 0.0, 1.0, "", "balls below it are not reported"),
          number("max_balls", &Params::max_balls, 1, 1'000, "",
                 "largest number of balls reported: the best ones"),
          number("blur_px", &Params::blur_px, 0.1, 5.0, "px", "blur of the lens, as the sigma of a Gaussian"),
          number("max_fits", &Params::max_fits, 1, 100'000, "",
                 "maximum number of regions checked in an image, the largest first (about 10 us each, up to "
                 "five times that if a ball is small or hidden); frames with more are counted"),
      };
    }
  };

  /// Without a calibrated camera, or in an image without colours, the result is empty.
  void process(const Params& params, const Scene& scene, const Lut& lut, const Mask& mask,
               const FrameInfo& info, const Image& image, const RegionList& regions, const RobotList& robots,
               BallList& balls) noexcept;

  /// `area_ratio`: area of the region / area of a ball; `coarser_mm`: by how much the segmentation's cells
  /// are wider than in the images to which the confidence was fitted.
  static BallEvidence evidence_of(const BallFit& fit, const Scene& scene, const Lut& lut, double area_ratio,
                                  double coarser_mm = 0);

  template <class Self>
  static auto remembered(Self& self) {
    return BallMemory::stored(self.memory_);
  }

 private:
  struct Candidate {
    BallFit fit;
    BallEvidence evidence;
    double confidence;
    std::uint32_t area_px;
    std::optional<BallMemory::Known> known;
  };
  BallFitter fitter_;
  std::vector<Candidate> candidates_;  // in the current image
  BallMemory memory_;
  std::optional<CameraCalibration> calibration_;  // of the image before
};

}  // namespace sslv
