// SPDX-License-Identifier: Apache-2.0
#include "hall.h"

#include "furniture.h"

#include <cmath>
#include <numbers>
#include <string_view>

#include <Eigen/Geometry>

namespace sslv::halls {
namespace {

// The fields and cameras of tests/golden/accuracy.json.
FieldSize field_of(Size size) {
  FieldSize field;
  if (size == Size::kA) {
    field.field_length = 6000;
    field.field_width = 4000;
    field.goal_width = 700;
    field.boundary_width = field.boundary_width_goal_line = 200;
    field.penalty_area_depth = 600;
    field.penalty_area_width = 1400;
    field.goal_center_to_penalty_mark = 4000;
  } else if (size == Size::kC) {
    field.field_length = 12000;
    field.field_width = 9000;
    field.goal_width = 1800;
    field.penalty_area_depth = 1800;
    field.penalty_area_width = 3600;
    field.goal_center_to_penalty_mark = 8000;
  }
  return field;
}

CameraCalibration calibration_of(Size size) {
  switch (size) {
    case Size::kA:
      return {712,          391.6, 288.3,     0.08,     0.709562592, -0.704634171, -0.000296685,
              -0.003394912, 8.646, -1610.779, 3991.697, 780,         580};
    case Size::kB:
      return {968,        637.2,   514.1,     0.08,     0.70400658, -0.710185273, -0.000293722,
              0.00339517, -14.588, -2357.895, 5010.481, 1280,       1024};
    case Size::kC: break;
  }
  return {1540,       1226.4, 1020.8,    0.08,     0.708948825, -0.705252907, 0.000625142,
          -0.0030837, 9.972,  -3150.752, 5989.173, 2448,        2048};
}

/// Rotates the camera about its own axes without moving it.
void turn(CameraCalibration& c, double about_x_deg, double about_y_deg, double about_z_deg) {
  const double rad = std::numbers::pi / 180;
  const Eigen::Quaterniond before = Eigen::Quaterniond(c.q3, c.q0, c.q1, c.q2).normalized();
  const Eigen::Vector3d position = -(before.conjugate() * Eigen::Vector3d(c.tx, c.ty, c.tz));
  const Eigen::Quaterniond after = (Eigen::AngleAxisd(about_x_deg * rad, Eigen::Vector3d::UnitX()) *
                                    Eigen::AngleAxisd(about_y_deg * rad, Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(about_z_deg * rad, Eigen::Vector3d::UnitZ()) * before)
                                       .normalized();
  const Eigen::Vector3d translation = -(after * position);
  c.q0 = after.x();
  c.q1 = after.y();
  c.q2 = after.z();
  c.q3 = after.w();
  c.tx = translation.x();
  c.ty = translation.y();
  c.tz = translation.z();
}

void set_px_per_mm(CameraCalibration& c, double px_per_mm) {
  const Eigen::Vector2d middle((c.pixel_image_width - 1) / 2.0, (c.pixel_image_height - 1) / 2.0);
  // The centre is hardly distorted, so its scale is almost proportional to the focal length.
  for (int step = 0; step < 3; ++step) {
    c.focal_length *= px_per_mm * std::sqrt(CameraModel(c).mm2_per_px(middle, 0));
  }
}

Eigen::AlignedBox2d with_boundary(const FieldSize& field, double more_mm) {
  const Eigen::Vector2d corner(field.field_length / 2.0 + field.boundary_width_goal_line + more_mm,
                               field.field_width / 2.0 + field.boundary_width + more_mm);
  return {-corner, corner};
}

void hang_lamps(Hall& hall, Chance& chance) {
  // Rows of lamps over the field, all slightly different.
  const int columns = hall.options.size == Size::kC ? 4 : 3, rows = hall.options.size == Size::kA ? 2 : 3;
  const double height_mm = chance.uniform(4500, 8000);
  for (int i = 0; i < columns; ++i) {
    for (int j = 0; j < rows; ++j) {
      const double x = ((i + 0.5) / columns - 0.5 + chance.uniform(-0.05, 0.05)) * hall.field.field_length;
      const double y = ((j + 0.5) / rows - 0.5 + chance.uniform(-0.05, 0.05)) * 1.2 * hall.field.field_width;
      hall.lighting.lamps.push_back({{x, y, height_mm}, chance.uniform(0.6, 1.2), Color::Ones()});
    }
  }
}

void cast(Hall& hall, Chance& chance, double strength) {
  const Color tint(static_cast<float>(1 + strength * chance.uniform(-1, 1)), 1,
                   static_cast<float>(1 + 1.4 * strength * chance.uniform(-1, 1)));
  for (Lamp& lamp : hall.lighting.lamps) lamp.tint *= tint;
}

/// Adds a low window with warm light beside the field.
void add_window(Hall& hall, Chance& chance) {
  const double side = chance.sign();
  hall.lighting.lamps.push_back({{chance.uniform(-0.5, 0.1) * hall.field.field_length,
                                  side * (hall.field.field_width / 2.0 + 2500), 3000},
                                 chance.uniform(3, 6),
                                 Color(1.16F, 1, 0.72F)});
}

void lay_acceptance_carpet(Hall& hall) {
  const Transfer transfer = hall.sensor.transfer;
  Carpet& carpet = hall.floor.carpet;
  carpet.color = Seen{34, 98, 48}.in(transfer);
  carpet.extent_mm = with_boundary(hall.field, 0);
  carpet.blotches = 0.076;
  carpet.blotch_mm = 420;
  carpet.hue = 0.058;
  hall.floor.ground = {Seen{60, 60, 62}.in(transfer), false, carpet.seed + 30};
  paint_lines(hall.field, Seen{226, 228, 224}.in(transfer), hall.floor);
}

void lay_carpet(Hall& hall, Chance& chance, bool hard) {
  const Transfer transfer = hall.sensor.transfer;
  const double strength = hard ? 1.6 : 1;
  Carpet& carpet = hall.floor.carpet;
  carpet.color =
      seen_of_hsv(chance.uniform(90, 160), chance.uniform(0.45, 0.75), chance.uniform(60, 108)).in(transfer);
  carpet.extent_mm = with_boundary(hall.field, chance.uniform(-40, 150));
  carpet.blotches = strength * chance.uniform(0.03, 0.08);
  carpet.blotch_mm = chance.uniform(200, 700);
  carpet.hue = strength * chance.uniform(0.01, 0.04);
  switch (chance.whole(0, 3)) {
    case 0:
      carpet.pile = strength * chance.uniform(0.06, 0.14);
      carpet.pile_mm = chance.uniform(3, 9);
      carpet.brush = strength * chance.uniform(0.03, 0.09);
      break;
    case 1:
      carpet.weave = strength * chance.uniform(0.08, 0.2);
      carpet.weave_mm = chance.uniform(7, 20);
      break;
    case 2:
      carpet.tiles = strength * chance.uniform(0.03, 0.08);
      carpet.tile_mm = chance.happens(0.5) ? 500 : 1000;
      carpet.seams = strength * chance.uniform(0.2, 0.45);
      carpet.seam_mm = chance.uniform(2, 6);
      carpet.pile = 0.06;
      break;
    default:
      carpet.seams = strength * chance.uniform(0.2, 0.4);  // rolls of 2 m
      carpet.tile_mm = 2000;
      carpet.pile = strength * chance.uniform(0.04, 0.1);
      break;
  }
  carpet.worn = chance.happens(0.6) ? strength * chance.uniform(0.08, 0.2) : 0;
  if (chance.happens(0.5)) {
    for (int i = chance.whole(1, 3); i > 0; --i) {
      hall.floor.shines.push_back({{chance.uniform(-0.5, 0.1) * hall.field.field_length,
                                    chance.uniform(-0.5, 0.5) * hall.field.field_width},
                                   {chance.uniform(150, 600), chance.uniform(150, 500)},
                                   strength * chance.uniform(0.02, 0.07)});
    }
  }
  Ground& ground = hall.floor.ground;
  ground.planks = chance.happens(0.5);
  const double grey = chance.uniform(45, 140);
  ground.color = (ground.planks ? seen_of_hsv(chance.uniform(22, 36), chance.uniform(0.35, 0.6),
                                              chance.uniform(110, 185))
                                : Seen{grey, grey, grey * 1.02})
                     .in(transfer);
  ground.seed = carpet.seed + 30;
  const double white = chance.uniform(195, 240);
  paint_lines(hall.field, Seen{white, white, white * chance.uniform(0.93, 1.02)}.in(transfer), hall.floor);
  hall.floor.line_wear = hard ? chance.uniform(0, 0.4) : chance.uniform(0, 0.15);
}

Prints print(Chance& chance, std::size_t team, bool hard, Transfer transfer) {
  constexpr Seen kPink[]{{255, 90, 170}, {235, 70, 150},  {245, 120, 185},
                         {225, 60, 135}, {250, 100, 205}, {240, 105, 140}};
  constexpr Seen kGreen[]{{80, 215, 100},  {115, 228, 85}, {65, 205, 125},
                          {130, 230, 100}, {70, 200, 85},  {55, 178, 80}};
  constexpr Seen kYellow[]{{245, 215, 40}, {235, 195, 30}, {250, 225, 85}, {242, 178, 30}};
  constexpr Seen kBlue[]{{45, 100, 220}, {35, 130, 225}, {55, 85, 200}, {75, 125, 240}, {32, 62, 150}};
  // The last `rare` colours of each list occur only in hard halls: few printers make them.
  const auto pick = [&](const auto& list, int rare) {
    return list[static_cast<std::size_t>(
                    chance.whole(0, static_cast<int>(std::size(list)) - 1 - (hard ? 0 : rare)))]
        .in(transfer);
  };
  const double black = chance.uniform(12, hard ? 32 : 24);
  Prints out;
  out.center = team == 0 ? pick(kYellow, 1) : pick(kBlue, 1);
  out.pink = pick(kPink, 1);
  out.green = pick(kGreen, 1);
  out.top = Seen{black, black, black * 1.05}.in(transfer);
  const double side = chance.uniform(14, 45);
  out.side = Seen{side, side, side * 1.05}.in(transfer);
  return out;
}

void make_acceptance(Hall& hall, Chance& chance) {
  const Transfer transfer = hall.sensor.transfer;
  lay_acceptance_carpet(hall);
  hang_lamps(hall, chance);
  hall.lighting.uneven = 0.15;
  hall.lighting.vignette = 0.15;
  hall.sensor.shot_share = 0.2;
  const Color top = Seen{16, 16, 17}.in(transfer), side = Seen{26, 26, 28}.in(transfer);
  const Color pink = Seen{236, 84, 168}.in(transfer), green = Seen{70, 214, 94}.in(transfer);
  hall.prints = {Prints{Seen{226, 178, 36}.in(transfer), pink, green, top, side},
                 Prints{Seen{46, 112, 232}.in(transfer), pink, green, top, side}};
  // This makes green dots 1.9 to 2.4 times as bright as the carpet.
  hall.brightness_spread = 0.11;
  hall.ball.color = Seen{242, 116, 34}.in(transfer);
}

void make_hall_of_people(Hall& hall, Chance& chance, bool hard) {
  const Transfer transfer = hall.sensor.transfer;
  lay_carpet(hall, chance, hard);
  hang_lamps(hall, chance);
  if (hard && chance.happens(0.7)) add_window(hall, chance);
  cast(hall, chance, hard ? 0.1 : 0.05);
  hall.lighting.uneven = hard ? 0.35 : 0.2;
  hall.lighting.vignette = chance.uniform(0.05, 0.2);
  hall.lighting.lamp_jitter = hard ? 0.06 : 0.03;
  hall.lighting.banding = hard ? 0.06 : 0;
  hall.lighting.banding_rows = chance.uniform(0.15, 0.5) * hall.calibration.pixel_image_height;
  hall.sensor.noise_grey = hard ? chance.uniform(4, 8) : chance.uniform(2, 6);
  hall.sensor.blur_px = chance.uniform(0.4, 0.9);
  hall.sensor.shot_share = 0.5;
  hall.sensor.is_mosaic = chance.happens(0.5);
  if (hard) {
    hall.sensor.jpeg_quality = chance.happens(0.4) ? chance.whole(75, 90) : 0;
    for (int i = chance.whole(5, 60); i > 0; --i) {
      hall.sensor.hot_pixels.push_back({chance.whole(0, hall.calibration.pixel_image_width - 1),
                                        chance.whole(0, hall.calibration.pixel_image_height - 1),
                                        chance.whole(0, 2), static_cast<float>(chance.uniform(0.2, 1))});
    }
  }
  for (std::size_t team = 0; team < 2; ++team) hall.prints[team] = print(chance, team, hard, transfer);
  hall.fade = hard ? 0.35 : 0.2;
  hall.wear = hard ? 0.4 : 0;
  hall.brightness_spread = 0.1;
  hall.height_spread_mm = 8;
  hall.shadows = hard ? 0.45 : 0.3;
  constexpr Seen kBalls[]{{240, 115, 30}, {226, 96, 34}, {250, 132, 46}, {212, 84, 40}, {255, 145, 60}};
  hall.ball.color = kBalls[static_cast<std::size_t>(chance.whole(0, hard ? 4 : 2))].in(transfer);
  hall.ball.bounce = hall.floor.carpet.color;
  hall.ball.gloss = static_cast<float>(hard ? chance.uniform(0.2, 0.9) : chance.uniform(0, 0.15));
  hall.ball.gloss_power = static_cast<float>(hard ? chance.uniform(30, 150) : 40);
}

}  // namespace

Robot::Look Hall::robot_look(std::size_t team, int id) const {
  Chance chance(seed, "robot", team * 256 + static_cast<std::size_t>(id));
  const Prints& print = prints[team];
  // In the league's order, front left first: G green, P pink.
  constexpr std::string_view kCodes[16]{"PGPP", "GGPP", "GGPG", "PGPG", "PPGP", "GPGP", "GPGG", "PPGG",
                                        "GGGG", "PPPP", "PGGP", "GPPG", "GGGP", "GPPP", "PGGG", "PPPG"};
  Robot::Look look;
  look.height_mm = kNominalHeightMm + height_spread_mm * chance.uniform(-1, 1);
  look.radius_mm = chance.uniform(86, 90);
  look.front_mm = chance.uniform(55.5, 58);
  look.top = print.top;
  look.side = print.side;
  // Old prints fade towards the white of the paper.
  const auto share = static_cast<float>(chance.uniform(0, fade));
  const auto bright = static_cast<float>(1 + brightness_spread * chance.uniform(-1, 1));
  const Color paper = Seen{200, 200, 195}.in(sensor.transfer);
  const auto printed = [&](const Color& color, float faded) -> Color {
    return (color * (1 - faded) + paper * faded) * bright;
  };
  // Cyan fades least.
  look.dots[0] = printed(print.center, team == 1 ? share / 2 : share);
  for (std::size_t i = 0; i < 4; ++i) {
    look.dots[i + 1] =
        printed(kCodes[static_cast<std::size_t>(id)][i] == 'G' ? print.green : print.pink, share);
  }
  look.wear = wear > 0 && chance.happens(0.3) ? chance.uniform(0.1, wear) : 0;
  look.wear_seed = static_cast<std::uint32_t>(chance.bits());
  return look;
}

Hall make_hall(const HallOptions& options) {
  Hall hall;
  hall.options = options;
  hall.seed = mixed(options.seed * 16 + static_cast<std::uint64_t>(options.kind) * 4 +
                    static_cast<std::uint64_t>(options.size));
  Chance chance(hall.seed, "hall");
  const bool is_acceptance = options.kind == Kind::kAcceptance, is_hard = options.kind == Kind::kHard;
  hall.field = field_of(options.size);
  hall.calibration = calibration_of(options.size);
  hall.sensor.transfer =
      options.transfer.value_or(!is_acceptance && chance.happens(0.4) ? Transfer::kSrgb : Transfer::kLinear);
  hall.floor.carpet.seed = static_cast<std::uint32_t>(chance.bits());
  hall.floor.carpet.field_length_mm = hall.field.field_length;
  hall.floor.carpet.field_width_mm = hall.field.field_width;
  if (is_acceptance) {
    turn(hall.calibration, options.tilt_deg, 0, 0);
    make_acceptance(hall, chance);
  } else {
    // Real cameras deviate from that pose, and show more of the hall.
    turn(hall.calibration, options.tilt_deg + chance.uniform(-2, 2), chance.uniform(-2, 2),
         chance.uniform(-3, 3));
    hall.calibration.focal_length *= chance.uniform(0.9, 1);
    make_hall_of_people(hall, chance, is_hard);
  }
  if (options.px_per_mm) set_px_per_mm(hall.calibration, *options.px_per_mm);
  hall.sensor.noise_grey = options.noise_grey.value_or(hall.sensor.noise_grey);
  hall.sensor.blur_px = options.blur_px.value_or(hall.sensor.blur_px);
  hall.sensor.jpeg_quality = options.jpeg_quality.value_or(hall.sensor.jpeg_quality);
  hall.sensor.is_mosaic = options.is_mosaic.value_or(hall.sensor.is_mosaic);
  hall.sensor.exposure_s = options.exposure_s;
  hall.sensor.readout_s = options.readout_s;
  hall.lighting.uneven = options.uneven.value_or(hall.lighting.uneven);
  hall.lighting.vignette = options.vignette.value_or(hall.lighting.vignette);
  hall.lighting.banding = options.banding.value_or(hall.lighting.banding);
  hall.height_spread_mm = options.height_spread_mm.value_or(hall.height_spread_mm);
  furnish(hall);
  return hall;
}

}  // namespace sslv::halls
