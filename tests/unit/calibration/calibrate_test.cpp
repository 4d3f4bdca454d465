// SPDX-License-Identifier: Apache-2.0
#include "calibration/calibrate.h"

#include "base/error.h"
#include "calibration/judge.h"
#include "calibration/propose.h"
#include "calibration/way_round.h"
#include "support/painted_floor.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sslv::calibrate_test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

struct Shot {
  LensCamera camera;
  PaintedFloor floor;
  MeanPicture picture;
  double floor_error_mm(const CalibrationReport& report) const {
    return report.found ? field_error_mm(camera, report.camera, floor.field, 0) : 1e6;
  }
  double robots_error_mm(const CalibrationReport& report) const {
    return report.found ? field_error_mm(camera, report.camera, floor.field, 150) : 1e6;
  }
  /// Largest distance in mm of a painted line in view from its position according to the published
  /// calibration.
  double worst_line_error_mm(const CalibrationReport& report) const {
    if (!report.found) return 1e6;
    const CameraModel published(report.calibration);
    double worst_mm = 0;
    for (const CurvePoint& point : points_along(painted_curves(floor.field, floor.measured), 50, 0)) {
      const auto pixel = camera.project(point.place_mm);
      if (!pixel || !camera.is_in_picture(*pixel)) continue;
      const auto place = published.unproject(*pixel, 0);
      worst_mm = std::max(worst_mm, place ? (*place - point.place_mm.head<2>()).norm() : 1e6);
    }
    return worst_mm;
  }
};

/// Small images take a third of the time; used unless a test's bounds need larger ones.
constexpr int kSmall = 3;

Shot take(const FloorSetting& setting, PaintedFloor floor = {}) {
  if (setting.size == kSmall) floor.robots /= 3;
  Shot out{floor_camera(setting), std::move(floor), {}};
  out.floor.field = floor_field(setting.size);
  out.picture.add(draw_floor(out.floor, out.camera).view);
  return out;
}

/// A small image of half a field from a slightly tilted camera.
const Shot& half() {
  static const Shot shot = take({kSmall});
  return shot;
}

const Shot& usual_half() {
  static const Shot shot = take({});
  return shot;
}

CalibrationTask clicked(const Shot& shot, const std::vector<std::string>& names) {
  CalibrationTask task;
  task.field = shot.floor.field;
  const auto points = named_points(painted_curves(task.field));
  // People click a few pixels off.
  constexpr double kOffPx[][2] = {{1, 2}, {-2, 1}, {2, -1}, {-1, -2}, {1, -2}, {-2, -1}};
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto point = std::find_if(points.begin(), points.end(),
                                    [&](const NamedPoint& one) { return one.name == names[i]; });
    const auto pixel = shot.camera.project({point->place_mm.x(), point->place_mm.y(), 0});
    task.clicks.push_back({*pixel + Eigen::Vector2d(kOffPx[i][0], kOffPx[i][1]), names[i], {}});
  }
  return task;
}

const std::vector<std::string> kHalfCorners{"halfway line bottom", "halfway line top", "corner right top",
                                            "corner right bottom"};

void swap_pixels(CalibrationTask& task, std::size_t a, std::size_t b) {
  std::swap(task.clicks[a].pixel, task.clicks[b].pixel);
}

/// An image of the whole field and its camera. tile() cuts out a tile of full height.
struct DrawnWhole {
  LensCamera camera;
  PaintedFloor floor;
  FloorPicture drawn;

  explicit DrawnWhole(const FloorSetting& setting) : camera(floor_camera(setting)) {
    floor.field = floor_field(setting.size);
    drawn = draw_floor(floor, camera);
  }
  Shot tile(int x, int width) const {
    Shot out{camera, floor, {}};
    out.camera.width = width;
    out.camera.center_x -= x;
    ImageView view = drawn.view;
    view.data += std::ptrdiff_t{x} * bytes_per_pixel(view.format);
    view.width = width;
    out.picture.add(view);
    out.picture.whole = {camera.width, camera.height, x, 0};
    return out;
  }
};

TEST(Calibrate, ATileKnowsThePictureItIsAPartOf) {
  const Shot tile = DrawnWhole({0, FloorView::kWhole}).tile(360, 420);
  CalibrationTask task = clicked(tile, kHalfCorners);
  task.height_mm = tile.camera.position_mm.z() + 10;
  const CalibrationReport report = calibrate(tile.picture, task);
  EXPECT_TRUE(report.accepted);
  EXPECT_LT(tile.floor_error_mm(report), 0.15);
  EXPECT_LT(tile.robots_error_mm(report), 0.5);
  EXPECT_NEAR(report.calibration.principal_point_x, tile.camera.center_x, 12);
}

TEST(Calibrate, ATileNeedsNoClicks) {
  const DrawnWhole whole({1, FloorView::kWhole, 1.5, 0.4});
  for (const int x : {0, 576}) {
    const Shot tile = whole.tile(x, 704);
    CalibrationTask task;
    task.field = tile.floor.field;
    task.plus_x = PlusX::kRight;
    // Checks the proposal, since refinement hides its errors: lines must be undistorted about the centre of
    // the whole image.
    const Proposal proposal =
        propose_cameras(find_line_pixels(tile.picture, 2), painted_curves(task.field),
                        camera_prior(tile.camera.width, tile.camera.height, tile.picture.whole));
    ASSERT_THAT(proposal.cameras, Not(IsEmpty())) << x;
    const LensCamera& first = proposal.cameras.front();
    const bool turned = !is_right_way_round(first, task);
    EXPECT_LT(field_error_mm(tile.camera, turned ? turned_round(first) : first, task.field, 0), 40) << x;

    const CalibrationReport report = calibrate(tile.picture, task);
    EXPECT_TRUE(report.accepted) << x;
    EXPECT_LT(tile.floor_error_mm(report), 0.15) << x;
    EXPECT_NEAR(report.calibration.principal_point_x, tile.camera.center_x, 12) << x;
  }
}

TEST(Calibrate, FindsTheCameraFromFourClicks) {
  CalibrationTask task = clicked(usual_half(), kHalfCorners);
  task.height_mm = usual_half().camera.position_mm.z() + 8;
  task.height_sigma_mm = 10;
  const CalibrationReport report = calibrate(usual_half().picture, task);
  EXPECT_TRUE(report.accepted);
  EXPECT_THAT(report.problems, IsEmpty());
  EXPECT_LT(usual_half().floor_error_mm(report), 0.15);
  EXPECT_LT(usual_half().robots_error_mm(report), 0.5);
  EXPECT_GT(report.found_share, 0.95);
  EXPECT_LT(report.rms_px, 0.05);
  // The reported errors have the right order of magnitude.
  EXPECT_LT(usual_half().floor_error_mm(report), 2 * report.expected_on_floor_mm);
  EXPECT_LT(report.expected_on_floor_mm, 0.2);
  EXPECT_LT(usual_half().robots_error_mm(report), 2 * report.expected_at_150_mm);
  EXPECT_THAT(report.line_figures, Not(IsEmpty()));
  EXPECT_THAT(report.error_map, Not(IsEmpty()));
  EXPECT_THAT(report.control_points, Not(IsEmpty()));
  EXPECT_GT(report.coverage, 0.5);
  EXPECT_LE(report.coverage, 1);
  EXPECT_GT(report.condition, 1);
  // The published calibration describes the same camera.
  const CameraModel wire(report.calibration);
  EXPECT_LT((wire.position_mm() - report.camera.position_mm).norm(), 1e-3);
}

TEST(Calibrate, TakesClicksInAnyOrder) {
  CalibrationTask task = clicked(half(), kHalfCorners);
  swap_pixels(task, 0, 2);
  swap_pixels(task, 1, 2);
  const CalibrationReport report = calibrate(half().picture, task);
  EXPECT_TRUE(report.accepted);
  EXPECT_LT(half().floor_error_mm(report), 0.15);
  EXPECT_THAT(report.notes, Contains(HasSubstr("did not match their names")));
}

TEST(Calibrate, TakesAnyNamedPointsAndPlacesInMillimetres) {
  CalibrationTask task = clicked(half(), {"circle top", "circle bottom", "defence area right top",
                                          "corner right bottom", "halfway line top"});
  for (ClickedPoint& click : task.clicks) {
    if (click.name != "circle top") continue;
    click.name.clear();
    click.place_mm = {0, 245};
  }
  const CalibrationReport report = calibrate(half().picture, task);
  EXPECT_TRUE(report.accepted);
  EXPECT_LT(half().floor_error_mm(report), 0.15);
}

/// A small image of the whole field from a camera tilted to one side.
const Shot& tilted() {
  static const Shot shot = take({kSmall, FloorView::kWhole, 40, 0.05});
  return shot;
}

TEST(Calibrate, TakesAnyNumberOfClicksFromATiltedCamera) {
  const std::vector<std::string> names{"corner left bottom",  "corner right top",    "corner left top",
                                       "corner right bottom", "halfway line bottom", "goal line middle left"};
  for (const std::size_t count : {3, 4, 6}) {
    CalibrationTask task =
        clicked(tilted(), {names.begin(), names.begin() + static_cast<std::ptrdiff_t>(count)});
    for (const bool is_named : {true, false}) {
      if (!is_named) {
        for (ClickedPoint& click : task.clicks) click.name.clear();
        task.plus_x = PlusX::kRight;
      }
      const CalibrationReport report = calibrate(tilted().picture, task);
      EXPECT_TRUE(report.accepted) << count;
      EXPECT_LT(tilted().floor_error_mm(report), 0.3) << count;
    }
  }
}

TEST(Calibrate, FindsOutWhichPointsWereClicked) {
  CalibrationTask task = clicked(half(), kHalfCorners);
  for (ClickedPoint& click : task.clicks) click.name.clear();
  task.plus_x = PlusX::kUp;
  const CalibrationReport report = calibrate(half().picture, task);
  EXPECT_TRUE(report.accepted);
  EXPECT_LT(half().floor_error_mm(report), 0.15);
}

TEST(Calibrate, NeedsNoClicks) {
  CalibrationTask task;
  task.field = half().floor.field;
  task.plus_x = PlusX::kUp;
  const CalibrationReport report = calibrate(half().picture, task);
  EXPECT_TRUE(report.accepted);
  EXPECT_LT(half().floor_error_mm(report), 0.15);
}

TEST(Calibrate, SaysWhenBothEndsLookAlike) {
  CalibrationTask task;
  task.field = half().floor.field;
  const CalibrationReport report = calibrate(half().picture, task);
  EXPECT_THAT(report.notes, Contains(HasSubstr("Both ends of the field look alike")));
  task.plus_x = PlusX::kDown;
  const CalibrationReport other = calibrate(half().picture, task);
  ASSERT_TRUE(other.found);
  EXPECT_THAT(other.notes, Not(Contains(HasSubstr("look alike"))));
  // The field is turned by 180 degrees.
  const auto place = other.camera.unproject({300, 200}, 0), truth = half().camera.unproject({300, 200}, 0);
  EXPECT_LT((*place + *truth).norm(), 1);
}

/// `wrong`: 0 is a point on the halfway line, 3 a corner. `names_swapped`: of two of the correct clicks.
void expect_wrong_click_named(std::size_t wrong, bool names_swapped) {
  SCOPED_TRACE(testing::Message() << wrong << (names_swapped ? ", names swapped" : ""));
  CalibrationTask task = clicked(half(), kHalfCorners);
  task.clicks[wrong].pixel += Eigen::Vector2d(37, -48);
  if (names_swapped) std::swap(task.clicks[1].name, task.clicks[2].name);
  const CalibrationReport report = calibrate(half().picture, task);
  EXPECT_LT(half().floor_error_mm(report), 0.15);
  ASSERT_EQ(report.click_figures.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(report.click_figures[i].suspect, i == wrong) << i;
  EXPECT_THAT(report.problems, Contains(HasSubstr("Point " + std::to_string(wrong + 1))));
}

TEST(Calibrate, AWrongClickIsNamedAndDoesNoHarm) {
  for (const std::size_t wrong : {0U, 3U}) {
    expect_wrong_click_named(wrong, false);
    expect_wrong_click_named(wrong, true);
  }
}

TEST(Calibrate, NamesUnobservableParameters) {
  const Shot shot = take({kSmall, FloorView::kHalf, 0, 0.08, 0});
  const CalibrationReport report = calibrate(shot.picture, clicked(shot, kHalfCorners));
  EXPECT_TRUE(report.accepted);
  EXPECT_LT(shot.floor_error_mm(report), 0.15);
  EXPECT_THAT(report.held, Contains("height"));
  EXPECT_THAT(report.held, Contains("focal length"));
  EXPECT_THAT(report.notes, Contains(HasSubstr("not observable from this view")));
  EXPECT_LT(shot.robots_error_mm(report), 2 * report.expected_at_150_mm);
}

TEST(Calibrate, TakesTheHeightFromTheLens) {
  const Shot shot = take({kSmall, FloorView::kHalf, 0, 0.08, 0});
  CalibrationTask task = clicked(shot, kHalfCorners);
  task.focal_px = 1.01 * shot.camera.focal_px;
  const CalibrationReport report = calibrate(shot.picture, task);
  EXPECT_TRUE(report.accepted);
  EXPECT_NEAR(report.height_mm, shot.camera.position_mm.z(), 0.03 * shot.camera.position_mm.z());
}

TEST(Calibrate, BendsWithALensOfTwoTerms) {
  const Shot shot = take({0, FloorView::kHalf, 1.5, 0.1, 0.05});
  CalibrationTask task = clicked(shot, kHalfCorners);
  task.height_mm = shot.camera.position_mm.z();
  const CalibrationReport report = calibrate(shot.picture, task);
  EXPECT_TRUE(report.accepted);
  EXPECT_LT(shot.floor_error_mm(report), 0.15);
  EXPECT_GT(report.lens_rms_mm, 0.05) << "what the wire cannot say";
  const CameraModel wire(report.calibration);
  const auto place = wire.unproject({390, 290}, 0), truth = shot.camera.unproject({390, 290}, 0);
  EXPECT_LT((*place - *truth).norm(), report.lens_worst_mm + 0.15);
}

TEST(Calibrate, FindsOutWhatTheSizesWereMeasuredTo) {
  for (const LinesMeasured measured : {LinesMeasured::kToMiddle, LinesMeasured::kToOuterEdge}) {
    PaintedFloor floor;
    floor.measured = measured;
    const Shot shot = take({kSmall}, floor);
    CalibrationTask task = clicked(shot, kHalfCorners);
    CalibrationReport report = calibrate(shot.picture, task);
    EXPECT_EQ(report.measured, measured);
    EXPECT_LT(shot.worst_line_error_mm(report), 0.5);
    const auto says_so = Contains(HasSubstr("between centres this field is 3015 x 2015 mm"));
    if (measured == LinesMeasured::kToOuterEdge) {
      EXPECT_THAT(report.notes, says_so);
    } else {
      EXPECT_THAT(report.notes, Not(says_so));
    }
    task.measured =
        measured == LinesMeasured::kToMiddle ? LinesMeasured::kToOuterEdge : LinesMeasured::kToMiddle;
    report = calibrate(shot.picture, task);
    EXPECT_EQ(report.measured, *task.measured) << "as told";
    EXPECT_GT(shot.worst_line_error_mm(report), 1);
  }
}

/// A square of lines and its crossings. If it is half a line width larger or smaller, it looks the same from
/// a slightly different distance.
Shot take_square(LinesMeasured measured) {
  Shot out{floor_camera({kSmall}), {}, {}};
  FieldSize& field = out.floor.field = floor_field(kSmall);
  field.field_length = field.field_width;
  field.penalty_area_depth = field.penalty_area_width = field.center_circle_radius = 0;
  out.floor.measured = measured;
  out.floor.robots = 4;
  out.picture.add(draw_floor(out.floor, out.camera).view);
  return out;
}

TEST(Calibrate, AssumesLinesMeasuredToTheirMiddleWhereTheyDoNotTell) {
  const Shot by_rules = take_square(LinesMeasured::kToMiddle);
  CalibrationReport report = calibrate(by_rules.picture, clicked(by_rules, kHalfCorners));
  EXPECT_EQ(report.measured, LinesMeasured::kToMiddle);
  EXPECT_LT(by_rules.worst_line_error_mm(report), 0.5);

  const Shot other = take_square(LinesMeasured::kToOuterEdge);
  CalibrationTask task = clicked(other, kHalfCorners);
  report = calibrate(other.picture, task);
  EXPECT_EQ(report.measured, LinesMeasured::kToMiddle);
  EXPECT_NEAR(other.worst_line_error_mm(report), std::hypot(5, 5), 0.5)
      << "at a corner, half a line either way";
  task.measured = LinesMeasured::kToOuterEdge;
  report = calibrate(other.picture, task);
  EXPECT_LT(other.worst_line_error_mm(report), 0.5) << "told so";
}

TEST(Calibrate, UnevenPaintDoesNotPassForLinesMeasuredToTheirOuterEdge) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    PaintedFloor floor;
    floor.wavy_mm = 1.5;
    floor.shifted_mm = 1;
    floor.seed = seed;
    const Shot shot = take({kSmall}, floor);
    EXPECT_EQ(calibrate(shot.picture, clicked(shot, kHalfCorners)).measured, LinesMeasured::kToMiddle)
        << seed;
  }
}

TEST(Calibrate, UnevenTapeInALargeImageIsAcceptedAndSaid) {
  double squares = 0, expected_squares = 0;
  for (const unsigned seed : {1U, 2U, 3U, 4U}) {
    PaintedFloor floor;
    floor.wavy_mm = 5.5;
    floor.shifted_mm = 2;
    floor.seed = seed;
    const Shot shot = take({1, FloorView::kQuarter, 8, 0.2}, floor);
    ASSERT_GT(shot.camera.px_per_mm(), 0.25) << "a pixel is small";
    CalibrationTask task =
        clicked(shot, {"centre", "halfway line top", "corner right top", "goal line middle right"});
    task.height_mm = shot.camera.position_mm.z();
    const CalibrationReport report = calibrate(shot.picture, task);
    EXPECT_GT(report.rms_px, kMaxRmsPx) << seed;
    EXPECT_TRUE(report.accepted) << seed;
    EXPECT_THAT(report.notes, Contains(HasSubstr("may be uneven"))) << seed;
    const double error_mm = shot.floor_error_mm(report);
    squares += error_mm * error_mm;
    expected_squares += report.expected_on_floor_mm * report.expected_on_floor_mm;
  }
  const double ratio = std::sqrt(squares / expected_squares);
  EXPECT_GT(ratio, 0.5) << "the expected error is right within a factor of 2";
  EXPECT_LT(ratio, 2);
}

/// A camera over a defence area of Division A, which looks like a smaller one of Division B.
TEST(Calibrate, DoesNotGuessTheScaleOfADefenceArea) {
  const auto& large = field_preset("division-a", "");
  Shot shot{floor_camera({}), {}, {}};
  shot.floor.field = large;
  constexpr double kPxPerMm = 0.132;  // the area fills the image
  shot.camera.position_mm = {5100, 0, shot.camera.focal_px / kPxPerMm};
  shot.picture.add(draw_floor(shot.floor, shot.camera).view);
  CalibrationTask task;
  for (const NamedPoint& point : named_points(painted_curves(large))) {
    const auto pixel = shot.camera.project({point.place_mm.x(), point.place_mm.y(), 0});
    if (point.place_mm.x() > 4000 && pixel && shot.camera.is_in_picture(*pixel))
      task.clicks.push_back({*pixel, point.name, {}});
  }
  ASSERT_GE(task.clicks.size(), 4u);
  for (const char* division : {"division-a", "division-b"}) {
    task.field = field_preset(division, "");
    const CalibrationReport report = calibrate(shot.picture, task);
    EXPECT_FALSE(report.accepted) << division;
    EXPECT_THAT(report.problems, Contains(HasSubstr("give its height"))) << division;
  }
  task.field = large;
  task.height_mm = shot.camera.position_mm.z() + 20;
  const CalibrationReport report = calibrate(shot.picture, task);
  EXPECT_TRUE(report.accepted);
  EXPECT_LT(shot.floor_error_mm(report), 1);
}

TEST(Calibrate, DoesWithoutSomeLines) {
  PaintedFloor floor;
  floor.missing = {"CenterLine", "CenterCircle", "TopTouchLine"};
  floor.measured = LinesMeasured::kToOuterEdge;
  const Shot shot = take({}, floor);
  CalibrationTask task = clicked(shot, kHalfCorners);
  task.measured = floor.measured;  // too few lines to detect this
  const CalibrationReport report = calibrate(shot.picture, task);
  EXPECT_TRUE(report.accepted);
  EXPECT_LT(shot.floor_error_mm(report), 0.2);
}

TEST(Calibrate, SeesPartsOfFieldsAndRobotsOnLines) {
  PaintedFloor floor;
  floor.robots = 16;
  floor.robots_on_lines = true;
  const Shot quarter = take({0, FloorView::kQuarter, 1.5, 0.2, 0}, floor);
  const CalibrationReport report = calibrate(
      quarter.picture,
      clicked(quarter, {"centre", "halfway line top", "corner right top", "goal line middle right"}));
  EXPECT_TRUE(report.accepted);
  EXPECT_LT(quarter.floor_error_mm(report), 0.15);

  const Shot whole = take({0, FloorView::kWhole, 25, 0.08, 0}, floor);
  const CalibrationReport other = calibrate(
      whole.picture,
      clicked(whole, {"corner left bottom", "corner left top", "corner right top", "corner right bottom"}));
  EXPECT_TRUE(other.accepted);
  EXPECT_LT(whole.floor_error_mm(other), 0.2);
}

TEST(Calibrate, StartsFromExactClicksAtATiltedCamera) {
  const Shot shot = take({0, FloorView::kWhole, 25, 0.08, 0});
  CalibrationTask task =
      clicked(shot, {"corner left bottom", "corner left top", "corner right top", "corner right bottom"});
  task.click_sigma_px = 0.3;  // less than their real error
  const CalibrationReport report = calibrate(shot.picture, task);
  EXPECT_TRUE(report.accepted);
  EXPECT_LT(shot.floor_error_mm(report), 0.2);
}

TEST(Calibrate, DoesNotAcceptAFieldOfAnotherSize) {
  for (const double scale : {0.9, 1.1}) {
    CalibrationTask task;
    task.field = half().floor.field;
    task.field.field_length = static_cast<int>(scale * task.field.field_length);
    task.plus_x = PlusX::kUp;
    const CalibrationReport report = calibrate(half().picture, task);
    EXPECT_FALSE(report.accepted) << scale;
    EXPECT_THAT(report.problems, Not(IsEmpty()));
  }
}

TEST(Calibrate, DoesNotAcceptAPictureWithoutAField) {
  PaintedFloor bare;
  bare.robots = 4;
  for (const FieldLine& line : field_lines(floor_field(kSmall))) bare.missing.push_back(line.name);
  bare.missing.push_back("CenterCircle");
  const LensCamera camera = floor_camera({kSmall});
  bare.field = floor_field(kSmall);
  MeanPicture picture;
  picture.add(draw_floor(bare, camera).view);
  CalibrationTask task;
  task.field = bare.field;
  const CalibrationReport report = calibrate(picture, task);
  EXPECT_FALSE(report.accepted);
  EXPECT_THAT(report.problems, Not(IsEmpty()));
}

TEST(Calibrate, ComparesWithThePreviousOne) {
  CalibrationTask task = clicked(half(), kHalfCorners);
  const CalibrationReport first = calibrate(half().picture, task);
  ASSERT_TRUE(first.found);
  EXPECT_FALSE(first.moved_on_floor_mm);
  task.previous = first.calibration;
  task.previous->principal_point_x += 2;
  const CalibrationReport second = calibrate(half().picture, task);
  ASSERT_TRUE(second.moved_on_floor_mm);
  EXPECT_GT(*second.moved_on_floor_mm, 5);
  EXPECT_LT(*second.moved_on_floor_mm, 30);
}

TEST(Calibrate, RefusesTooFewAndUnknownClicks) {
  CalibrationTask task = clicked(half(), kHalfCorners);
  task.clicks.resize(2);
  EXPECT_THROW(calibrate(half().picture, task), SettingsError);
  task = clicked(half(), kHalfCorners);
  task.clicks[1].name = "corner";
  try {
    calibrate(half().picture, task);
    FAIL();
  } catch (const SettingsError& error) {
    EXPECT_THAT(error.what(), HasSubstr("/points/1/name: \"corner\" is not a point of this field"));
    EXPECT_THAT(error.what(), HasSubstr("\"corner left top\""));
  }
}

TEST(Calibrate, StopsOnRequest) {
  std::stop_source source;
  source.request_stop();
  const CalibrationReport report =
      calibrate(half().picture, clicked(half(), kHalfCorners), source.get_token());
  EXPECT_FALSE(report.found);
}

}  // namespace
}  // namespace sslv::calibrate_test
