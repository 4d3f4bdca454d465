// SPDX-License-Identifier: Apache-2.0
#pragma once

// Stages of a library for tests, which sandboxed_stages.cpp defines.

#include "pipeline/camera_stage.h"
#include "pipeline/field_stage.h"

#include <cmath>
#include <cstdint>
#include <vector>

namespace sslv::test {

/// A coordinate on the field in mm, unique within 100,000 consecutive frames.
inline double place_in(std::uint32_t frame_number) {
  return frame_number % 100'000;
}

/// Encodes every possible input of a camera stage in one ball.
struct SeeAll {
  struct Params {
    double factor = 2;
    static constexpr auto fields() {
      return std::tuple{number("factor", &Params::factor, 1.0, 4.0, "", "how much")};
    }
  };
  int ran = 0;
  void process(const Params& params, const FrameInfo& info, const Image& image, const Scene& scene,
               const Lut& lut, const Mask& mask, const PatternTable& patterns, BallList& out,
               StageNotes& notes) noexcept {
    const ImageView& view = image.view();
    double sum = 0, low = 0;
    for (int y = 0; y < view.height; ++y) {
      for (int x = 0; x < view.width * bytes_per_pixel(view.format); ++x) {
        sum += view.row(y)[x] * (1 + x % 7);
        if (view.to_low_bits != 0) low += (view.row(y) + view.to_low_bits)[x];
      }
    }
    const bool is_seen = scene.camera.has_value();
    const double lens = is_seen ? scene.camera->project({100, 200, 10})->x() : -1;
    out.balls.clear();
    out.balls.push_back(
        {.x_mm = std::fmod(sum, 1e6),  // limits it to valid coordinates
         .y_mm = params.factor * scene.field.ball_radius,
         .pixel_x = lens,
         .pixel_y = patterns.center_diameter_mm + static_cast<double>(patterns.codes.size()),
         .area_px = info.number,
         .confidence = mask.shows(3, 3) ? 1.0 : 0.5,
         .place_cov = {static_cast<double>(lut.of_yuv(100, 30, 200)), low, static_cast<double>(lut.id() % 2)},
         .radius_mm = info.times.t_capture_s,
         .radius_sigma_mm = static_cast<double>(scene.roster[1].count())});
    if (++ran % 2 == 0)
      notes.say("even");
    else
      notes.warn("odd");
  }
};

/// Reads a stage's usual inputs and does almost nothing.
struct LookAround {
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const FrameInfo& info, const Image& image, const Scene& scene, const Lut& lut,
               const Mask& mask, const RobotList& robots, BallList& out) noexcept {
    const ImageView& view = image.view();
    double sum = lut.of_yuv(1, 2, 3) + (mask.shows(5, 5) ? 1 : 0) + static_cast<double>(robots.robots.size());
    for (int y = 0; y < view.height; y += 64) sum += view.row(y)[y];
    out.balls.assign(3, {.x_mm = sum,
                         .y_mm = scene.field.ball_radius,
                         .pixel_x = 0,
                         .pixel_y = 0,
                         .area_px = info.number,
                         .confidence = 1});
  }
};

/// A part that the library defines.
struct TestTags {
  static constexpr std::string_view kPartName = "test_tags";
  struct Tag {
    int id = 0;
    double x = 0;
    std::vector<std::uint8_t> name;
  };
  std::vector<Tag> tags;
  void clear() { tags.clear(); }
};
struct FindTags {
  struct Params {
    int count = 3;
    static constexpr auto fields() { return std::tuple{number("count", &Params::count, 0, 1000, "", "")}; }
  };
  void process(const Params& params, const FrameInfo& info, TestTags& out) noexcept {
    for (int i = 0; i < params.count; ++i) {
      out.tags.push_back(
          {i, info.number + 0.5, std::vector<std::uint8_t>(static_cast<std::size_t>(i % 5), 7)});
    }
  }
};
struct DoubleTags {
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, Update<TestTags> tags) noexcept {
    for (auto& tag : tags->tags) tag.id *= 2;
  }
};
/// Changes the tags, then writes a NaN.
struct SpoilTags {
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, Update<TestTags> tags) noexcept {
    for (auto& tag : tags->tags) tag.id = 77;
    if (!tags->tags.empty()) tags->tags.back().x = std::nan("");
  }
};
struct CountTags {
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const TestTags& tags, Update<BallList> balls) noexcept {
    for (const auto& tag : tags.tags) {
      balls->balls.push_back({.x_mm = static_cast<double>(tag.id),
                              .y_mm = tag.x,
                              .pixel_x = 0,
                              .pixel_y = 0,
                              .area_px = static_cast<std::uint32_t>(tag.name.size()),
                              .confidence = 0.5});
    }
  }
};

/// How MakeTrouble misbehaves.
enum class Trouble : std::uint8_t {
  kNone,
  kCrash,
  kHang,
  kNan,
  kOverlong,
  kBadId,
  kScribble,
  kSlow,
  kPrints,
  kExit,
  kBadRegions,
  kBadNote
};
struct MakeTrouble {
  struct Params {
    int trouble = 0;
    double sleep_ms = 20;
    static constexpr auto fields() {
      return std::tuple{number("trouble", &Params::trouble, 0, 20, "", "which"),
                        number("sleep_ms", &Params::sleep_ms, 0.0, 1000.0, "ms", "when slow")};
    }
  };
  void process(const Params& params, const FrameInfo& info, RobotList& out, RegionList& regions) noexcept;
  std::uint64_t random = 1;
};
struct CannotStart {
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  CannotStart();
  void process(const Params&, const FrameInfo&) noexcept {}
};
struct HangsAtStart {
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  HangsAtStart();
  void process(const Params&, const FrameInfo&) noexcept {}
};
struct NanDefault {
  struct Params {
    double a = std::nan("");
    static constexpr auto fields() { return std::tuple{number("a", &Params::a, 0.0, 1.0, "", "")}; }
  };
  void process(const Params&, const FrameInfo&) noexcept {}
};
struct Publishes {
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const FrameInfo&, DetectionSink&) noexcept {}
};

/// Uses every possible input of a field stage.
struct FieldAll {
  struct Params {
    double ahead_s = 0.1;
    static constexpr auto fields() {
      return std::tuple{number("ahead_s", &Params::ahead_s, 0.0, 1.0, "s", "how far")};
    }
  };
  void process(const Params& params, const ArrivedSightings& arrived, const FieldSize& field,
               const BallModel& ball, const FieldClock& clock, Observations& out,
               Update<TrackedField> tracked) noexcept {
    out.robots.clear();
    out.balls.clear();
    for (const RobotSighting& robot : arrived.image.robots) {
      out.robots.push_back({.name = {robot.team, robot.id},
                            .camera = arrived.image.camera,
                            .t_s = arrived.image.t_capture_s + params.ahead_s,
                            .t_sigma_s = ball.radius_mm,
                            .place_mm = robot.place_mm * field.field_length,
                            .orientation_rad = robot.orientation_rad,
                            .place_cov_mm2 = robot.place_cov_mm2,
                            .orientation_sigma_rad = clock.now_s(),
                            .height_mm = robot.height_mm});
    }
    ++tracked->number;
    tracked->t_s = clock.now_s();
    tracked->robots.resize(arrived.image.robots.size());
    tracked->kick.reset();
    if (tracked->number % 3 == 0) tracked->kick.emplace().number = static_cast<int>(tracked->number);
  }
};

}  // namespace sslv::test
