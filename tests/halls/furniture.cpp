// SPDX-License-Identifier: Apache-2.0
#include "furniture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace sslv::halls {
namespace {

/// A side of the field: from `a` along `along` to `b`; `outward` points away from the field.
struct Side {
  Eigen::Vector2d a, b, along, outward;
  double boundary_mm;
  bool has_goal, has_boards = false;
  double board_at_mm = 0;  // distance of the boards' faces from the line
};

class Furnisher {
 public:
  explicit Furnisher(Hall& hall)
      : hall_(hall),
        chance_(hall.seed, "furniture"),
        camera_(hall.calibration),
        transfer_(hall.sensor.transfer),
        is_hard_(hall.options.kind == Kind::kHard) {
    const double x = hall.field.field_length / 2.0, y = hall.field.field_width / 2.0;
    const double end = camera_.position_mm().x() < 0 ? -x : x;  // the visible goal line
    sides_ = {
        Side{{-x, y}, {x, y}, {1, 0}, {0, 1}, double(hall.field.boundary_width), false},
        Side{{-x, -y}, {x, -y}, {1, 0}, {0, -1}, double(hall.field.boundary_width), false},
        Side{{end, -y}, {end, y}, {0, 1}, {end / x, 0}, double(hall.field.boundary_width_goal_line), true}};
  }

  void furnish() {
    for (Side& side : sides_) {
      side.has_boards = chance_.happens(is_hard_ ? 0.75 : 0.6);
      side.board_at_mm =
          side.has_goal ? std::max(hall_.field.goal_depth + 60.0, side.boundary_mm * chance_.uniform(1, 1.3))
                        : side.boundary_mm * chance_.uniform(0.5, 0.95);
      if (side.has_boards) put_boards(side);
      if (side.has_goal) put_goal(side);
    }
    for (int i = chance_.whole(1, 3); i > 0; --i) lay_cable();
    for (int i = is_hard_ ? chance_.whole(3, 6) : chance_.whole(1, 4); i > 0; --i)
      put_person(is_hard_ ? -120 : 60);
    if (!is_hard_) return;
    for (int i = chance_.whole(2, 5); i > 0; --i) put_cone();
    for (int i = chance_.whole(4, 10); i > 0; --i) stick_tape();
    for (int i = chance_.whole(1, 3); i > 0; --i) reach_in();
    for (int i = chance_.whole(1, 2); i > 0; --i) lean_in();
  }

  void distract() {
    constexpr Seen kColors[]{{230, 40, 40}, {245, 150, 30},  {240, 210, 50},  {60, 190, 80},
                             {40, 90, 200}, {220, 80, 160},  {235, 235, 235}, {120, 60, 30},
                             {20, 20, 20},  {150, 150, 150}, {200, 90, 40}};
    for (int i = 0; i < hall_.options.distractors; ++i) {
      const Eigen::Vector2d at(chance_.uniform(-0.5, 0.5) * hall_.field.field_length,
                               chance_.uniform(-0.5, 0.5) * hall_.field.field_width);
      const Color color = chance_.one_of(kColors).in(transfer_);
      const double length = chance_.log_uniform(15, 200);
      switch (chance_.whole(0, 2)) {
        case 0: stripe(at, length, chance_.uniform(0.2, 1) * length, color); break;
        case 1:  // a flat box
          hall_.furniture.push_back(
              std::make_unique<Box>(Eigen::Vector3d(at.x(), at.y(), 10),
                                    Eigen::Vector3d(length / 2, length / 2 * chance_.uniform(0.5, 1), 10),
                                    chance_.uniform(0, 3), Box::Look{color, color, ""}));
          break;
        default: {  // an egg, not a ball
          const double flat = chance_.uniform(0.3, 0.6);
          hall_.furniture.push_back(std::make_unique<Ellipsoid>(
              Eigen::Vector3d(at.x(), at.y(), 8), Eigen::Vector3d(length / 2, length / 2 * flat, 8),
              chance_.uniform(0, 3), color));
        }
      }
    }
  }

 private:
  bool is_seen(const Eigen::Vector2d& at, double z_mm) const {
    const auto pixel = camera_.project({at.x(), at.y(), z_mm});
    return pixel && pixel->x() > 0 && pixel->y() > 0 && pixel->x() < hall_.calibration.pixel_image_width &&
           pixel->y() < hall_.calibration.pixel_image_height;
  }

  /// A visible place along a side, at a distance outside its line.
  struct Rim {
    Eigen::Vector2d at;
    const Side* side;
  };
  Rim rim(double from_mm, double to_mm, bool before_boards) {
    for (int tries = 0;; ++tries) {
      const Side& side = sides_[static_cast<std::size_t>(chance_.whole(0, 2))];
      double out = chance_.uniform(from_mm, to_mm);
      if (before_boards && side.has_boards) out = std::min(out, side.board_at_mm - 60);
      const Eigen::Vector2d at = side.a + chance_.uniform(0, 1) * (side.b - side.a) + out * side.outward;
      const bool in_goal = side.has_goal && std::abs(at.y()) < hall_.field.goal_width / 2.0 + 80;
      if (tries > 1000 || (is_seen(at, 0) && !in_goal)) return {at, &side};
    }
  }

  void put_boards(const Side& side) {
    constexpr Seen kColors[]{{222, 40, 40}, {245, 120, 28}, {250, 210, 45}, {40, 70, 190},  {240, 240, 240},
                             {22, 22, 26},  {40, 150, 85},  {205, 45, 125}, {150, 150, 155}};
    const std::string words[]{"ROBOCUP", "SENSOR", "LABS",  "SOLAR", "TURBO",
                              "PLANET",  "BOOST",  "CHIPS", "PILOT"};
    const double height = chance_.uniform(180, 400), length = (side.b - side.a).norm();
    for (double at = -400; at < length + 400;) {
      const double piece = chance_.uniform(900, 2200);
      const Seen& color = chance_.one_of(kColors);
      const Seen* ink = &chance_.one_of(kColors);
      while (std::hypot(ink->r - color.r, ink->g - color.g) < 90) ink = &chance_.one_of(kColors);
      if (!chance_.happens(0.12)) {
        const Eigen::Vector2d middle =
            side.a + (at + piece / 2) * side.along + (side.board_at_mm + 12) * side.outward;
        hall_.furniture.push_back(std::make_unique<Box>(
            Eigen::Vector3d(middle.x(), middle.y(), height / 2),
            Eigen::Vector3d(piece / 2 - 3, 12, height / 2), std::atan2(side.along.y(), side.along.x()),
            Box::Look{color.in(transfer_), ink->in(transfer_), chance_.one_of(words), chance_.happens(0.4)}));
      }
      at += piece;
    }
  }

  void put_goal(const Side& side) {
    const double x = side.a.x(), depth = hall_.field.goal_depth, width = hall_.field.goal_width;
    const double height = hall_.field.goal_height, sign = side.outward.x();
    const double grey = chance_.happens(0.6) ? chance_.uniform(190, 235) : chance_.uniform(20, 60);
    const Color color = Seen{grey, grey, grey}.in(transfer_);
    const Box::Look look{color, color, ""};
    hall_.furniture.push_back(std::make_unique<Box>(Eigen::Vector3d(x + sign * (depth + 10), 0, height / 2),
                                                    Eigen::Vector3d(width / 2 + 20, 10, height / 2),
                                                    std::numbers::pi / 2, look));
    for (const double end : {-1.0, 1.0}) {
      hall_.furniture.push_back(std::make_unique<Box>(
          Eigen::Vector3d(x + sign * (depth / 2 + 5), end * (width / 2 + 10), height / 2),
          Eigen::Vector3d(depth / 2 + 5, 10, height / 2), 0, look));
    }
  }

  void lay_cable() {
    constexpr Seen kColors[]{{20, 20, 20},  {150, 150, 150}, {235, 235, 230},
                             {40, 70, 180}, {220, 60, 40},   {235, 120, 30}};
    const Color color = kColors[static_cast<std::size_t>(chance_.whole(0, is_hard_ ? 5 : 3))].in(transfer_);
    const Side& side = sides_[static_cast<std::size_t>(chance_.whole(0, 2))];
    const double length = (side.b - side.a).norm(), width = chance_.uniform(5, 12);
    const double middle = chance_.uniform(60, 260), swing = chance_.uniform(20, 60);
    const auto seed = static_cast<std::uint32_t>(chance_.bits());
    Eigen::Vector2d before = side.a;
    for (double at = 0; at < length; at += 60) {
      const double out = std::max(30.0, middle + swing * 2 * smooth_noise(at / 500, 0, seed));
      const Eigen::Vector2d here = side.a + at * side.along + out * side.outward;
      if (at > 0) hall_.floor.stripes.push_back({before, here + 3 * side.along, width / 2, color, true});
      before = here;
    }
  }

  Color cloth() {
    constexpr Seen kColors[]{{25, 25, 30},   {60, 60, 70},    {40, 50, 90},
                             {120, 110, 95}, {200, 200, 200}, {150, 30, 35}};
    return chance_.one_of(kColors).in(transfer_);
  }
  Color skin() {
    constexpr Seen kColors[]{{225, 170, 140}, {205, 145, 112}, {150, 98, 70}, {96, 62, 46}, {238, 188, 160}};
    return chance_.one_of(kColors).in(transfer_);
  }

  Color shirt() {
    constexpr Seen kColors[]{{235, 90, 160}, {240, 205, 50}, {240, 125, 35},
                             {225, 60, 60},  {60, 110, 210}, {80, 200, 100}};
    return chance_.one_of(kColors).in(transfer_);
  }

  /// A standing person.
  void put_person(double min_out_mm) {
    constexpr Seen kShoes[]{{28, 28, 30},  {230, 230, 232}, {190, 40, 40},
                            {45, 80, 180}, {225, 110, 35},  {90, 90, 95}};
    const Rim place = rim(min_out_mm, 330, false);
    const Color shoe = kShoes[static_cast<std::size_t>(chance_.whole(0, is_hard_ ? 5 : 3))].in(transfer_);
    const Color trousers = cloth();
    const double facing =
        std::atan2(-place.side->outward.y(), -place.side->outward.x()) + chance_.uniform(-0.5, 0.5);
    const Eigen::Vector2d front(std::cos(facing), std::sin(facing)), left(-front.y(), front.x());
    for (const double foot : {-1.0, 1.0}) {
      const double turned = facing + foot * chance_.uniform(0, 0.3);
      const Eigen::Vector2d at = place.at + foot * 110 * left + chance_.uniform(-60, 60) * front;
      hall_.furniture.push_back(std::make_unique<Ellipsoid>(Eigen::Vector3d(at.x(), at.y(), 30),
                                                            Eigen::Vector3d(145, 50, 45), turned, shoe));
      hall_.furniture.push_back(std::make_unique<Ellipsoid>(Eigen::Vector3d(at.x(), at.y(), 8),
                                                            Eigen::Vector3d(150, 55, 14), turned,
                                                            Seen{225, 225, 220}.in(transfer_)));
      const Eigen::Vector2d heel = at - 75 * front;
      const Eigen::Vector2d hip = place.at + foot * 90 * left + 20 * place.side->outward;
      hall_.furniture.push_back(std::make_unique<Capsule>(
          Eigen::Vector3d(heel.x(), heel.y(), 70), Eigen::Vector3d(hip.x(), hip.y(), 850), 65, trousers));
    }
    put_body(place.at + 30 * place.side->outward, 1150, facing, chance_.happens(0.5) ? cloth() : shirt());
  }

  /// Torso, arms and head.
  void put_body(const Eigen::Vector2d& at, double z, double facing, const Color& color) {
    const Eigen::Vector2d front(std::cos(facing), std::sin(facing)), left(-front.y(), front.x());
    hall_.furniture.push_back(std::make_unique<Ellipsoid>(Eigen::Vector3d(at.x(), at.y(), z),
                                                          Eigen::Vector3d(130, 215, 330), facing, color));
    const Color face = skin();
    const auto place = [&](double forward, double sideways, double up) {
      const Eigen::Vector2d p = at + forward * front + sideways * left;
      return Eigen::Vector3d(p.x(), p.y(), z + up);
    };
    for (const double arm : {-1.0, 1.0}) {
      const Eigen::Vector3d elbow = place(40, arm * 260, 0), hand = place(230, arm * 210, 20);
      hall_.furniture.push_back(std::make_unique<Capsule>(place(0, arm * 210, 250), elbow, 50, color));
      hall_.furniture.push_back(std::make_unique<Capsule>(elbow, hand, 38, face));
    }
    put_head(place(20, 0, 450), front, face);
  }

  void put_head(const Eigen::Vector3d& at, const Eigen::Vector2d& front, const Color& face) {
    constexpr Seen kHair[]{{45, 32, 26}, {20, 18, 18}, {120, 90, 55}, {150, 140, 130}};
    const double facing = std::atan2(front.y(), front.x());
    hall_.furniture.push_back(std::make_unique<Ellipsoid>(at, Eigen::Vector3d(95, 78, 100), facing, face));
    hall_.furniture.push_back(std::make_unique<Ellipsoid>(
        at + Eigen::Vector3d(-25 * front.x(), -25 * front.y(), 22), Eigen::Vector3d(88, 80, 92), facing,
        chance_.one_of(kHair).in(transfer_)));
  }

  void put_cone() {
    const Rim place = rim(50, 220, true);
    const Color orange =
        Seen{chance_.uniform(215, 250), chance_.uniform(80, 130), chance_.uniform(20, 50)}.in(transfer_);
    if (chance_.happens(0.5)) {
      const double base = chance_.uniform(60, 100);
      hall_.furniture.push_back(std::make_unique<Box>(
          Eigen::Vector3d(place.at.x(), place.at.y(), 5), Eigen::Vector3d(base * 1.1, base * 1.1, 5),
          chance_.uniform(0, 1.5), Box::Look{orange, orange, ""}));
      hall_.furniture.push_back(
          std::make_unique<Cone>(place.at, base, base * 0.2, base * 2.5, orange,
                                 chance_.happens(0.6) ? Seen{240, 240, 240}.in(transfer_) : orange));
    } else {
      hall_.furniture.push_back(std::make_unique<Cone>(place.at, 95, 28, 50, orange, orange));
    }
  }

  void stripe(const Eigen::Vector2d& at, double length, double width, const Color& color) {
    const double angle = chance_.uniform(0, std::numbers::pi);
    const Eigen::Vector2d half = Eigen::Vector2d(std::cos(angle), std::sin(angle)) * length / 2;
    hall_.floor.stripes.push_back({at - half, at + half, width / 2, color, true});
  }

  void stick_tape() {
    const Rim place = rim(-150, 250, false);
    const Color color =
        (chance_.happens(0.5) ? Seen{chance_.uniform(200, 240), chance_.uniform(40, 70), 40}
                              : Seen{chance_.uniform(220, 250), chance_.uniform(100, 140), 35})
            .in(transfer_);
    stripe(place.at, chance_.uniform(20, 70), chance_.uniform(15, 50), color);
  }

  /// A hand over the field, like that of a person who removes a robot.
  void reach_in() {
    const Rim place = rim(-350, -120, false);
    const Color color = skin(), sleeve = chance_.happens(0.5) ? color : cloth();
    const Eigen::Vector2d in = -place.side->outward, across(-in.y(), in.x());
    const double z = chance_.uniform(50, 180);
    const auto at = [&](double forward, double sideways, double up) {
      const Eigen::Vector2d p = place.at + forward * in + sideways * across;
      return Eigen::Vector3d(p.x(), p.y(), z + up);
    };
    hall_.furniture.push_back(std::make_unique<Ellipsoid>(at(0, 0, 0), Eigen::Vector3d(52, 42, 18),
                                                          std::atan2(in.y(), in.x()), color));
    for (const double finger : {-1.5, -0.5, 0.5, 1.5}) {
      const double spread = finger * chance_.uniform(18, 26);
      hall_.furniture.push_back(std::make_unique<Capsule>(
          at(40, finger * 18, 0), at(chance_.uniform(90, 115), spread, chance_.uniform(-30, 0)), 9, color));
    }
    const double thumb = chance_.sign();
    hall_.furniture.push_back(
        std::make_unique<Capsule>(at(-10, thumb * 35, 0), at(40, thumb * 72, -15), 11, color));
    hall_.furniture.push_back(std::make_unique<Capsule>(at(-45, 0, 5), at(-330, 20, 160), 34, color));
    hall_.furniture.push_back(std::make_unique<Capsule>(at(-300, 18, 145), at(-800, 60, 480), 52, sleeve));
  }

  /// The head and shoulders of a person who leans into the image; on the floor they cover places outside the
  /// lines.
  void lean_in() {
    const Rim place = rim(60, 260, false);
    const Color color = shirt();
    const Eigen::Vector3d eye = camera_.position_mm();
    const double z = chance_.uniform(900, 1200);
    // The point at `height` that covers this place of the floor for the camera.
    const auto hiding = [&](const Eigen::Vector2d& floor, double height) -> Eigen::Vector3d {
      return Eigen::Vector3d(floor.x(), floor.y(), 0) +
             (eye - Eigen::Vector3d(floor.x(), floor.y(), 0)) * (height / eye.z());
    };
    const Eigen::Vector2d out = place.side->outward, across(-out.y(), out.x());
    const double yaw = std::atan2(out.y(), out.x());
    hall_.furniture.push_back(std::make_unique<Ellipsoid>(hiding(place.at + 150 * out, z),
                                                          Eigen::Vector3d(150, 230, 150), yaw, color));
    put_head(hiding(place.at - 10 * out, z + 120), -out, skin());
    for (const double arm : {-1.0, 1.0}) {
      const Eigen::Vector3d shoulder = hiding(place.at + 150 * out + arm * 190 * across, z - 20);
      const Eigen::Vector3d elbow = shoulder + Eigen::Vector3d(-60 * out.x(), -60 * out.y(), -240);
      hall_.furniture.push_back(std::make_unique<Capsule>(shoulder, elbow, 50, color));
    }
  }

  Hall& hall_;
  Chance chance_;
  CameraModel camera_;
  Transfer transfer_;
  bool is_hard_;
  std::array<Side, 3> sides_;
};

}  // namespace

void furnish(Hall& hall) {
  Furnisher furnisher(hall);
  if (hall.options.kind != Kind::kAcceptance) furnisher.furnish();
  furnisher.distract();
}

}  // namespace sslv::halls
