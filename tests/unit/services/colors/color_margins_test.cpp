// SPDX-License-Identifier: Apache-2.0
#include "services/colors/color_margins.h"

#include "capture/source.h"
#include "colors/table_edit.h"
#include "support/becomes.h"
#include "support/drawn_scene.h"

#include <atomic>
#include <chrono>
#include <mutex>

#include <gmock/gmock.h>

namespace sslv::color_margins_test {
namespace {

using std::chrono::milliseconds;

/// The drawn scene's table, where every clear cell of at least this luma is green.
std::shared_ptr<const Lut> green_from(DrawnScene& drawn, int luma) {
  ColorTable table = drawn.lut().color_table();
  for (std::size_t cell = 0; cell < table.labels.size(); ++cell) {
    if (table.labels[cell] == label::kClear && table.color_of(cell).y >= luma)
      table.labels[cell] = label::kGreen;
  }
  return std::make_shared<const Lut>(std::move(table));
}

double brighter(const std::optional<std::vector<LabelMargin>>& margins, Label label) {
  for (const LabelMargin& margin : margins.value()) {
    if (margin.label == label && margin.surface == SurfaceKind::kCarpet)
      return margin.brighter.value_or(LabelMargin::kMaxFactor);
  }
  throw std::logic_error("no such label");
}

/// Camera 7, which sees robots and a ball.
class ColorMarginsTest : public ::testing::Test {
 protected:
  ColorMarginsTest() {
    for (int i = 0; i < 4; ++i)
      drawn_.add_robot(i % 2 == 0 ? Team::kYellow : Team::kBlue, i, 600.0 + 400 * i, 200, i);
    drawn_.add_ball(1000, -600);
    robots_ = drawn_.robots().robots;
    balls_ = drawn_.balls().balls;
    lut_ = drawn_.lut_pointer();
    scene_ = std::make_shared<const Scene>(drawn_.scene());
    picture_ = drawn_.image().view();
  }

  ColorMargins::Hooks hooks() {
    ColorMargins::Hooks hooks;
    hooks.wait_frame = [this](int camera_id, std::uint64_t newer_than,
                              milliseconds) -> std::optional<LentFrame> {
      if (gone_) throw CaptureError("no such camera");
      EXPECT_EQ(camera_id, 7);
      ++frames_asked_;
      LentFrame frame{newer_than + 1, nullptr, picture_, 100, robots_};
      if (grey_) frame.image.format = PixelFormat::kMono8;
      frame.balls = balls_;
      return frame;
    };
    hooks.cameras = [this] {
      const std::lock_guard lock(mutex_);
      ++rounds_;
      if (!is_listed_) return std::vector<ColorMargins::Camera>{};
      return std::vector{
          ColorMargins::Camera{7, lut_, scene_, nullptr, {std::shared_ptr<void>(), &league_patterns()}}};
    };
    return hooks;
  }
  template <class Condition>
  void wait_until(const char* what, Condition condition) {
    ASSERT_TRUE(test::becomes(condition)) << what;
  }
  void wait_rounds(int more) {
    const int wanted = rounds_ + more;
    wait_until("rounds", [&] { return rounds_ >= wanted; });
  }

  DrawnScene drawn_;
  ImageView picture_;
  std::vector<Robot> robots_;
  std::vector<Ball> balls_;
  std::atomic<bool> gone_ = false, grey_ = false, is_listed_ = true;
  std::atomic<int> rounds_ = 0, frames_asked_ = 0;
  std::mutex mutex_;  // guards the members below
  std::shared_ptr<const Lut> lut_;
  std::shared_ptr<const Scene> scene_;
};

/// Samples one frame, and more only on request.
constexpr ColorMargins::Pace kOnce{std::chrono::hours(1), milliseconds(1)};

TEST_F(ColorMarginsTest, SeesCarpetWithoutRobots) {
  // A robot under a cover of one colour, as wide as its hull.
  const Rgb pink = paint_color(label::kPink);
  const Robot robot = robots_.front();
  drawn_.cover(robot.x_mm, robot.y_mm, robot.height_mm, 90, pink);
  const auto reach_without = [&](const std::vector<Robot>& robots) {
    const LentFrame frame{1, nullptr, drawn_.image().view(), 100, robots};
    const SurfaceColors surfaces = surfaces_of(frame, *scene_, league_patterns(), nullptr);
    EXPECT_GT(surfaces.total(SurfaceKind::kCarpet), 10'000U);
    return reach_of(surfaces, SurfaceKind::kOther, {.darkest = 0.8, .brightest = 1.2});
  };
  EXPECT_TRUE(reach_without({})(to_yuv(pink)));
  EXPECT_FALSE(reach_without({robot})(to_yuv(pink)));
}

TEST_F(ColorMarginsTest, CountsTheCurrentAndAnEditedTable) {
  ColorMargins margins(hooks(), kOnce);
  wait_until("surfaces", [&] { return margins.surfaces(7) != nullptr; });
  const auto surfaces = margins.surfaces(7);
  EXPECT_GT(brighter(margins.newest_margins(7), label::kGreen), 1.3);
  is_listed_ = false;  // otherwise the current table would be counted repeatedly
  wait_rounds(2);

  const int carpet = to_yuv(paint_color(label::kField)).y;
  const auto thin = green_from(drawn_, carpet * 13 / 10);
  const double thin_margin = brighter(margins.margins(7, *thin), label::kGreen);
  EXPECT_GT(thin_margin, 1.02);
  EXPECT_LT(thin_margin, 1.3);
  EXPECT_EQ(brighter(margins.newest_margins(7), label::kGreen), thin_margin);
  EXPECT_EQ(margins.surfaces(7), surfaces) << "no other frame was looked at";
  EXPECT_EQ(frames_asked_, 1);

  ColorTable table = thin->color_table();
  apply_edit(table, WidenMarginsEdit{surfaces});
  EXPECT_GT(brighter(margins.margins(7, Lut(table)), label::kGreen), 1.3);
}

TEST_F(ColorMarginsTest, FollowsTheCurrentTable) {
  ColorMargins margins(hooks(), kOnce);
  wait_until("surfaces", [&] { return margins.surfaces(7) != nullptr; });
  {
    const std::lock_guard lock(mutex_);
    lut_ = green_from(drawn_, 0);
  }
  wait_until("green carpet", [&] { return brighter(margins.newest_margins(7), label::kGreen) == 1; });
  EXPECT_EQ(frames_asked_, 1);
}

TEST_F(ColorMarginsTest, KeepsItsSurfacesWhileTheSceneIsTheSame) {
  DrawnScene again(plain_options());
  again.expose_again();
  const ImageView steady = again.image().view();
  SimulatorOptions darker = plain_options();
  darker.light = 0.6;
  DrawnScene evening(darker);
  lut_ = green_from(drawn_, to_yuv(paint_color(label::kField)).y * 13 / 10);
  std::atomic<int> shown = 0;
  ColorMargins::Hooks asked = hooks();
  asked.wait_frame = [&, pictures = std::array{picture_, steady, evening.image().view()}](
                         int, std::uint64_t newer_than, milliseconds) -> std::optional<LentFrame> {
    ++frames_asked_;
    return LentFrame{newer_than + 1, nullptr, pictures[static_cast<std::size_t>(shown.load())], 100, {}};
  };
  ColorMargins margins(asked, {milliseconds(1), milliseconds(1)});
  wait_until("surfaces", [&] { return margins.surfaces(7) != nullptr; });
  const auto surfaces = margins.surfaces(7);
  shown = 1;  // the same scene with other noise
  const int before = frames_asked_;
  wait_until("looks", [&] { return frames_asked_ >= before + 3; });
  EXPECT_EQ(margins.surfaces(7), surfaces);
  shown = 2;
  wait_until("other surfaces", [&] { return margins.surfaces(7) != surfaces; });
  EXPECT_GT(brighter(margins.newest_margins(7), label::kGreen), 1.5);
}

TEST_F(ColorMarginsTest, LooksAgainWhenTheSceneChanges) {
  ColorMargins margins(hooks(), kOnce);
  wait_until("surfaces", [&] { return margins.surfaces(7) != nullptr; });
  const auto surfaces = margins.surfaces(7);
  wait_rounds(5);
  EXPECT_EQ(margins.surfaces(7), surfaces);
  {
    const std::lock_guard lock(mutex_);
    scene_ = std::make_shared<const Scene>(*scene_);
  }
  wait_until("other surfaces", [&] { return margins.surfaces(7) != surfaces; });
}

TEST_F(ColorMarginsTest, KnowsNothingOfACameraWithoutColoursAndForgets) {
  grey_ = true;
  ColorMargins margins(hooks(), kOnce);
  wait_rounds(3);
  EXPECT_EQ(margins.surfaces(7), nullptr);
  EXPECT_FALSE(margins.margins(7, *lut_));
  EXPECT_FALSE(margins.newest_margins(7));
  EXPECT_FALSE(margins.newest_margins(8));
  grey_ = false;
  wait_until("surfaces", [&] { return margins.surfaces(7) != nullptr; });

  gone_ = true;
  wait_rounds(2);
  EXPECT_NE(margins.surfaces(7), nullptr) << "what was seen still holds";
  margins.forget({7});
  EXPECT_EQ(margins.surfaces(7), nullptr);
  wait_rounds(3);
  EXPECT_EQ(margins.surfaces(7), nullptr);
  gone_ = false;
  wait_until("surfaces", [&] { return margins.surfaces(7) != nullptr; });
}

}  // namespace
}  // namespace sslv::color_margins_test
