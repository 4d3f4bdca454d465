// SPDX-License-Identifier: Apache-2.0
#include "capture/simulator/simulator.h"

#include "base/clock.h"
#include "base/params_json.h"
#include "capture/buffer_pool.h"
#include "capture/simulator/simulator_camera.h"
#include "capture/simulator/simulator_random.h"
#include "vision/patterns.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <thread>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

using SteadyTime = std::chrono::steady_clock::time_point;

SteadyTime steady_now() {
  return std::chrono::steady_clock::now();
}

SteadyTime later(SteadyTime time, double seconds) {
  return time + std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(seconds));
}

class SimulatorSource final : public Source {
 public:
  SimulatorSource(const SimulatorOptions& options, const SourceContext& context)
      : frame_rate_hz_(options.frame_rate_hz),
        errors_(options.errors),
        random_(scatter(static_cast<std::uint64_t>(options.seed)) + context.camera_id),
        camera_(options, context, league_patterns()),
        buffers_(kBuffers, camera_.picture_bytes()) {}

  CaptureStatus next(CapturedImage& image, std::string& /*problem*/,
                     std::chrono::milliseconds timeout) override {
    const SteadyTime deadline = steady_now() + timeout;
    if (ready_.view().empty()) draw_ahead();
    if (ready_.view().empty() || due_ > deadline) {
      std::this_thread::sleep_until(std::min(due_, deadline));
      return CaptureStatus::kTimeout;
    }
    std::this_thread::sleep_until(due_);
    if (errors_.drop_share > 0 && random_.uniform(0, 1) < errors_.drop_share) {
      ready_ = Image();
      ++dropped_;
      return CaptureStatus::kTimeout;
    }
    image = {std::exchange(ready_, Image()), {stamp_of(t_capture_s_)}, {}};
    return CaptureStatus::kImage;
  }

  std::uint64_t dropped() const noexcept override { return dropped_; }

 private:
  static constexpr std::size_t kBuffers = 12;  // more than viewers hold at the same time
  static constexpr std::int64_t kQueued = 4;   // maximum number of images queued while they are taken late
  static constexpr double kRetryS = 0.001;     // pause between attempts to get a buffer, without a frame rate

  /// The time stamp of an image taken at t_s, with the simulated errors.
  double stamp_of(double t_s) {
    const double jitter_ms = errors_.time_jitter_ms > 0 ? errors_.time_jitter_ms * random_.normal() : 0;
    return t_s + (errors_.time_offset_ms + jitter_ms) * 1e-3;
  }

  /// Draws the image of the next tick if a buffer is free. If images are taken late, draws the image of an
  /// earlier tick, which counts as queued.
  void draw_ahead() {
    const double now_s = unix_time_s();
    if (frame_rate_hz_ > 0) {
      std::int64_t tick = static_cast<std::int64_t>(std::floor(now_s * frame_rate_hz_ - errors_.phase)) + 1;
      if (last_tick_ > 0 && tick > last_tick_ + 1) {
        // Do not count the ticks by which the clock was set forward.
        const double passed_s = std::chrono::duration<double>(steady_now() - due_).count();
        const auto passed = static_cast<std::int64_t>(std::ceil(std::max(0.0, passed_s * frame_rate_hz_)));
        const std::int64_t missed = std::min(tick - last_tick_ - 1, passed);
        const std::int64_t queued = std::min(missed, kQueued);
        dropped_ += static_cast<std::uint64_t>(missed - queued);
        tick -= queued;
      }
      // The Unix clock may be slewed so that the last tick appears to be in the future.
      if (tick == last_tick_) ++tick;
      last_tick_ = tick;
      t_capture_s_ = (static_cast<double>(tick) + errors_.phase) / frame_rate_hz_;
      due_ = later(steady_now(), t_capture_s_ - now_s);
    } else {
      t_capture_s_ = now_s;
      due_ = steady_now();
    }
    std::uint8_t* bytes = nullptr;
    ready_ = buffers_.take(camera_.layout(), bytes);
    if (bytes != nullptr) {
      camera_.draw(t_capture_s_, bytes);
    } else if (frame_rate_hz_ > 0) {
      ++dropped_;
    } else {
      due_ = later(due_, kRetryS);
    }
  }

  double frame_rate_hz_;
  SimulatorErrors errors_;
  SimulatorRandom random_;
  SimulatedCamera camera_;
  BufferPool buffers_;
  std::int64_t last_tick_ = 0;
  std::uint64_t dropped_ = 0;  // images not taken in time
  double t_capture_s_ = 0;     // capture time of ready_
  SteadyTime due_{};           // time at which to deliver ready_
  Image ready_;
};

Json complete(const Json& options, const std::string& path) {
  return params_to_json(simulator_options(options, path));
}

std::unique_ptr<Source> open(const Json& options, const SourceContext& context) {
  return std::make_unique<SimulatorSource>(simulator_options(options, ""), context);
}

std::vector<FoundCamera> list() {
  return {};
}

}  // namespace

SimulatorOptions simulator_options(const Json& json, const std::string& path) {
  auto options = params_from_json<SimulatorOptions>(json, path);
  if (!is_valid_size(options.pixel_format, options.width, options.height)) {
    throw SettingsError(fmt::format("{}: width {} and height {} are not allowed; expected even values for {}",
                                    path, options.width, options.height, name_of(options.pixel_format)));
  }
  if (std::int64_t{options.width} * options.height > SimulatorOptions::kMaxPixels) {
    throw SettingsError(fmt::format("{}: width {} and height {} are not allowed; expected at most {} pixels",
                                    path, options.width, options.height, SimulatorOptions::kMaxPixels));
  }
  if (options.bits > 8 && bytes_per_pixel(options.pixel_format) != 1) {
    throw SettingsError(
        fmt::format("{}/bits: {} is not allowed with {}; expected 8, or a Bayer or mono format", path,
                    options.bits, name_of(options.pixel_format)));
  }
  const auto check_ids = [&](std::string_view count_key, int count, std::string_view first_key, int first) {
    constexpr int kIds = 16;
    if (first + count <= kIds) return;
    throw SettingsError(fmt::format("{}/{}: {} is not allowed with {} {}; expected ids up to {}", path,
                                    count_key, count, first_key, first, kIds - 1));
  };
  const auto check_swing = [&](std::string_view key, const auto& swing, double least, double most) {
    for (std::size_t i = 0; i < swing.size(); ++i) {
      const std::string point = fmt::format("{}/{}/{}", path, key, i);
      if (i == 0 ? swing[0][0] != 0 : swing[i][0] <= swing[i - 1][0])
        refuse(point + "/0", swing[i][0], i == 0 ? "0" : "more than the time before");
      if (swing[i][1] < least || swing[i][1] > most)
        refuse(point + "/1", swing[i][1], fmt::format("a factor {} .. {}", least, most));
    }
    if (swing.size() == 1) refuse(fmt::format("{}/{}", path, key), swing, "no points, or at least two");
  };
  const HallOptions hall = resolved(options.hall);
  if (*hall.lamps.flicker_low > *hall.lamps.flicker_high) {
    refuse(path + "/hall/lamps/flicker_low", *hall.lamps.flicker_low,
           fmt::format("no more than flicker_high, which is {}", *hall.lamps.flicker_high));
  }
  check_swing("light_swing", options.light_swing, 0.05, 4.0);
  check_swing("cast_swing", options.cast_swing, 0.5, 2.0);
  check_ids("robots_yellow", options.robots_yellow, "first_yellow_id", options.first_yellow_id);
  check_ids("robots_blue", options.robots_blue, "first_blue_id", options.first_blue_id);

  const int robots = options.robots_yellow + options.robots_blue;
  const auto check = [&](bool allowed, std::string_view key, int value, const std::string& why) {
    if (!allowed) throw SettingsError(fmt::format("{}/{}: {} is not allowed{}", path, key, value, why));
  };
  const bool scattered = options.placement == SimulatorPlacement::kScatter;
  check(options.touching % 2 == 0, "touching", options.touching, "; expected an even number");
  check(scattered || options.touching == 0, "touching", options.touching,
        " with placement paths; expected 0, or placement scatter");
  check(scattered || options.hidden_balls == 0, "hidden_balls", options.hidden_balls,
        " with placement paths; expected 0, or placement scatter");
  check(options.touching <= robots, "touching", options.touching,
        fmt::format(" with {} robots; expected no more than these", robots));
  check(options.hidden_balls <= options.balls, "hidden_balls", options.hidden_balls,
        fmt::format(" with {} balls; expected no more than these", options.balls));
  check(options.touching + options.hidden_balls <= robots, "hidden_balls", options.hidden_balls,
        fmt::format(" with {} robots, {} of them touching; expected no more than touch none", robots,
                    options.touching));
  check(options.covered_dots <= robots, "covered_dots", options.covered_dots,
        fmt::format(" with {} robots; expected no more than these", robots));
  return options;
}

Backend simulator_backend() {
  return {
      "simulator", "a field with moving robots and balls, drawn as a camera with this calibration sees it",
      &complete,   &params_schema<SimulatorOptions>,
      &open,       &list};
}

}  // namespace sslv
