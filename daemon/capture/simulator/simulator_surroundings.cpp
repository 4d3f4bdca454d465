// SPDX-License-Identifier: Apache-2.0
#include "capture/simulator/simulator_surroundings.h"

#include "capture/simulator/simulator_carpet.h"
#include "capture/simulator/simulator_texture.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace sslv {
namespace {

constexpr double kBoardGapMm = 20, kBoardThickMm = 18;  // gap between carpet and boards; thickness of a board
constexpr Paint kGreyFloor{92, 88, 84}, kDarkFloor{50, 50, 53}, kWoodFloor{150, 108, 68};
constexpr Paint kWhite{212, 212, 207}, kBlack{26, 26, 29}, kSkin{224, 172, 140}, kOrange{236, 104, 28};
constexpr std::array<Paint, 9> kBoardPaints{{kOrange,
                                             {205, 32, 36},
                                             {230, 198, 40},
                                             {26, 72, 186},
                                             {226, 62, 146},
                                             {62, 172, 72},
                                             kWhite,
                                             kBlack,
                                             {52, 182, 206}}};
constexpr std::array<Paint, 9> kClothPaints{{{40, 44, 60},
                                             kBlack,
                                             {70, 74, 82},
                                             {176, 34, 40},
                                             {34, 72, 158},
                                             kWhite,
                                             {228, 110, 40},
                                             {206, 70, 130},
                                             {44, 120, 66}}};

/// Empty margin, as a fraction of a board's height or of a letter's cell.
constexpr double kMargin = 0.2;

}  // namespace

/// Places the surroundings according to the seed.
class SimulatedSurroundings::Furnisher {
 public:
  Furnisher(SimulatedSurroundings& out, const HallOptions& hall, const FieldSize& field)
      : out_(out),
        random_(scatter(static_cast<std::uint64_t>(hall.seed)) + 4),
        margin_mm_(std::min(field.boundary_width, field.boundary_width_goal_line)) {
    put_boards(hall.around.boards.value());
    for (int i = 0; i < hall.around.things.value(); ++i) put_thing();
    for (int i = 0; i < hall.around.people.value(); ++i) put_person();
  }

 private:
  /// A place at the carpet's rim.
  struct Spot {
    Eigen::Vector2d at, outwards, along;
    Eigen::Vector2d off(double outwards_mm, double along_mm = 0) const {
      return at + outwards_mm * outwards + along_mm * along;
    }
  };

  Spot anywhere() {
    const auto [x, y] = out_.half_carpet_mm_;
    const double sign = random_.bits() % 2 == 0 ? 1 : -1;
    if (random_.uniform(0, x + y) < y) return {{sign * x, random_.uniform(-y, y)}, {sign, 0}, {0, 1}};
    return {{random_.uniform(-x, x), sign * y}, {0, sign}, {1, 0}};
  }
  template <std::size_t N>
  const Paint& any(const std::array<Paint, N>& paints) {
    return paints[random_.bits() % N];
  }
  double angle_of(const Eigen::Vector2d& v) const { return std::atan2(v.y(), v.x()); }

  void put_boards(double share) {
    out_.board_height_mm_ = random_.uniform(160, 420);
    for (int axis = 0; axis < 2; ++axis) {
      for (const double sign : {-1.0, 1.0}) {
        const double end = out_.half_carpet_mm_[static_cast<std::size_t>(1 - axis)];
        double from = -end;
        while (from < end) {
          const double to = std::min(end, from + random_.uniform(900, 3200));
          const Paint& face = any(kBoardPaints);
          const Paint& letters = face.luma() > 120 ? (random_.bits() % 3 == 0 ? kBoardPaints[3] : kBlack)
                                                   : (random_.bits() % 3 == 0 ? kBoardPaints[2] : kWhite);
          const Paint& logo = any(kBoardPaints);
          if (random_.uniform(0, 1) < share && to - from > 300) {
            out_.boards_.push_back({axis, sign, from + 5, to - 5, face, letters, logo, random_.bits()});
          }
          from = to;
        }
      }
    }
  }

  void stack(bool is_round, const Eigen::Vector2d& at, double turn_rad, double half_length_mm,
             double half_width_mm, double from_mm, double to_mm, const Paint& paint, double step_mm = 25) {
    // Sides get less light than the top, and the bottom gets the least.
    const int steps = std::max(1, static_cast<int>(std::lround((to_mm - from_mm) / step_mm)));
    for (int i = 0; i <= steps; ++i) {
      const double up = static_cast<double>(i) / steps;
      const auto light = static_cast<float>(i == steps ? 1 : 0.6 + 0.2 * up);
      out_.slices_.push_back({is_round,
                              {at.x(), at.y(), from_mm + up * (to_mm - from_mm)},
                              turn_rad,
                              half_length_mm,
                              half_width_mm,
                              paint.scaled(light)});
    }
  }

  void put_thing() {
    enum Kind { kCone, kCable, kBag, kBottle, kTape, kLaptop, kPaper, kKinds };
    constexpr std::array<Kind, 12> kOften{kCone, kCone,   kCone, kCable, kCable,  kCable,
                                          kBag,  kBottle, kTape, kTape,  kLaptop, kPaper};
    const Spot spot = anywhere();
    // Most things lie beside the carpet.
    double off_mm = random_.uniform(130, 800);
    const double turn = random_.angle();
    constexpr double kMinMarginMm = 200;  // so that no thing reaches the lines
    const Kind kind = kOften[random_.bits() % kOften.size()];
    const bool is_small = kind == kCone || kind == kBottle || kind == kTape || kind == kCable;
    if (is_small && margin_mm_ >= kMinMarginMm && random_.uniform(0, 1) < 0.4)
      off_mm = -random_.uniform(0.3, 0.5) * margin_mm_;
    const Eigen::Vector2d at = spot.off(off_mm);
    switch (kind) {
      case kCone: {
        constexpr int kSteps = 18;
        const double height_mm = random_.uniform(110, 220), radius_mm = 0.32 * height_mm;
        const Paint cone = random_.bits() % 3 == 0 ? kBoardPaints[1] : kOrange;
        stack(false, at, turn, radius_mm, radius_mm, 0, 12, cone.scaled(0.8F), 12);
        for (int i = 0; i < kSteps; ++i) {
          const double up = static_cast<double>(i) / kSteps;
          const bool is_band = up > 0.45 && up < 0.65;
          const double r = radius_mm * (0.8 - 0.72 * up);
          out_.slices_.push_back({true,
                                  {at.x(), at.y(), 12 + up * height_mm},
                                  0,
                                  r,
                                  r,
                                  (is_band ? kWhite : cone).scaled(0.75F)});
        }
        return;
      }
      case kCable: return put_cable(spot, off_mm);
      case kBag:
        return stack(false, spot.off(off_mm + 200), turn, random_.uniform(120, 260), random_.uniform(90, 170),
                     0, random_.uniform(90, 260), any(kClothPaints));
      case kBottle: {
        const double height_mm = random_.uniform(160, 280);
        stack(true, at, 0, 34, 34, 0, height_mm, any(kBoardPaints));
        return stack(true, at, 0, 17, 17, height_mm, height_mm + 25, any(kBoardPaints));
      }
      case kTape:
        stack(true, at, 0, 55, 55, 0, 45, any(kBoardPaints), 15);
        return stack(true, at, 0, 38, 38, 45, 46, kBlack.scaled(1.4F));
      case kLaptop: {
        const Eigen::Vector2d place = spot.off(off_mm + 100);
        stack(false, place, turn, 165, 115, 0, 18, {70, 72, 76}, 9);
        return stack(false, place, turn, 140, 70, 18, 19, {150, 178, 205});
      }
      case kPaper: return stack(false, spot.off(off_mm + 60), turn, 148, 105, 0, 1, kWhite);
      case kKinds: return;
    }
  }

  /// A cable that winds along the carpet's rim, and covers at most the outer half of the margin.
  void put_cable(const Spot& spot, double off_mm) {
    constexpr std::array<Paint, 5> kSheaths{
        {kBlack, kOrange, {220, 190, 40}, {30, 70, 170}, {150, 150, 150}}};
    const Paint sheath = any(kSheaths);
    const double piece_mm = 60, half_width_mm = random_.uniform(3, 7);
    double heading = random_.uniform(-0.6, 0.6) + (random_.bits() % 2 == 0 ? 0 : std::numbers::pi);
    Eigen::Vector2d at(off_mm, 0);  // coordinates: outwards from the rim, along the rim
    for (auto pieces = 10 + random_.bits() % 40; pieces > 0; --pieces) {
      heading += random_.uniform(-0.35, 0.35);
      if (at.x() < -0.3 * margin_mm_) heading -= 0.3 * std::sin(heading - std::numbers::pi / 2);
      const Eigen::Vector2d step(std::sin(heading), std::cos(heading));
      at += piece_mm * step;
      at.x() = std::max(at.x(), -0.5 * margin_mm_);
      const Eigen::Vector2d way = spot.outwards * step.x() + spot.along * step.y();
      stack(false, spot.off(at.x(), at.y()), angle_of(way), piece_mm * 0.6, half_width_mm, 4, 5, sheath);
    }
  }

  void put_person() {
    const Spot spot = anywhere();
    const double off_mm = random_.uniform(170, 520), towards = angle_of(spot.outwards);
    const Eigen::Vector2d at = spot.off(off_mm);
    const Paint trousers = any(kClothPaints), shirt = any(kClothPaints), shoe = any(kClothPaints);
    const Paint hair = Paint{60, 44, 34}.mixed(kBlack, static_cast<float>(random_.uniform(0, 1)));
    for (const double side : {-1.0, 1.0}) {
      const Eigen::Vector2d foot = spot.off(off_mm - random_.uniform(40, 110), side * 130);
      stack(true, foot, towards + side * 0.15, 142, 52, 0, 22, kWhite.scaled(0.8F), 11);
      stack(true, foot, towards + side * 0.15, 132, 46, 22, 70, shoe, 12);
      stack(true, spot.off(off_mm, side * 110), 0, 78, 78, 70, 850, trousers, 40);
    }
    stack(true, at, towards, 135, 235, 850, 1420, shirt, 45);
    stack(true, spot.off(off_mm - 30), 0, 95, 95, 1470, 1640, hair.scaled(1.2F), 40);
    out_.shadows_of_people_.push_back({at, 420});
    if (random_.uniform(0, 1) < 0.6) put_arm(spot, off_mm, shirt);
  }

  /// An arm that reaches over the rim, as if for a ball.
  void put_arm(const Spot& spot, double off_mm, const Paint& sleeve) {
    constexpr int kSteps = 30;
    const double side_mm = random_.bits() % 2 == 0 ? 190 : -190;
    const Eigen::Vector3d shoulder(off_mm - 60, side_mm, 1150);
    const Eigen::Vector3d hand(-random_.uniform(0, 0.9) * std::max(0.0, margin_mm_ - 70),
                               side_mm + random_.uniform(-250, 250), random_.uniform(150, 500));
    const double bare_from = random_.uniform(0.3, 0.8);
    for (int i = 0; i <= kSteps; ++i) {
      const double t = static_cast<double>(i) / kSteps;
      const Eigen::Vector3d p = shoulder + t * (hand - shoulder);
      const Eigen::Vector2d at = spot.off(p.x(), p.y());
      const double r = t < bare_from ? 52 : t > 0.9 ? 46 : 36;
      out_.slices_.push_back(
          {true, {at.x(), at.y(), p.z()}, 0, r, r, (t < bare_from ? sleeve : kSkin).scaled(0.9F)});
    }
    out_.shadows_of_people_.push_back({spot.off(hand.x(), hand.y()), 160});
  }

  SimulatedSurroundings& out_;
  SimulatorRandom random_;
  double margin_mm_;  // width of the carpet outside the lines
};

SimulatedSurroundings::SimulatedSurroundings(const HallOptions& hall, const FieldSize& field)
    : half_carpet_mm_{field.field_length / 2.0 + field.boundary_width_goal_line,
                      field.field_width / 2.0 + field.boundary_width},
      half_boards_mm_{half_carpet_mm_[0] + kBoardGapMm, half_carpet_mm_[1] + kBoardGapMm},
      floor_(hall.around.floor.value()),
      shadows_(static_cast<float>(hall.lamps.shadows.value())) {
  Furnisher(*this, hall, field);
}

bool SimulatedSurroundings::on_carpet(const Eigen::Vector2d& p) const {
  return std::abs(p.x()) <= half_carpet_mm_[0] && std::abs(p.y()) <= half_carpet_mm_[1];
}

Paint SimulatedSurroundings::floor_at(const Eigen::Vector2d& p) const {
  const float tone = SimulatedCarpet::tone_at(p);
  if (floor_ == HallFloor::kGrey) return kGreyFloor.scaled(tone);
  if (floor_ == HallFloor::kDark) return kDarkFloor.scaled(tone);
  constexpr double kPlankMm = 110, kPlankLongMm = 1400, kGapMm = 3;
  const double row = std::floor(p.y() / kPlankMm);
  const double shifted = p.x() + 3000 * lattice_value(row, 0, 12),
               column = std::floor(shifted / kPlankLongMm);
  const float plank =
      1 + 0.25F * lattice_value(row, column, 13) + 0.2F * lattice_noise(p.x(), 12 * p.y(), 160, 14);
  const double gap = std::min(p.y() - row * kPlankMm, shifted - column * kPlankLongMm);
  return kWoodFloor.scaled(plank * (gap < kGapMm ? 0.6F : 1.0F));
}

float SimulatedSurroundings::shade_at(const Eigen::Vector2d& p) const {
  float light = 1;
  if (shadows_ <= 0) return light;
  for (const Blob& blob : shadows_of_people_) {
    const auto away = static_cast<float>((p - blob.middle_mm).norm());
    light *= 1 - 0.5F * shadows_ * (1 - smooth_step(0.3F * blob.reach_mm, blob.reach_mm, away));
  }
  for (int axis = 0; axis < 2 && has_boards(); ++axis) {
    const double across = p[axis], sign = across < 0 ? -1 : 1;
    const double away_mm = std::abs(std::abs(across) - half_boards_mm_[static_cast<std::size_t>(axis)]);
    if (away_mm > 300 || board_at(axis, sign, p[1 - axis]) == nullptr) continue;
    light *= 1 - 0.6F * shadows_ * static_cast<float>(std::exp(-away_mm / 70));
  }
  return light;
}

const SimulatedSurroundings::Board* SimulatedSurroundings::board_at(int axis, double sign,
                                                                    double along_mm) const {
  const auto found = std::find_if(boards_.begin(), boards_.end(), [&](const Board& board) {
    return board.axis == axis && board.sign == sign && board.from_mm <= along_mm && along_mm <= board.to_mm;
  });
  return found == boards_.end() ? nullptr : &*found;
}

bool SimulatedSurroundings::is_behind_boards(const Eigen::Vector2d& p) const {
  return std::abs(p.x()) > half_boards_mm_[0] || std::abs(p.y()) > half_boards_mm_[1];
}

/// The colour of a board's face: a round logo, then words of invented letters.
Paint SimulatedSurroundings::face_of(const Board& board, double along_mm, double up_mm) const {
  const double u = (along_mm - board.from_mm) / board_height_mm_, v = up_mm / board_height_mm_;
  const auto light = static_cast<float>(0.62 + 0.2 * v);
  if (std::hypot(u - 0.65, v - 0.5) < 0.32) return board.logo.scaled(light);
  constexpr double kLetter = 0.5;
  constexpr int kColumns = 3, kRows = 5;
  const double at = (u - 1.2) / kLetter, cell = std::floor(at);
  const double column = (at - cell) / (1 - kMargin) * kColumns,
               row = (v - kMargin) / (1 - 2 * kMargin) * kRows;
  const bool on_letter = cell >= 0 && column < kColumns && row >= 0 && row < kRows &&
                         u + kLetter < (board.to_mm - board.from_mm) / board_height_mm_;
  if (!on_letter) return board.face.scaled(light);
  const std::uint64_t strokes = scatter(board.text + static_cast<std::uint64_t>(cell));
  const auto bit = static_cast<unsigned>(static_cast<int>(row) * kColumns + static_cast<int>(column));
  const bool is_space = strokes >> 60 < 3;
  const bool is_ink = static_cast<int>(column) == 0 || (strokes >> bit & 1) != 0;
  return (is_ink && !is_space ? board.letters : board.face).scaled(light);
}

std::optional<Paint> SimulatedSurroundings::board_before(const Eigen::Vector2d& p,
                                                         const Eigen::Vector3d& eye_mm) const {
  std::optional<Paint> out;
  double nearest = -1;
  for (int axis = 0; axis < 2; ++axis) {
    const double plane_mm = half_boards_mm_[static_cast<std::size_t>(axis)];
    const double sign = p[axis] < 0 ? -1 : 1;
    const double floor_mm = sign * p[axis], from_mm = sign * eye_mm[axis];
    if (floor_mm <= plane_mm || from_mm >= plane_mm) continue;
    // Fraction of the line of sight at which the line crosses the board's plane.
    const double share = (floor_mm - plane_mm) / (floor_mm - from_mm), up_mm = share * eye_mm.z();
    const double along_mm = p[1 - axis] + share * (eye_mm[1 - axis] - p[1 - axis]);
    if (share < nearest) continue;
    const Board* board = board_at(axis, sign, along_mm);
    if (board == nullptr) continue;
    if (up_mm <= board_height_mm_) {
      out = face_of(*board, along_mm, up_mm);
      nearest = share;
      continue;
    }
    const double top_mm = floor_mm + board_height_mm_ / eye_mm.z() * (from_mm - floor_mm);
    if (top_mm >= plane_mm && top_mm <= plane_mm + kBoardThickMm) {
      out = board->face.mixed(kWhite, 0.5F);
      nearest = share;
    }
  }
  return out;
}

}  // namespace sslv
