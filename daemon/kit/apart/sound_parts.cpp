// SPDX-License-Identifier: Apache-2.0
#include "kit/apart/sound_parts.h"

#include "vision/flood_cut.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace sslv::apart {
namespace {

constexpr int kMaxId = 255;          // Scene::roster
constexpr int kMaxImagePx = 16'384;  // is_valid_size()

bool fits_image(int width, int height, int cell_px, const ImageView& image) {
  if (width == 0 && height == 0) return true;
  return (cell_px == 1 || cell_px == 2) && width > 0 && height > 0 && width * cell_px <= image.width &&
         height * cell_px <= image.height && width <= kMaxImagePx && height <= kMaxImagePx;
}

bool is_id(int id) {
  return id >= 0 && id <= kMaxId;
}

template <class... Number>
bool are_finite(Number... number) {
  return (std::isfinite(number) && ...);
}

bool are_finite_sightings(const CameraSightings& part) {
  if (part.robots.size() > kMaxRobots || part.balls.size() > kMaxBalls) return false;
  return std::isfinite(part.t_capture_s) && part.camera_mm.allFinite() &&
         std::ranges::all_of(
             part.robots,
             [](const RobotSighting& robot) {
               return is_id(robot.id) && robot.place_mm.allFinite() && robot.place_cov_mm2.allFinite() &&
                      are_finite(robot.orientation_rad, robot.height_mm, robot.orientation_sigma_rad);
             }) &&
         std::ranges::all_of(part.balls, [](const BallSighting& ball) {
           return ball.place_mm.allFinite() && ball.place_cov_mm2.allFinite() &&
                  are_finite(ball.confidence, ball.height_mm);
         });
}

void empty(LabelImage& part) {
  part.width = part.height = 0;
}
void empty(RunList& part) {
  part.width = part.height = 0;
  part.runs.clear();
  part.flood = {};
  part.cut.clear();
}
void empty(RegionList& part) {
  part.regions.clear();
  part.begin = {};
  part.capped = false;
}
void empty(RobotList& part) {
  part.robots.clear();
  part.second_robots.clear();
  part.capped = false;
}
void empty(BallList& part) {
  part.balls.clear();
  part.capped = false;
}
void empty(FrameInfo&) {}
void empty(Image&) {}
void empty(ArrivedSightings&) {}
void empty(CameraSightings& part) {
  part.is_taken = false;
  part.robots.clear();
  part.balls.clear();
}
void empty(LeftOut&) {}
void empty(ImageTime& part) {
  part = {};
}
void empty(Observations& part) {
  part.robots.clear();
  part.balls.clear();
}
void empty(CameraAgreement&) {}
void empty(TrackedField& part) {
  part.robots.clear();
  part.balls.clear();
  part.kick.reset();
}

template <class Floor>
void make_parts_empty(typename Floor::Frame& frame, PartSet written) {
  std::size_t i = 0;
  std::apply([&](const auto&... part) { ((written[i++] ? empty(frame.*part.member) : void()), ...); },
             Floor::kParts);
}

}  // namespace

bool is_sound(const FrameInfo& part, const Frame&, const Frame& before) {
  return makes_sense(part, before.info);
}

bool is_sound(const LabelImage& part, const Frame& now, const Frame&) {
  if (!fits_image(part.width, part.height, part.cell_px, now.image.view())) return false;
  if (part.labels.size() < static_cast<std::size_t>(part.width) * static_cast<std::size_t>(part.height))
    return false;
  // Not all_of(): without an end in the middle it is done many at a time.
  Label largest = 0;
  for (const Label one : part.labels) largest = std::max(largest, one);
  return largest < label::kMaxCount;
}

bool is_sound(const RunList& part, const Frame& now, const Frame&) {
  if (!fits_image(part.width, part.height, part.cell_px, now.image.view())) return false;
  if (part.runs.size() > kMaxRuns || part.flood.label >= label::kMaxCount) return false;
  const auto blocks = [](int cells) {
    return static_cast<std::size_t>((cells + FloodCut::kBlockCells - 1) / FloodCut::kBlockCells);
  };
  if (!part.cut.empty() && part.cut.size() != blocks(part.width) * blocks(part.height)) return false;
  const Run* last = nullptr;
  for (const Run& run : part.runs) {
    if (run.label == label::kClear || run.label >= label::kMaxCount || run.y >= part.height ||
        run.x_begin >= run.x_end || run.x_end > part.width)
      return false;
    if (last != nullptr && (run.y < last->y || (run.y == last->y && run.x_begin < last->x_end))) return false;
    last = &run;
  }
  return true;
}

bool is_sound(const RegionList& part, const Frame& now, const Frame&) {
  if (part.regions.size() > kMaxRegions || part.begin.back() != part.regions.size()) return false;
  if (!std::is_sorted(part.begin.begin(), part.begin.end())) return false;
  for (std::size_t one = 0; one + 1 < part.begin.size(); ++one) {
    for (std::size_t i = part.begin[one]; i < part.begin[one + 1]; ++i) {
      const Region& region = part.regions[i];
      if (region.label != one || region.label >= label::kMaxCount || region.left > region.right ||
          region.top > region.bottom || region.right >= now.image.view().width ||
          region.bottom >= now.image.view().height || !are_finite(region.x_px, region.y_px) ||
          region.x_px < region.left || region.x_px > region.right + 1.F || region.y_px < region.top ||
          region.y_px > region.bottom + 1.F || region.area_px == 0)
        return false;
      if (!now.runs.runs.empty() && region.first_run >= now.runs.runs.size()) return false;
    }
  }
  return true;
}

bool is_sound(const RobotList& part, const Frame&, const Frame&) {
  if (part.robots.size() + part.second_robots.size() > kMaxRobots) return false;
  const auto is_good = [](const Robot& robot) {
    return is_id(robot.id) && robot.confidence >= 0 && robot.confidence <= 1 &&
           are_finite(robot.x_mm, robot.y_mm, robot.orientation_rad, robot.height_mm, robot.pixel_x,
                      robot.pixel_y, robot.place_cov.xx_mm2, robot.place_cov.xy_mm2, robot.place_cov.yy_mm2,
                      robot.orientation_sigma_rad);
  };
  return std::ranges::all_of(part.robots, is_good) && std::ranges::all_of(part.second_robots, is_good);
}

bool is_sound(const BallList& part, const Frame&, const Frame&) {
  return part.balls.size() <= kMaxBalls && std::ranges::all_of(part.balls, [](const Ball& ball) {
           return ball.confidence >= 0 && ball.confidence <= 1 &&
                  are_finite(ball.x_mm, ball.y_mm, ball.pixel_x, ball.pixel_y, ball.place_cov.xx_mm2,
                             ball.place_cov.xy_mm2, ball.place_cov.yy_mm2, ball.radius_mm,
                             ball.radius_sigma_mm);
         });
}

bool is_sound(const ArrivedSightings& part, const FieldFrame&, const FieldFrame&) {
  return are_finite_sightings(part.image);
}

bool is_sound(const CameraSightings& part, const FieldFrame&, const FieldFrame&) {
  return are_finite_sightings(part);
}

bool is_sound(const LeftOut& part, const FieldFrame&, const FieldFrame&) {
  return std::isfinite(part.t_s);
}

bool is_sound(const ImageTime& part, const FieldFrame&, const FieldFrame&) {
  return are_finite(part.t_s.value_or(0), part.sigma_s);
}

bool is_sound(const Observations& part, const FieldFrame&, const FieldFrame&) {
  if (part.robots.size() > kMaxRobots || part.balls.size() > kMaxBalls) return false;
  return std::ranges::all_of(part.robots,
                             [](const RobotObservation& robot) {
                               return is_id(robot.name.id) && robot.place_mm.allFinite() &&
                                      robot.place_cov_mm2.allFinite() &&
                                      are_finite(robot.t_s, robot.t_sigma_s, robot.orientation_rad,
                                                 robot.orientation_sigma_rad, robot.height_mm);
                             }) &&
         std::ranges::all_of(part.balls, [](const BallObservation& ball) {
           return ball.camera_mm.allFinite() && ball.place_mm.allFinite() &&
                  are_finite(ball.t_s, ball.sigma_mm, ball.height_mm);
         });
}

bool is_sound(const TrackedField& part, const FieldFrame&, const FieldFrame&) {
  if (part.robots.size() > kMaxRobots || part.balls.size() > kMaxBalls || !std::isfinite(part.t_s))
    return false;
  if (part.kick) {
    const TrackedKick& kick = *part.kick;
    if (!are_finite(kick.t_s, kick.stop_s) || !kick.place_mm.allFinite() || !kick.velocity_mm_s.allFinite() ||
        !kick.landing_mm.allFinite() || !kick.stop_mm.allFinite() || (kick.robot && !is_id(kick.robot->id)))
      return false;
  }
  return std::ranges::all_of(part.robots,
                             [](const TrackedRobot& robot) {
                               return is_id(robot.name.id) && robot.place_mm.allFinite() &&
                                      robot.velocity_mm_s.allFinite() &&
                                      are_finite(robot.orientation_rad, robot.turn_rad_s,
                                                 robot.place_sigma_mm, robot.visibility);
                             }) &&
         std::ranges::all_of(part.balls, [](const TrackedBall& ball) {
           return ball.place_mm.allFinite() && ball.velocity_mm_s.allFinite() &&
                  std::isfinite(ball.visibility);
         });
}

void make_empty(Frame& frame, PartSet written) {
  make_parts_empty<CameraFloor>(frame, written);
}
void make_empty(FieldFrame& frame, PartSet written) {
  make_parts_empty<FieldFloor>(frame, written);
}

}  // namespace sslv::apart
