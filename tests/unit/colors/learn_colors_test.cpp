// SPDX-License-Identifier: Apache-2.0
#include "colors/learn_colors.h"

#include "config/backends.h"
#include "config/config.h"
#include "lab/no_sink.h"
#include "pipeline/camera_pipeline.h"
#include "settings/store.h"
#include "support/drawn_scene.h"
#include "support/paths.h"
#include "support/patience.h"
#include "support/test_data.h"

#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>

namespace sslv::test::learn_colors_test {
namespace {

/// Adds both teams to the half of the field that the camera sees; each `turn` has other ids and places.
void add_teams(DrawnScene& drawn, int turn, int yellow = 4, int blue = 4) {
  for (int i = 0; i < yellow + blue; ++i) {
    const bool is_blue = i >= yellow;
    const int id = is_blue ? i - yellow + 4 * turn : i + 4 * turn;
    drawn.add_robot(is_blue ? Team::kBlue : Team::kYellow, id, -100 + 430.0 * (i % 4) * 1.6 + 60 * turn,
                    -1100 + 700.0 * (i / 4) + 90 * turn, 0.7 * i + turn);
  }
}

LearnTask task_of(DrawnScene& drawn) {
  LearnTask task{{drawn.image().view()}, drawn.scene(), league_patterns()};
  return task;
}

const LearntLabel* figures(const LearntColors& learnt, Label label) {
  for (const LearntLabel& one : learnt.labels) {
    if (one.label == label) return &one;
  }
  return nullptr;
}

bool has_note(const LearntColors& learnt, const std::string& part) {
  for (const std::string& note : learnt.notes) {
    if (note.find(part) != std::string::npos) return true;
  }
  return false;
}

/// Expects the learnt table to find robots and a ball at places other than in the image that it was learnt
/// from.
void expect_finds_others(const LearntColors& learnt, const SimulatorOptions& options, int yellow = 4,
                         int blue = 4) {
  ASSERT_EQ(learnt.problem, "");
  DrawnScene other(options);
  add_teams(other, 1, yellow, blue);
  other.add_ball(300, 900);
  other.use_lut(learnt.lut);
  const RobotList robots = other.robots();
  EXPECT_EQ(robots.robots.size(), static_cast<std::size_t>(yellow + blue));
  for (const SimulatedRobot& truth : other.things().robots) {
    EXPECT_TRUE(std::any_of(robots.robots.begin(), robots.robots.end(),
                            [&](const Robot& robot) {
                              return robot.team == truth.team && robot.id == truth.id &&
                                     std::hypot(robot.x_mm - truth.x_mm, robot.y_mm - truth.y_mm) < 5;
                            }))
        << "robot " << truth.id;
  }
  const BallList balls = other.balls();
  ASSERT_EQ(balls.balls.size(), 1u);
  EXPECT_LT(std::hypot(balls.balls[0].x_mm - 300, balls.balls[0].y_mm - 900), 5);
}

struct Condition {
  const char* name;
  PixelFormat format = PixelFormat::kUyvy;
  double light = 1, red_gain = 1, blue_gain = 1, gradient = 0;
};

class LearnsIn : public testing::TestWithParam<Condition> {};

TEST_P(LearnsIn, WithoutAClick) {
  const Condition& c = GetParam();
  SimulatorOptions options = plain_options(c.format, 4);
  options.light = c.light;
  options.red_gain = c.red_gain;
  options.blue_gain = c.blue_gain;
  options.gradient = c.gradient;
  DrawnScene drawn(options);
  add_teams(drawn, 0);
  drawn.add_ball(1000, 600);
  const LearntColors learnt = learn_colors(task_of(drawn));
  EXPECT_EQ(learnt.robots_of(Team::kYellow), 4u);
  EXPECT_EQ(learnt.robots_of(Team::kBlue), 4u);
  EXPECT_EQ(learnt.balls.size(), 1u);
  EXPECT_TRUE(learnt.notes.empty()) << learnt.notes.front();
  for (const LearntRobot& robot : learnt.robots) {
    EXPECT_TRUE(std::any_of(
        drawn.things().robots.begin(), drawn.things().robots.end(),
        [&](const SimulatedRobot& truth) {
          const auto pixel = drawn.scene().camera->project({truth.x_mm, truth.y_mm, truth.height_mm});
          return robot.team == truth.team && robot.id == truth.id && pixel &&
                 std::hypot(pixel->x() - robot.pixel_x, pixel->y() - robot.pixel_y) < 1;
        }))
        << "robot " << robot.id;
  }
  expect_finds_others(learnt, options);
}

INSTANTIATE_TEST_SUITE_P(LearnColors, LearnsIn,
                         testing::Values(Condition{"uyvy"}, Condition{"rgb", PixelFormat::kRgb24},
                                         Condition{"bayer", PixelFormat::kBayerRg8},
                                         Condition{"dim", PixelFormat::kUyvy, 0.3},
                                         Condition{"bright", PixelFormat::kUyvy, 2},
                                         Condition{"warm", PixelFormat::kUyvy, 1, 1.3, 0.7},
                                         Condition{"cold", PixelFormat::kBayerRg8, 1, 0.75, 1.3},
                                         Condition{"uneven", PixelFormat::kUyvy, 1, 1, 1, 0.75}),
                         [](const auto& instance) { return std::string(instance.param.name); });

TEST(LearnColors, FindsTheScaleWithoutACalibration) {
  DrawnScene drawn;
  add_teams(drawn, 0);
  drawn.add_ball(1000, 600);
  const double true_mm = std::sqrt(drawn.scene().camera->mm2_per_px({390, 290}, 140));
  LearnTask task = task_of(drawn);
  Scene scene = drawn.scene();
  scene.camera.reset();
  const LearntColors learnt = learn_colors({task.frames, scene, league_patterns()});
  EXPECT_EQ(learnt.robots.size(), 8u);
  EXPECT_EQ(learnt.balls.size(), 1u);
  EXPECT_NEAR(learnt.mm_per_px, true_mm, 0.03 * true_mm);
  expect_finds_others(learnt, plain_options());
}

TEST(LearnColors, FromPatternsWithACentreDotAwayFromTheCentre) {
  const PatternTable patterns =
      parse_patterns(R"({"name": "lab", "center_diameter_mm": 45, "center": [-25, 15],
      "dot_diameter_mm": 30, "dots": [[45, 20], [10, -50], [-50, -45]],
      "codes": [{"id": 3, "colors": ["pink", "green", "green"]}, {"id": 5, "colors": ["green", "pink", "pink"]}]})",
                     "lab.json");
  const auto draw = [&](DrawnScene& drawn, double turn) {
    drawn.use_patterns(patterns);
    for (int i = 0; i < 4; ++i) {
      drawn.add_robot(i < 2 ? Team::kYellow : Team::kBlue, i % 2 == 0 ? 3 : 5, 300 + 600 * i + 100 * turn,
                      -900 + 200 * turn, 0.7 * i + turn);
    }
  };
  const SimulatorOptions options = plain_options(PixelFormat::kUyvy, 4);
  DrawnScene drawn(options), other(options);
  draw(drawn, 0);
  draw(other, 1);
  const LearntColors learnt = learn_colors({{drawn.image().view()}, drawn.scene(), patterns});
  ASSERT_EQ(learnt.problem, "");
  EXPECT_EQ(learnt.robots_of(Team::kYellow), 2U);
  EXPECT_EQ(learnt.robots_of(Team::kBlue), 2U);
  other.use_lut(learnt.lut);
  const RobotList found = other.robots();
  EXPECT_EQ(found.robots.size(), 4U);
  for (const SimulatedRobot& truth : other.things().robots) {
    EXPECT_TRUE(std::ranges::any_of(found.robots,
                                    [&](const Robot& robot) {
                                      return robot.team == truth.team && robot.id == truth.id &&
                                             std::hypot(robot.x_mm - truth.x_mm, robot.y_mm - truth.y_mm) < 5;
                                    }))
        << "robot " << truth.id;
  }
}

TEST(LearnColors, PredictsTheTeamThatIsNotThere) {
  DrawnScene drawn;
  add_teams(drawn, 0, 0, 6);
  drawn.add_ball(1000, 600);
  const LearntColors learnt = learn_colors(task_of(drawn));
  EXPECT_EQ(learnt.robots_of(Team::kBlue), 6u);
  EXPECT_TRUE(has_note(learnt, "yellow"));
  ASSERT_NE(figures(learnt, label::kYellow), nullptr);
  EXPECT_EQ(figures(learnt, label::kYellow)->seen, 0u);
  expect_finds_others(learnt, plain_options());
}

TEST(LearnColors, TheTeamThatIsNotThereMayHaveDotsOfAnotherMaker) {
  DrawnScene drawn;
  add_teams(drawn, 0, 6, 0);
  drawn.add_ball(1000, 600);
  const LearntColors learnt = learn_colors(task_of(drawn));
  ASSERT_EQ(learnt.problem, "");
  ASSERT_EQ(learnt.robots_of(Team::kBlue), 0u);

  constexpr Rgb kTheirBlue{50, 120, 160};
  DrawnScene other;
  add_teams(other, 1, 0, 4);
  for (const SimulatedRobot& robot : other.things().robots)
    other.cover(robot.x_mm, robot.y_mm, robot.height_mm, 25, kTheirBlue);
  other.use_lut(learnt.lut);
  EXPECT_EQ(other.robots().robots.size(), 4u);
}

TEST(LearnColors, PredictsOrangeWithoutABall) {
  DrawnScene drawn;
  add_teams(drawn, 0);
  const LearntColors learnt = learn_colors(task_of(drawn));
  EXPECT_TRUE(learnt.balls.empty());
  EXPECT_TRUE(has_note(learnt, "orange is predicted"));
  expect_finds_others(learnt, plain_options());
}

TEST(LearnColors, AClickIsUsedInsteadOfAPrediction) {
  DrawnScene drawn;
  add_teams(drawn, 0);
  LearnTask task = task_of(drawn);
  task.guide = {{label::kOrange, {180, 60, 90}}};
  const LearntColors learnt = learn_colors(task);
  EXPECT_FALSE(has_note(learnt, "orange"));
  ASSERT_NE(figures(learnt, label::kOrange), nullptr);
  EXPECT_EQ(figures(learnt, label::kOrange)->guided, 1u);
  EXPECT_EQ(figures(learnt, label::kOrange)->mean, (Rgb{180, 60, 90}));
}

TEST(LearnColors, WrongThingsTeachNothing) {
  FieldSize field;
  field.field_width = 4000;
  DrawnScene plain(plain_options(), overhead_camera(), {140, 140}, field);
  add_teams(plain, 0);
  plain.add_ball(1000, 600);
  const LearntColors without = learn_colors(task_of(plain));

  DrawnScene drawn(plain_options(), overhead_camera(), {140, 140}, field);
  add_teams(drawn, 0);
  drawn.add_ball(1000, 600);
  using Shape = SimulatedDistractor::Shape;
  drawn.add_thing({Shape::kRectangle, label::kYellow, 300, 400, 0.4, 105, 148});  // a card
  drawn.add_thing({Shape::kEllipse, label::kPink, 1700, 600, 0.2, 500, 350});     // a bag
  drawn.add_thing({Shape::kEllipse, paint::kBrown, 600, 700, 0, 43, 43});         // another ball
  drawn.add_thing({Shape::kEllipse, paint::kRed, 600, -300, 0, 43, 43});          // a marker
  drawn.cover(2300, 1000, 1200, 300, {235, 110, 30});                             // a shirt
  drawn.add_ball(1200, 2140);                                                     // beside the field
  const LearntColors with = learn_colors(task_of(drawn));
  EXPECT_EQ(with.robots.size(), without.robots.size());
  ASSERT_EQ(without.balls.size(), 1u);
  ASSERT_EQ(with.balls.size(), 1u);
  EXPECT_NEAR(with.balls[0].pixel_x, without.balls[0].pixel_x, 0.5);
  for (const Label label : {label::kOrange, label::kYellow, label::kBlue, label::kPink, label::kGreen}) {
    const LearntLabel *a = figures(with, label), *b = figures(without, label);
    ASSERT_TRUE(a != nullptr && b != nullptr);
    EXPECT_EQ(a->seen, b->seen) << label::kNames[label];
    EXPECT_NEAR(a->mean.r, b->mean.r, 4) << label::kNames[label];
    EXPECT_NEAR(a->mean.g, b->mean.g, 4) << label::kNames[label];
    EXPECT_NEAR(a->mean.b, b->mean.b, 4) << label::kNames[label];
  }
  expect_finds_others(with, plain_options());
}

/// Orange objects as cones, hands and boards appear from above.
TEST(LearnColors, OrangeThingsOfABallsSizeThatAreNotRoundTeachNoOrange) {
  using Shape = SimulatedDistractor::Shape;
  for (const PixelFormat format : {PixelFormat::kUyvy, PixelFormat::kRgb24, PixelFormat::kBayerRg8}) {
    SCOPED_TRACE(name_of(format));
    DrawnScene drawn(plain_options(format));
    add_teams(drawn, 0);
    drawn.add_thing({Shape::kRectangle, label::kOrange, 300, 400, 0.4, 40, 40});
    drawn.add_thing({Shape::kEllipse, label::kOrange, 1500, 700, 0.9, 48, 34});
    const LearntColors learnt = learn_colors(task_of(drawn));
    for (const auto& ball : learnt.balls)
      ADD_FAILURE() << "no ball at pixel " << ball.pixel_x << ", " << ball.pixel_y;
  }
}

TEST(LearnColors, TooGreenAThingTeachesNoOrange) {
  DrawnScene drawn;
  add_teams(drawn, 0, 0, 8);  // without yellow dots to compare with
  drawn.cover(900, 600, 0, 21, {200, 177, 60});
  EXPECT_TRUE(learn_colors(task_of(drawn)).balls.empty());
}

TEST(LearnColors, OrangeThatIsClippedMayLookGreener) {
  DrawnScene drawn;
  add_teams(drawn, 0, 0, 8);
  drawn.cover(900, 600, 0, 21, {255, 204, 80});  // clipped: the real red is unknown
  EXPECT_EQ(learn_colors(task_of(drawn)).balls.size(), 1u);
}

TEST(LearnColors, IgnoresMaskedPixels) {
  DrawnScene drawn;
  add_teams(drawn, 0);
  MaskSettings settings;
  settings.exclude.push_back({{{515, -1}, {800, -1}, {800, 600}, {515, 600}}});
  const Mask mask(settings);
  LearnTask task = task_of(drawn);
  task.mask = &mask;
  const LearntColors learnt = learn_colors(task);
  EXPECT_LT(learnt.robots.size(), 8u);
  for (const LearntRobot& robot : learnt.robots) EXPECT_LT(robot.pixel_x, 515);
}

TEST(LearnColors, SaysWhatIsMissing) {
  const auto problem_of = [](DrawnScene& drawn) {
    const LearntColors learnt = learn_colors(task_of(drawn));
    EXPECT_EQ(learnt.lut, nullptr);
    return learnt.problem;
  };
  DrawnScene empty;
  empty.add_ball(1000, 600);
  EXPECT_NE(problem_of(empty).find("no robot was found"), std::string::npos) << problem_of(empty);

  DrawnScene one;
  add_teams(one, 0, 1, 0);
  EXPECT_NE(problem_of(one).find("only 1 robot was found"), std::string::npos) << problem_of(one);

  SimulatorOptions options = plain_options();
  options.light = 0.05;
  DrawnScene dark(options);
  add_teams(dark, 0);
  EXPECT_NE(problem_of(dark).find("too dark"), std::string::npos) << problem_of(dark);

  const Scene scene;
  std::vector<std::uint8_t> bytes(3 * 320 * 240, 255);
  ImageView view{bytes.data(), 320, 240, 3 * 320, PixelFormat::kRgb24};
  const auto problem_with = [&] { return learn_colors({{view}, scene, league_patterns()}).problem; };
  EXPECT_NE(problem_with().find("over-exposed: 100 %"), std::string::npos) << problem_with();
  std::fill(bytes.begin(), bytes.end(), 120);
  EXPECT_NE(problem_with().find("is grey"), std::string::npos) << problem_with();
  view.format = PixelFormat::kMono8;
  EXPECT_NE(problem_with().find("pixel format with colours"), std::string::npos) << problem_with();
  EXPECT_EQ(learn_colors({{}, scene, league_patterns()}).problem, "no image was given");
}

TEST(LearnColors, StopsWhenAsked) {
  DrawnScene drawn;
  add_teams(drawn, 0);
  std::stop_source stop;
  stop.request_stop();
  LearnTask task = task_of(drawn);
  task.stop = stop.get_token();
  const LearntColors learnt = learn_colors(task);
  EXPECT_EQ(learnt.problem, "learning was stopped");
  EXPECT_EQ(learnt.lut, nullptr);
}

/// A real photo, also in other light: each channel times a gain.
class RealPhoto {
 public:
  RealPhoto() {
    const Config config = read_config(read_json_file(source_path("/tests/golden/ssl_blue6.json")));
    config_ = config;
    const Backend& files = find_backend("files", "");
    context_ = make_context(config_, 0, std::make_shared<const Lut>());
    const auto source =
        files.open(files.complete(Json{{"path", path().string()}, {"frame_rate_hz", 0}, {"loop", false}}, ""),
                   {0, *context_.scene});
    CapturedImage captured;
    std::string problem;
    if (source->next(captured, problem, test::kPatience) != CaptureStatus::kImage) return;
    view_ = captured.image.view();
    const auto stride = static_cast<std::size_t>(view_.width * bytes_per_pixel(view_.format));
    for (int y = 0; y < view_.height; ++y) bytes_.insert(bytes_.end(), view_.row(y), view_.row(y) + stride);
    view_.stride_bytes = static_cast<std::ptrdiff_t>(stride);
    view_.data = bytes_.data();
  }
  static std::filesystem::path path() { return test_data_folder() / "real/ssl_blue6_win.jpg"; }

  ImageView in_light(const std::array<double, 3>& gains) {
    const bool is_rgb = view_.format == PixelFormat::kRgb24;
    EXPECT_TRUE(is_rgb || view_.format == PixelFormat::kBgr24);
    lit_ = bytes_;
    for (std::size_t i = 0; i < lit_.size(); ++i) {
      const double gain = gains[is_rgb ? i % 3 : 2 - i % 3];
      lit_[i] = static_cast<std::uint8_t>(std::min(255L, std::lround(gain * lit_[i])));
    }
    ImageView out = view_;
    out.data = lit_.data();
    return out;
  }
  LearntColors learn(const ImageView& picture, bool calibrated) const {
    Scene scene = *context_.scene;
    if (!calibrated) scene.camera.reset();
    return learn_colors({{picture}, scene, *context_.patterns});
  }
  /// Runs the camera's stack. Returns the sorted ids of the blue robots, with 'y' for each yellow one, and
  /// the balls.
  std::pair<std::string, BallList> find(const ImageView& picture, std::shared_ptr<const Lut> lut) const {
    CameraSetup setup;
    const CameraSettings& camera = config_.cameras.front();
    setup.pipeline = std::make_shared<Pipeline>(stage_table(), camera.stack, "");
    setup.parameters = setup.pipeline->make_parameters(camera.stages, "");
    setup.context = make_context(config_, 0, std::move(lut));
    NoSink sink;
    CameraPipeline pipeline(0, sink, setup);
    const Frame& frame = pipeline.process(Image(picture, nullptr, nullptr, nullptr), {});
    std::string ids;
    for (const Robot& robot : frame.robots.robots)
      ids += robot.team == Team::kBlue ? static_cast<char>('0' + robot.id) : 'y';
    std::sort(ids.begin(), ids.end());
    return {ids, frame.balls};
  }

 private:
  Config config_;
  CameraContext context_;
  ImageView view_;
  std::vector<std::uint8_t> bytes_, lit_;
};

TEST(LearnColorsFromAPhoto, AllIdsAndOnlyOrangeBalls) {
  if (!std::filesystem::exists(RealPhoto::path()))
    GTEST_SKIP() << "no " << RealPhoto::path() << ": real photos are not part of the project";
  RealPhoto photo;
  const ImageView picture = photo.in_light({1, 1, 1});
  for (const bool calibrated : {true, false}) {
    const LearntColors learnt = photo.learn(picture, calibrated);
    ASSERT_EQ(learnt.problem, "");
    EXPECT_EQ(learnt.robots_of(Team::kBlue), 6u);
    EXPECT_NEAR(learnt.mm_per_px, 3.5, 0.15);
    const auto [ids, balls] = photo.find(picture, learnt.lut);
    EXPECT_EQ(ids, "012456");
    // One ball on the field, one at a post; a pale brown ball may be detected, too.
    EXPECT_GE(balls.balls.size(), 2u);
    for (const Ball& ball : balls.balls) {
      const auto near = [&](double x, double y) {
        return std::hypot(ball.pixel_x - x, ball.pixel_y - y) < 5;
      };
      EXPECT_TRUE(near(1329.5, 429) || near(151.5, 636.3) || near(1110, 1038))
          << ball.pixel_x << ' ' << ball.pixel_y;
    }
    // The same table in slightly more and slightly less light.
    for (const double gain : {0.85, 1.15})
      EXPECT_EQ(photo.find(photo.in_light({gain, gain, gain}), learnt.lut).first, "012456") << gain;
    photo.in_light({1, 1, 1});
  }
}

TEST(LearnColorsFromAPhoto, InOtherLight) {
  if (!std::filesystem::exists(RealPhoto::path()))
    GTEST_SKIP() << "no " << RealPhoto::path() << ": real photos are not part of the project";
  RealPhoto photo;
  for (const std::array<double, 3>& gains : {std::array{0.4, 0.4, 0.4}, std::array{1.25, 1.25, 1.25},
                                             std::array{1.2, 1.0, 0.75}, std::array{0.8, 1.0, 1.2}}) {
    const ImageView picture = photo.in_light(gains);
    const LearntColors learnt = photo.learn(picture, true);
    ASSERT_EQ(learnt.problem, "") << gains[0];
    EXPECT_EQ(photo.find(picture, learnt.lut).first, "012456") << gains[0] << ' ' << gains[2];
  }
}

}  // namespace
}  // namespace sslv::test::learn_colors_test
