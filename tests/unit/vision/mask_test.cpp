// SPDX-License-Identifier: Apache-2.0
#include "vision/mask.h"

#include "base/error.h"

#include <random>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::mask_test {
namespace {

using Interval = Mask::Interval;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

MaskPolygon rectangle(double left, double top, double right, double bottom) {
  return {{{left, top}, {right, top}, {right, bottom}, {left, bottom}}};
}

TEST(Mask, NothingSetMeansEverything) {
  const Mask mask;
  for (const int y : {0, 1, 579, 16'383}) {
    EXPECT_THAT(mask.row(y, 1), ElementsAre(Interval{0, 16'384})) << y;
    EXPECT_THAT(mask.row(y, 2), ElementsAre(Interval{0, 16'384})) << y;
  }
}

TEST(Mask, TakesPixelsWhoseCentreIsInside) {
  const Mask mask({{rectangle(9.6, 1.5, 20.4, 4.5)}, {}});
  EXPECT_THAT(mask.row(1, 1), IsEmpty());
  EXPECT_THAT(mask.row(2, 1), ElementsAre(Interval{10, 21}));
  EXPECT_THAT(mask.row(4, 1), ElementsAre(Interval{10, 21}));
  EXPECT_THAT(mask.row(5, 1), IsEmpty());
  EXPECT_THAT(mask.row(500, 1), IsEmpty());
  // Quads: centres at 0.5, 2.5, 4.5...
  EXPECT_THAT(mask.row(0, 2), IsEmpty());
  EXPECT_THAT(mask.row(1, 2), ElementsAre(Interval{5, 10}));
}

TEST(Mask, ExcludesAfterIncluding) {
  const Mask mask(
      {{rectangle(-5, -5, 100.5, 9.5), rectangle(90.5, -5, 200.5, 9.5)}, {rectangle(49.5, 4.5, 59.5, 99)}});
  EXPECT_THAT(mask.row(0, 1), ElementsAre(Interval{0, 201}));
  EXPECT_THAT(mask.row(5, 1), ElementsAre(Interval{0, 50}, Interval{60, 201}));
  EXPECT_THAT(mask.row(10, 1), IsEmpty());
}

TEST(Mask, ExcludingAloneLeavesTheRest) {
  const Mask mask({{}, {rectangle(9.5, 9.5, 19.5, 19.5)}});
  EXPECT_THAT(mask.row(9, 1), ElementsAre(Interval{0, 16'384}));
  EXPECT_THAT(mask.row(10, 1), ElementsAre(Interval{0, 10}, Interval{20, 16'384}));
  EXPECT_THAT(mask.row(20, 1), ElementsAre(Interval{0, 16'384}));
}

TEST(Mask, ChecksASinglePixel) {
  const Mask mask({{}, {rectangle(-5, -5, 19.5, 9.5)}});
  EXPECT_FALSE(mask.shows(0, 0));
  EXPECT_FALSE(mask.shows(19.4, 9.4));
  EXPECT_TRUE(mask.shows(19.6, 9.4));
  EXPECT_TRUE(mask.shows(19.4, 9.6));
  EXPECT_FALSE(mask.shows(-300, -1e9)) << "as the nearest pixel";
  EXPECT_TRUE(mask.shows(1e9, 0));
  EXPECT_TRUE(Mask().shows(-1, 1e9));
}

/// Reference: whether a point is inside a polygon, by the even-odd rule.
bool inside(const MaskPolygon& polygon, double x, double y) {
  bool odd = false;
  for (std::size_t i = 0; i < polygon.points.size(); ++i) {
    const auto& a = polygon.points[i];
    const auto& b = polygon.points[(i + 1) % polygon.points.size()];
    if ((a[1] <= y) != (b[1] <= y) && x >= a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])) odd = !odd;
  }
  return odd;
}

TEST(Mask, EqualsTheEvenOddRuleForEveryCell) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-10, 60);
  for (int i = 0; i < 300; ++i) {
    MaskSettings settings;
    for (auto* polygons : {&settings.include, &settings.exclude}) {
      for (auto k = random() % 3; k > 0; --k) {
        MaskPolygon& polygon = polygons->emplace_back();
        for (auto p = 3 + random() % 4; p > 0; --p) polygon.points.push_back({place(random), place(random)});
      }
    }
    const Mask mask(settings);
    const auto in_any = [](const std::vector<MaskPolygon>& polygons, double x, double y) {
      for (const MaskPolygon& polygon : polygons) {
        if (inside(polygon, x, y)) return true;
      }
      return false;
    };
    for (const int cell_px : {1, 2}) {
      for (int y = 0; y < 70 / cell_px; ++y) {
        std::vector<bool> expected, found(static_cast<std::size_t>(70 / cell_px));
        for (int x = 0; x < 70 / cell_px; ++x) {
          const double px = x * cell_px + (cell_px - 1) * 0.5, py = y * cell_px + (cell_px - 1) * 0.5;
          expected.push_back((settings.include.empty() || in_any(settings.include, px, py)) &&
                             !in_any(settings.exclude, px, py));
        }
        int last_end = -1;
        for (const Interval interval : mask.row(y, cell_px)) {
          ASSERT_LT(interval.begin, interval.end);
          ASSERT_GT(interval.begin, last_end);  // ascending and disjoint
          last_end = interval.end;
          for (int x = interval.begin; x < std::min<int>(interval.end, 70 / cell_px); ++x)
            found[static_cast<std::size_t>(x)] = true;
        }
        ASSERT_EQ(found, expected) << "case " << i << " row " << y << " of cells of " << cell_px << " px";
      }
    }
  }
}

TEST(Mask, PointsOfAllPolygonsAreCounted) {
  MaskSettings mask;
  mask.include.assign(3, MaskPolygon{std::vector<std::array<double, 2>>(200, {1, 2})});
  mask.exclude.assign(2, MaskPolygon{std::vector<std::array<double, 2>>(200, {1, 2})});
  EXPECT_NO_THROW(check_mask(mask, "/cameras/0/mask"));
  mask.exclude.back().points.push_back({3, 4});
  try {
    check_mask(mask, "/cameras/0/mask");
    FAIL();
  } catch (const SettingsError& error) {
    EXPECT_STREQ(error.what(),
                 "/cameras/0/mask: 1001 points in all polygons are not allowed; expected at most 1000");
  }
}

}  // namespace
}  // namespace sslv::mask_test
