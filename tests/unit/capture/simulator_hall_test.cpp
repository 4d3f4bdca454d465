// SPDX-License-Identifier: Apache-2.0
#include "capture/simulator/simulator_hall.h"

#include "base/error.h"
#include "base/params_json.h"
#include "capture/simulator/simulator.h"
#include "capture/simulator/simulator_camera.h"
#include "capture/simulator/simulator_lamps.h"
#include "capture/simulator/simulator_prints.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::simulator_hall_test {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = 390, kHeight = 290;
constexpr double kTimeS = 1000;

/// A camera that looks straight down from 4 m on a whole field of 3 x 2 m and more than 0.5 m beyond its
/// carpet.
SourceContext context_of(std::uint32_t camera_id = 0) {
  CameraCalibration c;
  c.focal_length = 300;
  c.principal_point_x = 194.5, c.principal_point_y = 144.5;
  c.q0 = 1, c.q3 = 0;
  c.tz = 4000;
  c.pixel_image_width = kWidth, c.pixel_image_height = kHeight;
  SourceContext context;
  context.camera_id = camera_id;
  context.scene.camera.emplace(c);
  context.scene.field.field_length = 3000;
  context.scene.field.field_width = 2000;
  return context;
}

/// Options for an empty field without noise and vignette, overridden by `json`.
SimulatorOptions options_of(const Json& json) {
  Json all{{"width", kWidth},    {"height", kHeight}, {"pixel_format", "rgb24"},
           {"robots_yellow", 0}, {"robots_blue", 0},  {"balls", 0},
           {"noise_sigma", 0},   {"vignette", 0},     {"blur_sigma_px", 0.5}};
  all.merge_patch(json);
  return simulator_options(all, "/source");
}

struct Picture {
  std::vector<std::uint8_t> bytes;

  double at(int x, int y, int channel) const {
    return bytes[static_cast<std::size_t>(3 * (y * kWidth + x) + channel)];
  }
  /// BT.601.
  double luma(int x, int y) const { return 0.299 * at(x, y, 0) + 0.587 * at(x, y, 1) + 0.114 * at(x, y, 2); }
};

Picture draw(const SimulatorOptions& options, double t_s = kTimeS, std::uint32_t camera_id = 0) {
  SimulatedCamera camera(options, context_of(camera_id), league_patterns());
  Picture out{std::vector<std::uint8_t>(camera.picture_bytes())};
  camera.draw(t_s, out.bytes.data());
  return out;
}
Picture draw(const Json& json, double t_s = kTimeS, std::uint32_t camera_id = 0) {
  return draw(options_of(json), t_s, camera_id);
}

Eigen::Vector2i pixel_of(double x_mm, double y_mm) {
  const SourceContext context = context_of();
  const Eigen::Vector2d pixel = *context.scene.camera->project({x_mm, y_mm, 0});
  return {static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y()))};
}

/// Calls `use` for each pixel of a rectangle on the floor, by default inside the field's lines.
template <class Use>
void each_pixel(const Use& use, double x_mm = 1440, double y_mm = 940, double from_x_mm = -1440,
                double from_y_mm = -940) {
  const Eigen::Vector2i a = pixel_of(from_x_mm, from_y_mm), b = pixel_of(x_mm, y_mm);
  for (int y = std::min(a.y(), b.y()); y <= std::max(a.y(), b.y()); ++y) {
    for (int x = std::min(a.x(), b.x()); x <= std::max(a.x(), b.x()); ++x) use(x, y);
  }
}

struct Statistics {
  double mean = 0, deviation = 0;
};
Statistics statistics_of(const std::vector<double>& values) {
  Statistics out;
  for (const double value : values) out.mean += value / static_cast<double>(values.size());
  for (const double value : values) out.deviation += (value - out.mean) * (value - out.mean);
  out.deviation = std::sqrt(out.deviation / static_cast<double>(values.size()));
  return out;
}

/// Statistics of a piece of carpet without lines.
template <class ValueOf>
Statistics on_carpet(const ValueOf& value_of) {
  std::vector<double> values;
  each_pixel([&](int x, int y) { values.push_back(value_of(x, y)); }, 1400, 900, 600, 20);
  return statistics_of(values);
}

Json hall(const Json& json) {
  return {{"hall", json}};
}

// ---- options

TEST(SimulatorHall, PlainEqualsTheOriginalScene) {
  // Means of cells of 65 x 58 pixels, recorded before halls were added.
  constexpr std::array<std::array<double, 3>, 30> kBefore{
      {{84.13, 81.34, 77.29}, {78.21, 86.66, 77.89}, {78.38, 86.90, 78.09}, {78.71, 87.16, 78.35},
       {77.12, 85.62, 76.89}, {84.09, 81.33, 77.27}, {80.92, 82.01, 76.40}, {33.06, 93.68, 64.26},
       {35.14, 94.55, 65.64}, {36.95, 92.61, 64.90}, {32.93, 92.71, 63.85}, {83.71, 84.82, 79.02},
       {81.40, 82.36, 76.79}, {34.71, 91.16, 62.93}, {37.80, 94.16, 67.26}, {38.71, 97.68, 68.62},
       {33.36, 88.85, 61.77}, {82.25, 83.24, 77.59}, {81.11, 82.20, 76.58}, {32.39, 91.64, 62.88},
       {34.74, 93.25, 64.78}, {35.72, 95.05, 66.18}, {32.79, 92.88, 63.71}, {81.45, 82.51, 76.87},
       {84.16, 81.39, 77.33}, {75.90, 84.01, 75.54}, {78.26, 86.59, 77.87}, {77.97, 86.60, 77.77},
       {78.12, 86.51, 77.76}, {84.95, 82.12, 78.03}}};
  const Json scene{{"robots_yellow", 2}, {"robots_blue", 2}, {"balls", 2},
                   {"distractors", 4},   {"seed", 7},        {"vignette", 0.1}};
  const Picture picture = draw(scene);
  for (std::size_t cell = 0; cell < kBefore.size(); ++cell) {
    const int left = 65 * static_cast<int>(cell % 6), top = 58 * static_cast<int>(cell / 6);
    for (int c = 0; c < 3; ++c) {
      double mean = 0;
      for (int y = top; y < top + 58; ++y) {
        for (int x = left; x < left + 65; ++x) mean += picture.at(x, y, c) / (65 * 58);
      }
      EXPECT_NEAR(mean, kBefore[cell][static_cast<std::size_t>(c)], 0.006) << "cell " << cell;
    }
  }
  Json other_seed = scene;
  other_seed["hall"] = {{"kind", "plain"}, {"seed", 9}};
  EXPECT_EQ(draw(other_seed).bytes, picture.bytes) << "a plain hall has nothing that a seed could change";
}

TEST(SimulatorHall, TheKindFillsInOnlyMissingOptions) {
  for (const auto& kind : kHallKindChoices) {
    HallOptions given;
    given.kind = kind.value;
    given.seed = 5;
    given.carpet.seams = 0.77;
    given.around.people = 3;
    const HallOptions all = resolved(given);
    EXPECT_EQ(all.carpet.seams, 0.77);
    EXPECT_EQ(all.around.people, 3);
    EXPECT_EQ(all.kind, kind.value);
    EXPECT_EQ(all.seed, 5);
    EXPECT_THAT(params_to_json(all).dump(), testing::Not(HasSubstr("null")));
    EXPECT_EQ(params_to_json(resolved(all)), params_to_json(all));
  }
  HallOptions hard;
  hard.kind = HallKind::kHard;
  std::set<int> reds;
  std::set<HallFloor> floors;
  for (hard.seed = 0; hard.seed < 30; ++hard.seed) {
    reds.insert(*resolved(hard).carpet.red);
    floors.insert(*resolved(hard).around.floor);
  }
  EXPECT_GE(reds.size(), 4U);
  EXPECT_EQ(floors.size(), 3U);
}

TEST(SimulatorHall, SettingsKeepMissingOptionsAndRefuseAnEmptyFlickerRange) {
  const Json complete = simulator_backend().complete(hall({{"kind", "usual"}}), "/source");
  EXPECT_TRUE(complete["hall"]["carpet"]["blotches"].is_null()) << "another kind would change nothing";
  try {
    options_of(hall({{"kind", "usual"}, {"lamps", {{"flicker_low", 2}}}}));
    FAIL() << "no error";
  } catch (const SettingsError& error) {
    EXPECT_STREQ(error.what(),
                 "/source/hall/lamps/flicker_low: 2.0 is not allowed; expected no more than flicker_high, "
                 "which is 1.33");
  }
}

// ---- carpet

TEST(SimulatorHall, AUsualCarpetScattersAsRealOnesDo) {
  // Standard deviations of other renderers' carpets, measured with noise of sigma 4 and YUV of pixel pairs: Y
  // about 9, U 3, V 4.5.
  const auto scatter_with = [](const Json& hall_options, int at) {
    Json json = hall(hall_options);
    json.update({{"noise_sigma", 4}, {"pixel_format", "uyvy"}});
    SimulatedCamera camera(options_of(json), context_of(), league_patterns());
    std::vector<std::uint8_t> bytes(camera.picture_bytes());
    camera.draw(kTimeS, bytes.data());
    std::vector<double> values;
    each_pixel(
        [&](int x, int y) {
          if (x % 2 == 0) values.push_back(bytes[static_cast<std::size_t>(2 * (y * kWidth + x) + at)]);
        },
        1400, 900, 600, 20);
    return statistics_of(values).deviation;
  };
  const Json usual{{"kind", "usual"},
                   {"carpet", {{"red", 34}, {"green", 98}, {"blue", 48}, {"seams", 0}}},
                   {"lamps", {{"uneven", 0}, {"flicker_low", 1}, {"flicker_high", 1}, {"banding", 0}}}};
  EXPECT_NEAR(scatter_with(usual, 1), 9, 1.5);
  EXPECT_NEAR(scatter_with(usual, 0), 3, 0.5);
  EXPECT_NEAR(scatter_with(usual, 2), 4.5, 0.7);
  EXPECT_LT(scatter_with({{"kind", "plain"}}, 1), 5);
}

TEST(SimulatorHall, BlotchesScatterByTheirShareOverPlacesOfTheirSize) {
  const auto with = [](double blotches) {
    return draw(hall({{"carpet", {{"blotches", blotches}, {"blotch_mm", 150}}}}));
  };
  const Picture none = with(0), some = with(0.1), many = with(0.2);
  const auto ratio_to_none = [&](const Picture& picture) {
    return on_carpet([&](int x, int y) { return picture.at(x, y, 1) / none.at(x, y, 1); });
  };
  EXPECT_NEAR(ratio_to_none(some).deviation, 0.1, 0.02);
  EXPECT_NEAR(ratio_to_none(many).deviation, 0.2, 0.04);
  EXPECT_NEAR(ratio_to_none(some).mean, 1, 0.05);
  // The factor is nearly the same 13 mm away, and not 400 mm away.
  const auto change_over = [&](int pixels) {
    return on_carpet([&](int x, int y) {
             return some.at(x, y, 1) / none.at(x, y, 1) -
                    some.at(x - pixels, y, 1) / none.at(x - pixels, y, 1);
           })
        .deviation;
  };
  EXPECT_LT(change_over(1), 0.05);
  EXPECT_GT(change_over(30), 0.1);
}

TEST(SimulatorHall, TintScattersTheHueAndLeavesGreen) {
  const Picture none = draw(hall({{"carpet", {{"tint", 0}}}})),
                some = draw(hall({{"carpet", {{"tint", 0.2}}}}));
  const auto deviation = [&](int channel) {
    return on_carpet([&](int x, int y) { return some.at(x, y, channel) / none.at(x, y, channel); }).deviation;
  };
  EXPECT_NEAR(deviation(0), 0.2, 0.05);
  EXPECT_NEAR(deviation(2), 0.1, 0.03);
  EXPECT_LT(deviation(1), 0.001);
}

TEST(SimulatorHall, SeamsAreLinesBetweenStrips) {
  const Json carpet{{"strip_mm", 700}, {"seams", 0.6}, {"strip_step", 0.1}};
  const Picture none = draw(Json::object()), seams = draw(hall({{"carpet", carpet}}));
  // Seams run along x or y, depending on the seed: whole rows or columns differ there.
  const auto mean_at = [&](bool along_x, double across_mm) {
    std::vector<double> ratios;
    for (double along_mm = -800; along_mm <= 800; along_mm += 20) {
      const Eigen::Vector2i p = along_x ? pixel_of(along_mm, across_mm) : pixel_of(across_mm, along_mm);
      ratios.push_back(seams.luma(p.x(), p.y()) / none.luma(p.x(), p.y()));
    }
    return statistics_of(ratios);
  };
  const bool along_x = std::abs(mean_at(true, 700).mean - mean_at(true, 660).mean) >
                       std::abs(mean_at(false, 700).mean - mean_at(false, 660).mean);
  for (const double seam_mm : {-700.0, 700.0}) {
    const double beside = (mean_at(along_x, seam_mm - 60).mean + mean_at(along_x, seam_mm + 60).mean) / 2;
    EXPECT_GT(std::abs(mean_at(along_x, seam_mm).mean - beside), 0.1);
  }
  const std::array strips{mean_at(along_x, -350).mean, mean_at(along_x, 350).mean};
  EXPECT_GT(std::abs(strips[0] - strips[1]), 0.005);
  for (const double strip : strips) EXPECT_NEAR(strip, 1, 0.1);
}

TEST(SimulatorHall, WornCarpetIsPaleBeforeTheGoals) {
  const Picture fresh = draw(Json::object()), worn = draw(hall({{"carpet", {{"wear", 1}}}}));
  const auto saturation = [](const Picture& picture, double x_mm, double y_mm) {
    const Eigen::Vector2i p = pixel_of(x_mm, y_mm);
    return 1 - picture.at(p.x(), p.y(), 0) / picture.at(p.x(), p.y(), 1);
  };
  EXPECT_LT(saturation(worn, 750, 60), 0.8 * saturation(fresh, 750, 60));
  each_pixel([&](int x, int y) { EXPECT_GE(worn.luma(x, y), fresh.luma(x, y) - 1); });
}

TEST(SimulatorHall, ShineAddsLightWhereALampIsMirrored) {
  const Picture dull = draw(Json::object()), shiny = draw(hall({{"carpet", {{"shine", 1}}}}));
  const SimulatedLamps lamps(resolved(HallOptions()), context_of().scene.field);
  const Eigen::Vector3d lamp = lamps.places_mm().front();
  const double share = 4000 / (4000 + lamp.z());  // of the way from (0, 0), below the camera
  const Eigen::Vector2i mirrored = pixel_of(share * lamp.x(), share * lamp.y()),
                        other_side = pixel_of(-share * lamp.x(), -share * lamp.y());
  const auto gain = [&](const Eigen::Vector2i& p) {
    return shiny.luma(p.x(), p.y()) - dull.luma(p.x(), p.y());
  };
  EXPECT_GT(gain(mirrored), 35);
  EXPECT_LT(gain(other_side), 0.7 * gain(mirrored));
}

// ---- lamps

TEST(SimulatorHall, UnevenLampsDifferFromTheMeanByTheirShare) {
  for (int seed = 1; seed < 6; ++seed) {
    HallOptions options;
    options.seed = seed;
    options.lamps.uneven = 0.3;
    const SimulatedLamps lamps(resolved(options), FieldSize{});
    double least = 9, most = 0, sum = 0;
    for (int x = -20; x <= 20; ++x) {
      for (int y = -20; y <= 20; ++y) {
        const Paint light = lamps.at({x * 4800 / 20.0, y * 3300 / 20.0});
        EXPECT_EQ(light.r, light.g);
        least = std::min<double>(least, light.g);
        most = std::max<double>(most, light.g);
        sum += light.g;
      }
    }
    EXPECT_NEAR(std::max(most - 1, 1 - least), 0.3, 1e-4);
    EXPECT_NEAR(sum / (41 * 41), 1, 1e-4);
  }
  const Picture even = draw(Json::object()), uneven = draw(hall({{"lamps", {{"uneven", 0.3}}}}));
  const SimulatedLamps lamps(resolved(options_of(hall({{"lamps", {{"uneven", 0.3}}}})).hall),
                             context_of().scene.field);
  for (const Eigen::Vector2d& place : {Eigen::Vector2d(1200, 700), Eigen::Vector2d(-1100, -650)}) {
    const Eigen::Vector2i p = pixel_of(place.x(), place.y());
    EXPECT_NEAR(uneven.at(p.x(), p.y(), 1) / even.at(p.x(), p.y(), 1), lamps.at(place).g, 0.02);
  }
}

TEST(SimulatorHall, LampsOfTwoColoursAreWarmOnOneSide) {
  const Picture even = draw(Json::object()), two = draw(hall({{"lamps", {{"cast", 0.3}}}}));
  double warmest = 0, coldest = 9;
  each_pixel([&](int x, int y) {
    const double red = two.at(x, y, 0) / even.at(x, y, 0), blue = two.at(x, y, 2) / even.at(x, y, 2);
    EXPECT_NEAR(red - 1, 1 - blue, 0.06) << "what is warmer has more red and less blue";
    warmest = std::max(warmest, red);
    coldest = std::min(coldest, red);
  });
  EXPECT_GT(warmest, 1.1);
  EXPECT_LT(coldest, 0.9);
}

TEST(SimulatorHall, FlickerIsAFactorOfEachPictureWithinItsRange) {
  const Json flicker = hall({{"lamps", {{"flicker_low", 0.5}, {"flicker_high", 1.5}}}});
  const SimulatorOptions options = options_of(flicker);
  const SimulatedLamps lamps(resolved(options.hall), context_of().scene.field);
  const Picture steady = draw(Json::object());
  SimulatedCamera camera(options, context_of(), league_patterns());
  Picture picture{std::vector<std::uint8_t>(camera.picture_bytes())};
  std::vector<double> logs;
  for (int i = 0; i < 400; ++i) {
    const double factor = lamps.flicker(options.seed, i);
    EXPECT_GE(factor, 0.5);
    EXPECT_LE(factor, 1.5);
    EXPECT_EQ(lamps.flicker(options.seed, i), factor);
    logs.push_back(std::log(factor));
  }
  const Statistics all = statistics_of(logs);
  EXPECT_NEAR(all.mean, (std::log(0.5) + std::log(1.5)) / 2, 0.05) << "as likely by ratio";
  EXPECT_NEAR(all.deviation, std::log(3) / std::sqrt(12), 0.03);

  for (int i = 0; i < 5; ++i) {
    const double t_s = kTimeS + i / 60.0;
    camera.draw(t_s, picture.bytes.data());
    EXPECT_EQ(draw(options, t_s).bytes, picture.bytes) << "it does not depend on pictures before";
    const double factor = lamps.flicker(options.seed, std::llround(t_s * 60));
    const Statistics ratio =
        on_carpet([&](int x, int y) { return picture.at(x, y, 1) / steady.at(x, y, 1); });
    EXPECT_NEAR(ratio.mean, factor, 0.01);
  }
}

TEST(SimulatorHall, FlickerReachesRobotsAsItDoesTheCarpet) {
  Json json{{"robots_yellow", 3}, {"robots_blue", 3}, {"balls", 1}, {"speed", 0}};
  const SimulatorOptions steady = options_of(json);
  json.update(hall({{"lamps", {{"flicker_low", 0.4}, {"flicker_high", 0.9}}}}));
  const SimulatorOptions flickering = options_of(json);
  const double factor = SimulatedLamps(resolved(flickering.hall), context_of().scene.field)
                            .flicker(flickering.seed, std::llround(kTimeS * 60));
  const Picture before = draw(steady), after = draw(flickering);
  for (std::size_t i = 0; i < before.bytes.size(); ++i)
    ASSERT_NEAR(after.bytes[i], factor * before.bytes[i], 1.1) << "at byte " << i;
}

TEST(SimulatorHall, BandsRunAcrossThePictureAndMoveOn) {
  const Json bands = hall({{"lamps", {{"banding", 0.2}}}});
  Json rolling = bands;
  rolling["rolling_shutter_ms"] = 20;
  const Picture none = draw(Json::object());
  const auto rows_of = [&](const Picture& picture) {
    std::vector<double> rows;
    for (int y = 60; y < 230; ++y) {
      double sum = 0;
      for (int x = 130; x < 180; ++x) sum += picture.at(x, y, 1) / none.at(x, y, 1) / 50;
      rows.push_back(sum);
    }
    return rows;
  };
  const auto first = rows_of(draw(rolling, kTimeS)), second = rows_of(draw(rolling, kTimeS + 1.0 / 60));
  const auto [least, most] = std::minmax_element(first.begin(), first.end());
  EXPECT_NEAR(*most - *least, 0.4, 0.03);
  // Two periods of 10 ms in 290 rows: a minimum and the next maximum are 72 rows apart.
  const double apart = std::abs(static_cast<double>(most - least));
  EXPECT_NEAR(std::fmod(apart, 145), 72.5, 8);
  double differ = 0;
  for (std::size_t i = 0; i < first.size(); ++i) differ = std::max(differ, std::abs(first[i] - second[i]));
  EXPECT_GT(differ, 0.1);
}

TEST(SimulatorHall, ShadowsAreDarkRoundRobotsAndSoft) {
  Json json{{"robots_yellow", 1}, {"robots_blue", 0}, {"speed", 0}};
  const Picture without = draw(json);
  json.update(hall({{"lamps", {{"shadows", 1}}}}));
  const SimulatorOptions options = options_of(json);
  const Picture with = draw(options);
  SimulatedCamera camera(options, context_of(), league_patterns());
  const Json robot = camera.truth("", kTimeS)["robots"][0];
  const double x_mm = robot["x"], y_mm = robot["y"];
  // Towards the camera: on the other side, the robot's own side hides the floor.
  const double towards = x_mm > 0 ? -1 : 1;
  const auto light_at = [&](double away_mm) {
    const Eigen::Vector2i p = pixel_of(x_mm + towards * away_mm, y_mm);
    return with.luma(p.x(), p.y()) / without.luma(p.x(), p.y());
  };
  EXPECT_LT(light_at(115), 0.75);
  EXPECT_GT(light_at(160), light_at(115) + 0.1);
  EXPECT_NEAR(light_at(400), 1, 0.01);
}

// ---- around

const Json kFurnished{{"kind", "hard"},
                      {"lamps", {{"flicker_low", 1}, {"flicker_high", 1}, {"banding", 0}, {"shadows", 0}}},
                      {"sensor", {{"block_noise", 0}}}};

TEST(SimulatorHall, FurnitureStandsStillInBothPlacements) {
  for (const char* placement : {"paths", "scatter"}) {
    Json json = hall(kFurnished);
    json.update({{"placement", placement}, {"robots_yellow", 3}, {"robots_blue", 3}, {"balls", 2}});
    const SimulatorOptions options = options_of(json);
    const Picture first = draw(options), later = draw(options, kTimeS + 17.3);
    EXPECT_NE(first.bytes, later.bytes) << "robots do move";
    Json other = json;
    other["hall"]["seed"] = 2;
    const Picture elsewhere = draw(other);
    int changed = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        // The tops of robots appear up to 60 mm beyond the lines.
        const Eigen::Vector2i a = pixel_of(-1600, -1100), b = pixel_of(1600, 1100);
        if (x >= std::min(a.x(), b.x()) && x <= std::max(a.x(), b.x()) && y >= std::min(a.y(), b.y()) &&
            y <= std::max(a.y(), b.y()))
          continue;
        for (int c = 0; c < 3; ++c) ASSERT_EQ(first.at(x, y, c), later.at(x, y, c)) << x << ", " << y;
        changed += first.at(x, y, 1) != elsewhere.at(x, y, 1);
      }
    }
    EXPECT_GT(changed, 1000) << "another seed is another hall";
  }
}

TEST(SimulatorHall, NothingAroundReachesOverTheLines) {
  for (int seed = 1; seed <= 12; ++seed) {
    Json full = kFurnished;
    full["seed"] = seed;
    full["around"] = {{"things", 100}, {"people", 30}};
    Json empty = full;
    empty["around"] = {{"things", 0}, {"people", 0}, {"boards", 0}};
    const Picture with = draw(hall(full)), without = draw(hall(empty));
    int differ = 0, beside = 0;
    each_pixel([&](int x, int y) { differ += with.luma(x, y) != without.luma(x, y); }, 1490, 990, -1490,
               -990);
    each_pixel([&](int x, int y) { beside += with.luma(x, y) != without.luma(x, y); }, 2400, 1800, -2400,
               -1800);
    EXPECT_EQ(differ, 0) << "seed " << seed;
    EXPECT_GT(beside, 5000) << "seed " << seed;
  }
}

TEST(SimulatorHall, BoardsStandUprightAtTheCarpetsRim) {
  // For a camera 4 m above the middle, the face of a board at x = 1820 mm hides the next 76 to 214 mm of the
  // floor, for heights of 160 to 420 mm.
  const Picture none = draw(Json::object()),
                boards = draw(hall({{"around", {{"boards", 1}, {"things", 0}, {"people", 0}}}}));
  int on_carpet_differs = 0, on_face = 0, faces = 0, behind_differs = 0;
  std::set<int> colors;
  for (int y_mm = -1200; y_mm <= 1200; y_mm += 10) {
    const auto differs = [&](double x_mm) {
      const Eigen::Vector2i p = pixel_of(x_mm, y_mm);
      return std::abs(boards.at(p.x(), p.y(), 0) - none.at(p.x(), p.y(), 0)) > 12;
    };
    on_carpet_differs += differs(1780);
    on_face += differs(1860);
    behind_differs += differs(2200);
    ++faces;
    const Eigen::Vector2i p = pixel_of(1860, y_mm);
    colors.insert(static_cast<int>(boards.at(p.x(), p.y(), 0)) / 20);
  }
  EXPECT_EQ(on_carpet_differs, 0);
  EXPECT_GT(on_face, 0.7 * faces);
  EXPECT_EQ(behind_differs, 0);
  EXPECT_GE(colors.size(), 2U) << "lettering";
}

TEST(SimulatorHall, BoardsHideWhatStandsBehindThem) {
  Json people{{"boards", 0}, {"things", 0}, {"people", 30}};
  const auto picture = [&](double boards, int count) {
    people["boards"] = boards;
    people["people"] = count;
    return draw(hall({{"around", people}}));
  };
  // Boards are chosen before people, so their faces are the same.
  const Picture alone = picture(1, 0), both = picture(1, 30), none = picture(0, 0);
  int faces = 0, covered = 0;
  for (int y = 0; y < kHeight; ++y) {
    // A little above the floor, where shoes would be.
    const int x = pixel_of(1840, 0).x();
    if (std::abs(alone.luma(x, y) - none.luma(x, y)) < 12) continue;
    ++faces;
    covered += std::abs(both.luma(x, y) - alone.luma(x, y)) > 1;
  }
  EXPECT_GT(faces, 100);
  EXPECT_LT(covered, 0.2 * faces) << "only arms, which reach over them";
}

// ---- prints

TEST(SimulatorHall, RobotsHaveHeightsOfTheirOwnAndTheTruthSaysThem) {
  for (const char* placement : {"paths", "scatter"}) {
    Json json = hall({{"prints", {{"height_spread_mm", 5}}}});
    json.update({{"placement", placement}, {"robots_yellow", 4}, {"robots_blue", 4}});
    SimulatedCamera camera(options_of(json), context_of(), league_patterns());
    json["seed"] = 500'001;
    SimulatedCamera elsewhere(options_of(json), context_of(1), league_patterns());
    std::map<std::string, double> heights_mm;
    const Json truth = camera.truth("", kTimeS), other_truth = elsewhere.truth("", kTimeS + 9);
    for (const Json& robot : truth["robots"])
      heights_mm[robot["team"].get<std::string>() + robot["id"].dump()] = robot["height"];
    ASSERT_EQ(heights_mm.size(), 8U);
    std::set<double> different;
    for (const auto& [name, height_mm] : heights_mm) {
      EXPECT_NEAR(height_mm, 140, 5);
      different.insert(height_mm);
    }
    EXPECT_EQ(different.size(), 8U);
    EXPECT_GT(*different.rbegin() - *different.begin(), 3);
    for (const Json& robot : other_truth["robots"])
      EXPECT_EQ(robot["height"], heights_mm[robot["team"].get<std::string>() + robot["id"].dump()]);
  }
}

TEST(SimulatorHall, PrintsFadeAndDifferFromMakerToMaker) {
  const auto saturation = [](const Paint& p) {
    return 1 - std::min({p.r, p.g, p.b}) / std::max({p.r, p.g, p.b});
  };
  HallOptions options;
  const SimulatedPrints plain(resolved(options));
  EXPECT_EQ(plain.of(Team::kBlue, 3)[label::kPink].r, kPrints[label::kPink].r);
  options.prints.fading = 0.8;
  const SimulatedPrints faded(resolved(options));
  std::set<float> reds;
  for (int id = 0; id < 16; ++id) {
    const SimulatedPrints::Colors& colors = faded.of(Team::kYellow, id);
    for (const Label label : {label::kPink, label::kGreen, label::kYellow})
      EXPECT_LE(saturation(colors[label]), saturation(kPrints[label]) + 1e-5);
    EXPECT_EQ(colors[label::kBlack].r, kPrints[label::kBlack].r);
    reds.insert(colors[label::kGreen].r);
  }
  EXPECT_EQ(reds.size(), 16U);
  EXPECT_EQ(faded.ball().r, kPrints[label::kOrange].r) << "balls are not printed";

  options.prints = {};
  options.prints.makers = 1;
  std::set<float> greens;
  for (options.seed = 1; options.seed < 20; ++options.seed) {
    const SimulatedPrints made(resolved(options));
    greens.insert(made.of(Team::kBlue, 0)[label::kGreen].r);
    for (const Team team : {Team::kYellow, Team::kBlue}) {
      const Paint green = made.of(team, 7)[label::kGreen], pink = made.of(team, 7)[label::kPink];
      EXPECT_GT(green.g, 1.4F * green.r);
      EXPECT_GT(pink.r, 1.4F * pink.g);
    }
  }
  EXPECT_GE(greens.size(), 10U);
}

// ---- sensor

TEST(SimulatorHall, HotPixelsStayWhereTheyAreAndEachCameraHasItsOwn) {
  const Json hot = hall({{"sensor", {{"hot_pixels", 500}}}});
  const Picture none = draw(Json::object());
  const auto places_of = [&](const Picture& picture) {
    std::set<std::size_t> places;
    for (std::size_t i = 0; i < picture.bytes.size(); ++i) {
      if (picture.bytes[i] != none.bytes[i]) places.insert(i);
    }
    return places;
  };
  Json other_scene = hot;
  other_scene["seed"] = 77;
  const auto places = places_of(draw(hot));
  EXPECT_NEAR(static_cast<double>(places.size()), 500e-6 * kWidth * kHeight, 3);
  EXPECT_EQ(places_of(draw(hot, kTimeS + 5)), places);
  EXPECT_EQ(places_of(draw(other_scene)), places);
  EXPECT_NE(places_of(draw(hot, kTimeS, 1)), places);
}

TEST(SimulatorHall, BlockNoiseIsOfBlocksAndNewInEachPicture) {
  for (const char* format : {"rgb24", "bgr24", "uyvy", "bayer_rg8"}) {
    SCOPED_TRACE(format);
    Json json = hall({{"sensor", {{"block_noise", 4}}}});
    json["pixel_format"] = format;
    SimulatedCamera camera(options_of(json), context_of(), league_patterns());
    json["hall"] = Json::object();
    SimulatedCamera clean_camera(options_of(json), context_of(), league_patterns());
    std::vector<std::uint8_t> first(camera.picture_bytes()), second(first.size()), clean(first.size());
    camera.draw(kTimeS, first.data());
    camera.draw(kTimeS, second.data());
    clean_camera.draw(kTimeS, clean.data());
    EXPECT_NE(first, second);
    // Compares one kind of sample: luma, or green.
    const int step =
        camera.layout().format == PixelFormat::kBayerRg8 ? 1 : bytes_per_pixel(camera.layout().format);
    const int offset = step == 1 ? 0 : 1;
    const auto error_at = [&](int x, int y) {
      const auto at = static_cast<std::size_t>((y * kWidth + x) * step + offset);
      return static_cast<double>(first[at]) - clean[at];
    };
    std::vector<double> errors, across, within;
    for (int y = 80; y < 200; ++y) {
      for (int x = 80; x < 296; ++x) errors.push_back(error_at(x, y));
      for (int x = 80; x < 296; x += 8) {
        within.push_back(error_at(x + 3, y) - error_at(x + 4, y));
        across.push_back(error_at(x - 1, y) - error_at(x, y));
      }
    }
    // Green contains the noise of luma and some of that of U and V.
    EXPECT_NEAR(statistics_of(errors).deviation, step == 3 ? 5.1 : 4, 0.6);
    EXPECT_GT(statistics_of(across).deviation, 2 * statistics_of(within).deviation) << "edges of blocks show";
  }
}

// ---- rolling shutter

TEST(SimulatorRollingShutter, MovesARobotByItsSpeedTimesTheTimeOfItsRow) {
  constexpr double kReadOutMs = 40, kBlackRed = 24, kReachPx = 2.7;
  Json json{{"placement", "scatter"}, {"robots_yellow", 4}, {"speed", 1.5}, {"blur_sigma_px", 0}};
  SimulatedCamera global(options_of(json), context_of(), league_patterns());
  json["rolling_shutter_ms"] = kReadOutMs;
  SimulatedCamera rolling(options_of(json), context_of(), league_patterns());
  int checked = 0;
  double largest_px = 0;
  for (int i = 0; i < 6; ++i) {
    const double t_s = kTimeS + i;
    Picture picture{std::vector<std::uint8_t>(rolling.picture_bytes())};
    rolling.draw(t_s, picture.bytes.data());
    const Json truth = rolling.truth("", t_s), still = global.truth("", t_s);
    ASSERT_EQ(truth["robots"].size(), still["robots"].size());
    for (std::size_t k = 0; k < truth["robots"].size(); ++k) {
      const Json &robot = truth["robots"][k], &there = still["robots"][k];
      EXPECT_EQ(robot["x"], there["x"]) << "the truth is that of the picture's time";
      EXPECT_EQ(robot["orientation"], there["orientation"]);
      if (!robot["visible"].get<bool>()) continue;
      // Centroid of the yellow centre dot's light above the black around it.
      const double px = robot["pixel_x"], py = robot["pixel_y"];
      Eigen::Vector2d sum(0, 0);
      double weight = 0;
      for (int y = static_cast<int>(py) - 3; y <= static_cast<int>(py) + 4; ++y) {
        for (int x = static_cast<int>(px) - 3; x <= static_cast<int>(px) + 4; ++x) {
          if (std::hypot(x - px, y - py) > kReachPx) continue;
          const double light = picture.at(x, y, 0) - kBlackRed;
          sum += light * Eigen::Vector2d(x, y);
          weight += light;
        }
      }
      EXPECT_LT((sum / weight - Eigen::Vector2d(px, py)).norm(), 0.05);
      const Eigen::Vector2d shift(px - there["pixel_x"].get<double>(), py - there["pixel_y"].get<double>());
      // 3000 mm/s; a pixel is 13 mm on the tops.
      const double delay_s = (py / (kHeight - 1) - 0.5) * kReadOutMs * 1e-3;
      EXPECT_NEAR(shift.norm(), 3000 * std::abs(delay_s) * 300 / (4000 - 140), 0.02);
      largest_px = std::max(largest_px, shift.norm());
      ++checked;
    }
  }
  EXPECT_GT(checked, 10);
  EXPECT_GT(largest_px, 2);
}

TEST(SimulatorRollingShutter, MotionsFollowThePathsAndAreWipedFromTheNextPicture) {
  Json json{
      {"robots_yellow", 3}, {"robots_blue", 3}, {"balls", 2}, {"rolling_shutter_ms", 20}, {"exposure_ms", 8}};
  const SimulatorOptions options = options_of(json);
  const SimulatedWorld world(options, context_of().scene.field, {140, 140});
  const SimulatorMotions motions = world.motions_at(kTimeS, 0.01);
  for (const double dt_s : {-0.01, 0.004, 0.01}) {
    const SimulatedScene expected = world.at(kTimeS + dt_s), seen = moved(world.at(kTimeS), motions, dt_s);
    for (std::size_t i = 0; i < expected.robots.size(); ++i) {
      EXPECT_NEAR(seen.robots[i].x_mm, expected.robots[i].x_mm, 0.01);
      EXPECT_NEAR(seen.robots[i].y_mm, expected.robots[i].y_mm, 0.01);
      EXPECT_NEAR(seen.robots[i].orientation_rad, expected.robots[i].orientation_rad, 1e-4);
    }
    for (std::size_t i = 0; i < expected.balls.size(); ++i)
      EXPECT_NEAR(seen.balls[i].x_mm, expected.balls[i].x_mm, 0.01);
  }
  SimulatedCamera used(options, context_of(), league_patterns());
  std::vector<std::uint8_t> picture(used.picture_bytes());
  for (int i = 0; i < 3; ++i) used.draw(kTimeS + 3 * i, picture.data());
  EXPECT_EQ(draw(options, kTimeS + 6).bytes, picture);
}

}  // namespace
}  // namespace sslv::simulator_hall_test
