// SPDX-License-Identifier: Apache-2.0
// Segmentation of one picture in one thread, against the classic three passes over a labelled picture and
// against the mere reading of its bytes, all in one run. Google Benchmark's options apply (--help); at the
// end the ratios are printed as they stand in docs/benchmarks.md.
#include "byte_sum.h"
#include "config.h"
#include "ctl/bench.h"
#include "three_passes.h"
#include "vision/segment.h"
#include "vision/segment_kernel.h"

#include <algorithm>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <hwy/highway.h>

namespace sslv::bench {
namespace {

constexpr int kDrawn = 4;  // different pictures of each kind

struct Size {
  int width, height;
};
constexpr Size kSizes[] = {{780, 580}, {1280, 1024}, {2448, 2048}};
constexpr PixelFormat kFormats[] = {PixelFormat::kUyvy, PixelFormat::kRgb24, PixelFormat::kBayerRg8};

std::string name_of(Size size) {
  return fmt::format("{}x{}", size.width, size.height);
}

const Config& demo() {
  static const Config config = [] {
    std::ifstream in(SSLV_SOURCE_DIR "/config/demo.json");
    return read_config(Json::parse(in));
  }();
  return config;
}
const std::shared_ptr<const Lut>& demo_lut() {
  static const auto lut = make_lut(demo().cameras[0].colors, "");
  return lut;
}

/// Size of the largest cache, as Linux tells it.
std::size_t cache_bytes() {
  std::size_t largest = 32 << 20;
  for (int i = 0; i < 5; ++i) {
    std::ifstream in(fmt::format("/sys/devices/system/cpu/cpu0/cache/index{}/size", i));
    std::size_t kib = 0;
    if (in >> kib) largest = std::max(largest, kib << 10);
  }
  return largest;
}

/// Pictures to go through in turn: copies of few, for a cold start more than any cache holds.
class Pictures {
 public:
  Pictures(const Recording& drawn, bool cold) : first_(drawn.views.front()) {
    const std::size_t bytes = drawn.buffers.front().size();
    const std::size_t count = cold ? cache_bytes() * 3 / 2 / bytes + 1 : 1;
    for (std::size_t i = 0; i < count; ++i) {
      buffers_.push_back(drawn.buffers[i % drawn.buffers.size()]);
      ImageView view = first_;
      view.data = buffers_.back().data();
      images_.emplace_back(view, nullptr, nullptr, nullptr);
    }
  }
  const Image& next() { return images_[++at_ % images_.size()]; }
  std::size_t bytes() const { return buffers_.front().size(); }

 private:
  ImageView first_;
  std::vector<std::vector<std::uint8_t>> buffers_;
  std::vector<Image> images_;
  std::size_t at_ = 0;
};

Recording scene(PixelFormat format, Size size) {
  return draw_frames(demo(), 0, format, size.width, size.height, kDrawn, {{"noise_sigma", 4}});
}

Recording copy_of(const Recording& from) {
  Recording copy = from;
  for (std::size_t i = 0; i < copy.views.size(); ++i) copy.views[i].data = copy.buffers[i].data();
  return copy;
}

/// Every pixel (or pair or quad of pixels, as the format has it) becomes a colour of interest with the given
/// probability.
Recording speckled(const Recording& from, double share) {
  constexpr Rgb kColors[] = {{240, 120, 40}, {230, 210, 40}, {30, 80, 200}, {235, 90, 170}, {70, 225, 90}};
  Recording copy = copy_of(from);
  std::mt19937 random(1);
  std::bernoulli_distribution hit(share);
  for (std::size_t i = 0; i < copy.views.size(); ++i) {
    const ImageView& view = copy.views[i];
    std::uint8_t* data = copy.buffers[i].data();
    const bool bayer = is_bayer(view.format), yuv = is_yuv422(view.format);
    for (int y = 0; y < view.height; y += bayer ? 2 : 1) {
      for (int x = 0; x < view.width; x += bayer || yuv ? 2 : 1) {
        if (!hit(random)) continue;
        const Rgb c = kColors[random() % 5];
        std::uint8_t* at = data + y * view.stride_bytes + x * bytes_per_pixel(view.format);
        if (yuv) {
          const Yuv k = to_yuv(c);
          at[0] = k.u, at[1] = k.y, at[2] = k.v, at[3] = k.y;
        } else if (bayer) {
          at[0] = c.r, at[1] = at[view.stride_bytes] = c.g, at[view.stride_bytes + 1] = c.b;
        } else {
          at[0] = c.r, at[1] = c.g, at[2] = c.b;
        }
      }
    }
  }
  return copy;
}

Recording random_bytes(const Recording& from) {
  Recording copy = copy_of(from);
  std::mt19937 random(1);
  for (auto& buffer : copy.buffers) {
    for (auto& byte : buffer) byte = static_cast<std::uint8_t>(random() >> 8);
  }
  return copy;
}

/// Instruction sets to measure: the best of this CPU and, as most field PCs have that, AVX2.
std::vector<std::int64_t> targets() {
  std::vector<std::int64_t> chosen;
  const std::int64_t all = hwy::SupportedTargets();
  chosen.push_back(all & -all);  // a lower bit is a better target
  if ((all & HWY_AVX2) != 0 && chosen.front() != HWY_AVX2) chosen.push_back(HWY_AVX2);
  return chosen;
}
void use_target(std::int64_t target) {
  hwy::SetSupportedTargetsForTest(target);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

void time_segment(benchmark::State& state, std::int64_t target, const Segment::Params& params,
                  Pictures& pictures) {
  use_target(target);
  Segment segment;
  const Mask mask;
  RunList runs;
  RegionList regions;
  for (int i = 0; i < 3; ++i) segment.process(params, *demo_lut(), mask, pictures.next(), runs, regions);
  for (auto _ : state) segment.process(params, *demo_lut(), mask, pictures.next(), runs, regions);
  state.counters["runs"] = static_cast<double>(runs.runs.size());
  state.counters["regions"] = static_cast<double>(regions.regions.size());
  state.counters["capped"] = runs.capped || regions.capped;
  use_target(0);
}

void time_three_passes(benchmark::State& state, Pictures& pictures) {
  ThreePasses passes(*demo_lut());
  std::size_t regions = passes.process(pictures.next().view()).size();
  for (auto _ : state) regions = passes.process(pictures.next().view()).size();
  state.counters["regions"] = static_cast<double>(regions);
}

void time_byte_sum(benchmark::State& state, Pictures& pictures) {
  for (auto _ : state) benchmark::DoNotOptimize(byte_sum(pictures.next().view().data, pictures.bytes()));
}

/// Registers what is measured for one kind of picture, under names "kind/what".
void add(const std::string& kind, const Recording& drawn, bool cold, const Segment::Params& params) {
  const auto pictures = std::make_shared<Pictures>(drawn, cold);
  const auto configure = [](benchmark::internal::Benchmark* one) {
    one->Unit(benchmark::kMicrosecond)
        ->MinTime(0.03)
        ->Repetitions(7)
        ->ReportAggregatesOnly(false)
        ->UseRealTime();
  };
  for (const std::int64_t target : targets()) {
    configure(benchmark::RegisterBenchmark(
        fmt::format("{}/segment {}", kind, hwy::TargetName(target)).c_str(),
        [=](benchmark::State& state) { time_segment(state, target, params, *pictures); }));
  }
  configure(benchmark::RegisterBenchmark((kind + "/three passes").c_str(), [=](benchmark::State& state) {
    time_three_passes(state, *pictures);
  }));
  configure(benchmark::RegisterBenchmark((kind + "/byte sum").c_str(),
                                         [=](benchmark::State& state) { time_byte_sum(state, *pictures); }));
}

/// Shows progress as usual and keeps the least time of every benchmark.
class Reporter : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Iteration) continue;
      const std::string name = run.run_name.function_name;
      const double us = run.GetAdjustedRealTime();
      const auto [at, is_new] = least_us_.try_emplace(name, us);
      if (is_new) {
        order_.push_back(name);
      } else {
        at->second = std::min(at->second, us);
      }
    }
  }

  void print_table() const {
    std::cout << "\n| picture | what | us | x faster than three passes | x reading the bytes "
                 "|\n|---|---|---|---|---|\n";
    for (const std::string& name : order_) {
      const std::size_t slash = name.find('/');
      const std::string kind = name.substr(0, slash), what = name.substr(slash + 1);
      const auto passes = least_us_.find(kind + "/three passes"), sum = least_us_.find(kind + "/byte sum");
      const double us = least_us_.at(name);
      const auto ratio = [&](auto found, bool inverse) {
        if (found == least_us_.end()) return std::string("-");
        return fmt::format("{:.2f}", inverse ? us / found->second : found->second / us);
      };
      std::cout << fmt::format("| {} | {} | {:.1f} | {} | {} |\n", kind, what, us, ratio(passes, false),
                               ratio(sum, true));
    }
  }

 private:
  std::vector<std::string> order_;
  std::map<std::string, double> least_us_;
};

}  // namespace
}  // namespace sslv::bench

int main(int argc, char** argv) {
  using namespace sslv;
  using namespace sslv::bench;
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 64;
  Segment::Params unlimited;
  unlimited.runs.max_runs = 4'000'000;
  unlimited.regions.max_regions = 1'000'000;
  for (const PixelFormat format : kFormats) {
    for (const Size size : kSizes) {
      const Recording drawn = scene(format, size);
      const std::string kind = fmt::format("{} {}", sslv::name_of(format), bench::name_of(size));
      add(kind + " warm", drawn, false, {});
      add(kind + " cold", drawn, true, {});
      if (size.width != 2448) continue;
      add(kind + " 1 % speckle", speckled(drawn, 0.01), false, {});
      add(kind + " 50 % speckle", speckled(drawn, 0.5), false, unlimited);
      add(kind + " 50 % speckle, capped", speckled(drawn, 0.5), false, {});
      add(kind + " random bytes", random_bytes(drawn), false, unlimited);
      add(kind + " random bytes, capped", random_bytes(drawn), false, {});
    }
  }
  Reporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  reporter.print_table();
  return 0;
}
