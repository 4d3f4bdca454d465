// SPDX-License-Identifier: Apache-2.0
// Verdicts of the painted-line check on halls not drawn by the simulator: with the true calibration, with a
// camera that was moved, and with another field size. One table row per kind of hall.

#include "calibration/check_lines.h"
#include "draw.h"
#include "hall.h"
#include "play.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace sslv::halls {
namespace {

constexpr double kWindowMm = 250, kWarnMm = 25, kMissing = 0.4;

LinesVerdict judged(const ImageView& image, const CameraCalibration& calibration, const FieldSize& field) {
  return judge_lines(check_lines(image, CameraModel(calibration), painted_curves(field), kWindowMm));
}

LinesVerdict better(const LinesVerdict& a, const LinesVerdict& b) {
  if (a.missing_share != b.missing_share) return a.missing_share < b.missing_share ? a : b;
  return a.worst_mm <= b.worst_mm ? a : b;
}

bool is_named(const LinesVerdict& verdict) {
  return verdict.lines > 0 && (verdict.worst_mm > kWarnMm || verdict.missing_share > kMissing);
}

void table(Kind kind, const char* name, Size size, PixelFormat format, int seeds) {
  int good = 0, unjudged = 0;
  std::array<int, 4> tried{}, found{};  // 40, 80, 150 mm, other sizes
  double worst_mm = 0, worst_missing = 0;
  std::string alarms;
  for (int seed = 1; seed <= seeds; ++seed) {
    HallOptions options;
    options.kind = kind;
    options.size = size;
    options.seed = static_cast<std::uint64_t>(seed);
    const Hall hall = make_hall(options);
    const CameraModel camera(hall.calibration);
    Painter painter(hall, camera);
    const Obstacles obstacles(camera, painter.obstacles());
    const Game game(hall, camera, obstacles, {});
    std::array<std::vector<std::uint8_t>, 2> bytes;
    std::array<ImageView, 2> images;
    for (std::size_t i = 0; i < 2; ++i) {
      const Picture light = painter.frame(game.at(static_cast<int>(i) + 1), static_cast<int>(i) + 1, 1);
      bytes[i] = camera_bytes(light, hall.sensor, format, Chance(hall.seed, "noise", i));
      images[i] = ImageView{bytes[i].data(), light.width, light.height,
                            light.width * (format == PixelFormat::kUyvy ? 2 : 1), format};
    }
    const auto of = [&](const CameraCalibration& calibration, const FieldSize& field) {
      return better(judged(images[0], calibration, field), judged(images[1], calibration, field));
    };
    const LinesVerdict truth = of(hall.calibration, hall.field);
    if (truth.lines == 0) {
      ++unjudged;
      continue;
    }
    worst_mm = std::max(worst_mm, truth.worst_mm);
    worst_missing = std::max(worst_missing, truth.missing_share);
    const auto is_better = [&](const LinesVerdict& judged, const FieldSize& field) {
      return find_better_size(images[0], camera, field, judged, kWindowMm) != nullptr;
    };
    if (is_named(truth) || is_better(truth, hall.field)) {
      alarms += fmt::format(" {}:{:.0f}mm/{:.0f}%", seed, truth.worst_mm, 100 * truth.missing_share);
    } else {
      ++good;
    }
    std::size_t k = 0;
    for (const double moved_mm : {40.0, 80.0, 150.0}) {
      for (const double angle : {0.0, 0.9, 2.2, 4.0}) {
        CameraCalibration moved = hall.calibration;
        const Eigen::Quaterniond q(moved.q3, moved.q0, moved.q1, moved.q2);
        const Eigen::Vector3d t(moved.tx, moved.ty, moved.tz);
        const Eigen::Vector3d shift =
            q * Eigen::Vector3d(moved_mm * std::cos(angle), moved_mm * std::sin(angle), 0);
        moved.tx = t.x() + shift.x();
        moved.ty = t.y() + shift.y();
        moved.tz = t.z() + shift.z();
        ++tried[k];
        found[k] += is_named(of(moved, hall.field));
      }
      ++k;
    }
    // A camera over half of the field may see no line whose place differs between the divisions.
    FieldSize other = field_preset(size == Size::kB ? "division-a" : "division-b", "");
    if (size == Size::kA) {
      other = hall.field;
      other.field_length = other.field_length * 3 / 4;
      other.field_width = other.field_width * 3 / 4;
    }
    ++tried[3];
    const LinesVerdict told = of(hall.calibration, other);
    found[3] += is_named(told) || is_better(told, other);
  }
  fmt::print("| {} | {} | {} | {} of {} | {} | {:.0f} | {:.0f} | {}/{} | {}/{} | {}/{} | {}/{} |{}\n", name,
             "ABC"[static_cast<int>(size)], name_of(format), good, seeds - unjudged, unjudged, worst_mm,
             100 * worst_missing, found[0], tried[0], found[1], tried[1], found[2], tried[2], found[3],
             tried[3], alarms);
  std::fflush(stdout);
}

}  // namespace
}  // namespace sslv::halls

int main(int argc, char** argv) {
  using namespace sslv;
  using namespace sslv::halls;
  const int seeds = argc > 1 ? std::atoi(argv[1]) : 10;
  fmt::print(
      "| hall | size | format | content | not judged | worst mm | most missing % | 40 mm | 80 mm | 150 mm | "
      "other sizes |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|\n");
  const std::array<std::pair<Kind, const char*>, 3> kinds{
      {{Kind::kAcceptance, "acceptance"}, {Kind::kUsual, "usual"}, {Kind::kHard, "hard"}}};
  for (const auto& [kind, name] : kinds) {
    table(kind, name, Size::kA, PixelFormat::kUyvy, seeds);
    table(kind, name, Size::kB, PixelFormat::kBayerRg8, seeds);
    if (seeds > 10) table(kind, name, Size::kC, PixelFormat::kUyvy, seeds / 10);
  }
}
