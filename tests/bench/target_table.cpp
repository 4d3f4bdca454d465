// SPDX-License-Identifier: Apache-2.0
// Compares the results of the CPU's vector instruction sets on the same images, as a table in Markdown:
// target_table CLIP... Replays each clip as on CPUs without the better sets and compares the results with
// those of this CPU's best set. Exit code 1 on any difference.
#include "replay/replay_clip.h"
#include "support/simd_target.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <numbers>
#include <optional>
#include <span>
#include <stdexcept>
#include <tuple>
#include <vector>

#include <fmt/format.h>

namespace sslv {
namespace {

struct Found {
  RegionList regions;
  RobotList robots;
  BallList balls;
};

struct Difference {
  std::size_t regions = 0, ids = 0, balls = 0;  // frames in which they differ
  double robot_mm = 0, robot_rad = 0, ball_mm = 0, confidence = 0;
};

std::vector<Found> replay(ClipReader& clip, std::uint32_t camera_id) {
  std::vector<Found> out;
  ClipReplay replay(clip, camera_id);
  for (ClipReplay::Result result; replay.next(result);)
    out.push_back({result.frame->regions, result.frame->robots, result.frame->balls});
  return out;
}

bool same_regions(const RegionList& a, const RegionList& b) {
  return std::ranges::equal(a.regions, b.regions, [](const Region& one, const Region& other) {
    const auto all = [](const Region& region) {
      return std::tie(region.label, region.area_px, region.left, region.top, region.right, region.bottom,
                      region.x_px, region.y_px);
    };
    return all(one) == all(other);
  });
}

/// Matches detections by identity: those of equal confidence may be in another order.
template <class Thing, class IsSame, class Compare>
bool compare_each(const std::vector<Thing>& here, const std::vector<Thing>& there, const IsSame& is_same,
                  const Compare& compare) {
  if (here.size() != there.size()) return false;
  for (const Thing& thing : here) {
    const auto same = std::ranges::find_if(there, [&](const Thing& other) { return is_same(thing, other); });
    if (same == there.end()) return false;
    compare(thing, *same);
  }
  return true;
}

Difference difference_of(const std::vector<Found>& here, const std::vector<Found>& best) {
  Difference out;
  const auto apart_mm = [](const auto& a, const auto& b) {
    return std::hypot(a.x_mm - b.x_mm, a.y_mm - b.y_mm);
  };
  for (std::size_t i = 0; i < best.size(); ++i) {
    if (!same_regions(here[i].regions, best[i].regions)) ++out.regions;
    const bool ids = compare_each(
        here[i].robots.robots, best[i].robots.robots,
        [&](const Robot& a, const Robot& b) {
          return a.team == b.team && a.id == b.id && apart_mm(a, b) < 50;
        },
        [&](const Robot& a, const Robot& b) {
          out.robot_mm = std::max(out.robot_mm, apart_mm(a, b));
          const double rad = std::remainder(a.orientation_rad - b.orientation_rad, 2 * std::numbers::pi);
          out.robot_rad = std::max(out.robot_rad, std::abs(rad));
          out.confidence = std::max(out.confidence, std::abs(a.confidence - b.confidence));
        });
    if (!ids) ++out.ids;
    const bool balls = compare_each(
        here[i].balls.balls, best[i].balls.balls,
        [&](const Ball& a, const Ball& b) { return apart_mm(a, b) < 20; },
        [&](const Ball& a, const Ball& b) {
          out.ball_mm = std::max(out.ball_mm, apart_mm(a, b));
          out.confidence = std::max(out.confidence, std::abs(a.confidence - b.confidence));
        });
    if (!balls) ++out.balls;
  }
  return out;
}

bool print_clip(const std::filesystem::path& file) {
  bool is_good = true;
  ClipReader clip(file);
  for (const ClipReader::Camera& camera : clip.cameras()) {
    std::optional<std::vector<Found>> best;
    for (const std::int64_t target : cpu_targets()) {
      const OnlyTarget only(target);
      std::vector<Found> found = replay(clip, camera.id);
      std::size_t robots = 0, balls = 0;
      for (const Found& frame : found)
        robots += frame.robots.robots.size(), balls += frame.balls.balls.size();
      if (found.empty() || (best && found.size() != best->size()))
        throw std::runtime_error(file.string() + ": there is nothing to compare");
      const Difference apart = difference_of(found, best ? *best : found);
      const bool is_same = apart.regions + apart.ids + apart.balls == 0 &&
                           apart.robot_mm + apart.robot_rad + apart.ball_mm + apart.confidence == 0;
      is_good = is_good && is_same;
      fmt::print("| {}, {} | {} | {} | {} | {} | {} | {} | {} | {:.1e} | {:.1e} | {:.1e} | {:.1e} |\n",
                 file.filename().string(), camera.id, name_of_target(target), found.size(), robots, balls,
                 apart.regions, apart.ids, apart.balls, apart.robot_mm, apart.robot_rad, apart.ball_mm,
                 apart.confidence);
      std::fflush(stdout);
      if (!best) best = std::move(found);
    }
  }
  return is_good;
}

}  // namespace
}  // namespace sslv

int main(int argc, char** argv) {
  fmt::print(
      "| clip, camera | instructions | frames | robots | balls | frames with other regions | other ids | "
      "other balls "
      "| robots apart (mm) | (rad) | balls apart (mm) | confidences "
      "|\n|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  bool is_good = true;
  try {
    for (const char* file : std::span(argv, static_cast<std::size_t>(argc)).subspan(1))
      is_good = sslv::print_clip(file) && is_good;
  } catch (const std::exception& e) {
    fmt::print(stderr, "target_table: {}\n", e.what());
    return 1;
  }
  return is_good ? 0 : 1;
}
