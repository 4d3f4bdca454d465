// SPDX-License-Identifier: Apache-2.0
#include "calibration/calibrate_jointly.h"

#include "calibration/publish.h"
#include "calibration/way_round.h"
#include "support/painted_floor.h"

#include <random>

#include <gmock/gmock.h>

namespace sslv::calibrate_jointly_test {
namespace {

using testing::Contains;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

MeanPicture mean_of(const FloorPicture& picture) {
  MeanPicture mean;
  mean.add(picture.view);
  return mean;
}

/// Small images (see FloorSetting), unless a test needs larger ones.
constexpr int kSize = 3;

/// The camera's calibration with a wrong position, like an admin's: off by about 1.3 * `by_mm`.
CameraCalibration spoilt(LensCamera camera, double by_mm) {
  camera.position_mm += Eigen::Vector3d(by_mm, -0.5 * by_mm, 0.6 * by_mm);
  return publish(camera).calibration;
}

/// Two cameras, 3 and 7, over the halves of a field with unevenly painted lines.
class CalibrateJointly : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    PaintedFloor floor;
    floor.field = floor_field(kSize);
    floor.wavy_mm = 1.5;
    floor.robots = 4;
    a_ = floor_camera({kSize});
    b_ = turned_round(a_);
    b_.center_x += 4;
    seen_by_a_ = mean_of(draw_floor(floor, a_));
    seen_by_b_ = mean_of(draw_floor(floor, b_));
  }

  static JointTask task(double off_mm = 20) {
    JointTask out;
    out.field = floor_field(kSize);
    out.cameras = {{3, seen_by_a_, spoilt(a_, off_mm)}, {7, seen_by_b_, spoilt(b_, -off_mm)}};
    return out;
  }
  /// Robots that both cameras see, with a noise of 0.1 px.
  static std::vector<OverlapTie> robots_in_both() {
    std::mt19937 random(5);
    std::normal_distribution<double> noise_px(0, 0.1);
    std::uniform_real_distribution<double> x(-300, 300), y(-900, 900);
    std::vector<OverlapTie> out;
    for (int i = 0; i < 30; ++i) {
      const Eigen::Vector3d place(x(random), y(random), 140);
      const auto p = a_.project(place), q = b_.project(place);
      if (!p || !q || !a_.is_in_picture(*p) || !b_.is_in_picture(*q)) continue;
      out.push_back({0, 1, *p + Eigen::Vector2d(noise_px(random), noise_px(random)),
                     *q + Eigen::Vector2d(noise_px(random), noise_px(random)), 140, 0.3});
    }
    return out;
  }
  static double overlap_mm(const JointReport& report, double height_mm) {
    return overlap_error_mm(a_, b_, lens_camera(report.cameras[0].calibration),
                            lens_camera(report.cameras[1].calibration), floor_field(kSize), height_mm);
  }

  static inline LensCamera a_, b_;
  static inline MeanPicture seen_by_a_, seen_by_b_;
};

TEST_F(CalibrateJointly, CamerasAgreeAfterwards) {
  JointTask asked = task();
  asked.ties = robots_in_both();
  const JointReport report = calibrate_jointly(asked);
  ASSERT_TRUE(report.found);
  EXPECT_TRUE(report.accepted);
  EXPECT_THAT(report.problems, IsEmpty());
  EXPECT_THAT(report.notes, IsEmpty());
  EXPECT_EQ(report.cameras[0].id, 3);
  EXPECT_EQ(report.cameras[1].id, 7);
  EXPECT_EQ(report.measured, LinesMeasured::kToMiddle);
  // Errors against the truth.
  EXPECT_LT(overlap_mm(report, 0), 0.7);
  EXPECT_LT(overlap_mm(report, 150), 0.9);
  EXPECT_LT(field_error_mm(a_, lens_camera(report.cameras[0].calibration), asked.field, 0), 2);
  EXPECT_LT(field_error_mm(b_, lens_camera(report.cameras[1].calibration), asked.field, 0), 2);
  // The report has figures for all of this; `before_mm` is with the current calibrations.
  ASSERT_TRUE(report.on_floor && report.of_robots);
  EXPECT_GT(report.overlapping_patches, 50);
  EXPECT_EQ(report.ties, static_cast<int>(asked.ties.size()));
  EXPECT_GT(report.on_floor->before_mm, 20);
  EXPECT_LT(report.on_floor->after_mm, 1);
  EXPECT_GT(report.of_robots->before_mm, 30);
  EXPECT_LT(report.of_robots->after_mm, 2.5) << "a tenth of a pixel is a millimetre";
  for (const JointCameraReport& camera : report.cameras) {
    EXPECT_NEAR(camera.moved_on_floor_mm, 30, 15);
    EXPECT_LT(camera.rms_px, 0.4);
    EXPECT_GT(camera.found_share, 0.8);
  }
}

TEST_F(CalibrateJointly, WithoutRobotsOnlyLinesTie) {
  const JointReport report = calibrate_jointly(task());
  EXPECT_TRUE(report.accepted);
  EXPECT_FALSE(report.of_robots);
  EXPECT_LT(overlap_mm(report, 0), 0.7);
  EXPECT_THAT(report.notes, ElementsAre(HasSubstr("Put robots where the cameras overlap")));
}

TEST_F(CalibrateJointly, EstimatesLensesAndWhatSizesWereMeasuredTo) {
  PaintedFloor floor;
  floor.field = floor_field(kSize);
  floor.measured = LinesMeasured::kToOuterEdge;
  floor.robots = 4;
  FloorSetting bent{kSize};
  bent.k2 = 0.05;
  const LensCamera a = floor_camera(bent), b = turned_round(a);
  JointTask asked;
  asked.field = floor.field;
  asked.cameras = {{3, mean_of(draw_floor(floor, a)), spoilt(a, 10)},
                   {7, mean_of(draw_floor(floor, b)), spoilt(b, -10)}};
  const JointReport report = calibrate_jointly(asked);
  EXPECT_TRUE(report.accepted);
  EXPECT_EQ(report.measured, LinesMeasured::kToOuterEdge);
  EXPECT_THAT(report.notes, Contains(HasSubstr("between centres this field is 3015 x 2015 mm")));
  for (const JointCameraReport& camera : report.cameras) {
    EXPECT_GT(camera.lens_rms_mm, 0) << "no second term was fitted";
    EXPECT_LT(camera.rms_px, 0.1);
  }
}

TEST_F(CalibrateJointly, RobotsOfAnotherHeightAreNoticed) {
  JointTask asked = task(0);
  asked.ties = robots_in_both();
  for (OverlapTie& tie : asked.ties) tie.height_mm = 120;
  const JointReport report = calibrate_jointly(asked);
  ASSERT_TRUE(report.found);
  EXPECT_FALSE(report.accepted);
  EXPECT_THAT(report.problems, Each(HasSubstr("are the teams' robot heights")));
  EXPECT_LT(overlap_mm(report, 0), 2) << "lines keep the floor where it is";
}

TEST_F(CalibrateJointly, ACameraThatIsFarOffIsNamed) {
  JointTask asked = task();
  asked.cameras[1].calibration = spoilt(b_, 700);
  const JointReport report = calibrate_jointly(asked);
  EXPECT_FALSE(report.accepted);
  EXPECT_THAT(report.problems, ElementsAre(HasSubstr("Camera 7")));
}

TEST_F(CalibrateJointly, ACalibrationForAnotherPictureIsNamed) {
  JointTask asked = task();
  asked.cameras[0].calibration.pixel_image_width = 320;
  const JointReport report = calibrate_jointly(asked);
  EXPECT_FALSE(report.found);
  EXPECT_THAT(report.problems, ElementsAre(HasSubstr("Camera 3 sends 390 x 290 pixels")));
}

TEST_F(CalibrateJointly, NeedsTwoCameras) {
  JointTask asked = task();
  asked.cameras.pop_back();
  const JointReport report = calibrate_jointly(asked);
  EXPECT_FALSE(report.found);
  EXPECT_THAT(report.problems, ElementsAre(HasSubstr("two or more")));
}

TEST_F(CalibrateJointly, CamerasThatSeeNothingInCommonAreNotAccepted) {
  PaintedFloor floor;
  floor.field = floor_field(0);
  floor.robots = 0;
  FloorSetting quarter;  // a small image of it would show too few lines
  quarter.view = FloorView::kQuarter;
  LensCamera a = floor_camera(quarter);
  constexpr int kOverlapPx = 200;  // removed from its left side
  a.center_x -= kOverlapPx;
  a.width -= kOverlapPx;
  const LensCamera b = turned_round(a);
  JointTask asked;
  asked.field = floor.field;
  asked.cameras = {{0, mean_of(draw_floor(floor, a)), spoilt(a, 10)},
                   {1, mean_of(draw_floor(floor, b)), spoilt(b, 10)}};
  const JointReport report = calibrate_jointly(asked);
  EXPECT_TRUE(report.found);
  EXPECT_FALSE(report.accepted);
  EXPECT_FALSE(report.on_floor);
  EXPECT_THAT(report.problems, ElementsAre(HasSubstr("nothing aligns them")));
}

TEST_F(CalibrateJointly, CanBeStopped) {
  std::stop_source stop;
  stop.request_stop();
  const JointReport report = calibrate_jointly(task(), stop.get_token());
  EXPECT_FALSE(report.found);
  EXPECT_THAT(report.problems, IsEmpty());
}

}  // namespace
}  // namespace sslv::calibrate_jointly_test
