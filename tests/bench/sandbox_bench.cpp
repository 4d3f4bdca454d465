// SPDX-License-Identifier: Apache-2.0
// The cost of a stage in a process of its own: the same small stage built in, in a library inside the
// service, and in a process of its own, alternating over the same images.
//
//   sandbox_bench [FRAMES [PAUSE_US]]
#include "base/clock.h"
#include "capture/buffer_pool.h"
#include "image/shared_memory.h"
#include "kit/load_stages.h"
#include "kit/sandbox/sandbox.h"
#include "kit/sandbox/stage_process.h"
#include "pipeline/pipeline.h"
#include "pipeline/publish.h"
#include "unit/kit/sandboxed_stages.h"
#include "vision/detect_balls.h"
#include "vision/detect_robots.h"
#include "vision/find_runs.h"
#include "vision/segment.h"
#include "vision/threshold.h"

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <time.h>

namespace sslv {
namespace {

struct NoSink : DetectionSink {
  void publish(const FrameInfo&, const Scene&, const RobotList&, const BallList&) noexcept override {}
};

struct Variant {
  std::string name;
  const StageType* type;
  bool is_shared;
  std::unique_ptr<Step<CameraFloor>> step;
  StageParams params;
  std::vector<double> took_us;
  std::size_t without = 0;
};

double at(std::vector<double>& sorted, double share) {
  return sorted[std::min(sorted.size() - 1,
                         static_cast<std::size_t>(share * static_cast<double>(sorted.size())))];
}

int run(int frames, long pause_us) {
  constexpr int kWidth = 1280, kHeight = 1024;
  sandbox::Supervisor supervisor;
  const StageRows apart_rows = sandboxed_rows(SSLV_SANDBOXED_STAGES, supervisor);
  const StageRows library_rows = load_rows(SSLV_SANDBOXED_STAGES);
  const auto find = [](const StageRows& rows) {
    return &*std::ranges::find_if(rows.camera, [](const auto& row) { return row.name == "look_around"; });
  };
  const StageType own = stage<test::LookAround>("look_around", "");

  std::vector<Variant> variants;
  variants.push_back({"the service's own", &own, true, {}, {}, {}});
  variants.push_back({"of a library, in the service", find(library_rows), true, {}, {}, {}});
  variants.push_back({"in a process of its own", find(apart_rows), true, {}, {}, {}});
  variants.push_back({"likewise, image of a driver (copied)", find(apart_rows), false, {}, {}, {}});
  for (Variant& one : variants) {
    one.step = one.type->create();
    one.params = one.type->parse(Json::object(), "").params;
  }
  share_new_images(true);
  BufferPool shared(4, std::size_t{kWidth} * kHeight);
  share_new_images(false);
  BufferPool plain(4, std::size_t{kWidth} * kHeight);
  const ImageView layout{nullptr, kWidth, kHeight, kWidth, PixelFormat::kBayerRg8};

  CameraContext context{std::make_shared<Scene>(), std::make_shared<Lut>(), std::make_shared<Mask>(),
                        std::make_shared<PatternTable>(league_patterns())};
  NoSink sink;
  Frame frame;
  for (int i = -50; i < frames; ++i) {
    for (Variant& one : variants) {
      std::uint8_t* bytes = nullptr;
      frame.image = Image();
      frame.image = (one.is_shared ? shared : plain).take(layout, bytes);
      std::fill_n(bytes, std::size_t{kWidth} * kHeight, static_cast<std::uint8_t>(i));
      frame.info.number = static_cast<std::uint32_t>(i + 50);
      frame.robots.robots.assign(12, Robot{});
      frame.balls.balls.clear();
      if (pause_us > 0) {
        const timespec pause{0, pause_us * 1000};
        ::nanosleep(&pause, nullptr);
      }
      const std::int64_t before = steady_ns();
      one.step->run({frame, context, sink}, one.params.get());
      const std::int64_t after = steady_ns();
      if (i < 0) continue;
      one.took_us.push_back(static_cast<double>(after - before) * 1e-3);
      one.without += frame.balls.balls.empty();
    }
  }
  fmt::print("{}x{} Bayer, {} frames, {} us between\n", kWidth, kHeight, frames, pause_us);
  fmt::print("{:40} {:>10} {:>10} {:>10} {:>8}\n", "stage", "median us", "p99 us", "most us", "without");
  for (Variant& one : variants) {
    std::sort(one.took_us.begin(), one.took_us.end());
    fmt::print("{:40} {:10.1f} {:10.1f} {:10.1f} {:8}\n", one.name, at(one.took_us, 0.5),
               at(one.took_us, 0.99), one.took_us.back(), one.without);
  }
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace sslv

int main(int argc, char** argv) {
  if (const auto code = sslv::stage_process_main(argc, argv)) return *code;
  const auto number = [&](int i, long otherwise) { return i < argc ? std::atol(argv[i]) : otherwise; };
  return sslv::run(static_cast<int>(number(1, 2000)), number(2, 5000));
}
