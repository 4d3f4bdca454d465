// SPDX-License-Identifier: Apache-2.0
// Segmentation of one image in one thread, compared in the same run with the classic three passes over a
// labelled image and with only reading its bytes. Accepts Google Benchmark's options (--help). Prints the
// ratios at the end, in the format of docs/measured/speed.md.
#include "byte_sum.h"
#include "colors/learn_colors.h"
#include "config/config.h"
#include "lab/bench.h"
#include "support/paths.h"
#include "support/simd_target.h"
#include "three_passes.h"
#include "vision/segment.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <functional>
#include <iostream>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <fmt/format.h>

namespace sslv::bench {
namespace {

constexpr const char* kTwoThreads = ", 2 threads";
constexpr int kDrawn = 4;  // different images of each kind

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
    std::ifstream in(source_path("/config/demo.json"));
    return read_config(Json::parse(in));
  }();
  return config;
}
const std::shared_ptr<const Lut>& demo_lut() {
  static const auto lut = make_lut(demo().cameras[0].colors, "");
  return lut;
}

/// A hall and the source of the colour table.
struct Look {
  const char* hall;
  bool learnt;
};
constexpr Look kLooks[] = {{"plain", false}, {"plain", true}, {"usual", false},
                           {"usual", true},  {"hard", false}, {"hard", true}};

Json options_of(const Look& look) {
  return {{"noise_sigma", 4}, {"hall", {{"kind", look.hall}}}};
}

/// The demo's hue classes, or a table learnt from one image in light 1.
std::shared_ptr<const Lut> lut_of(const Look& look, PixelFormat format, Size size) {
  if (!look.learnt) return demo_lut();
  Json options = options_of(look);
  options.update({{"placement", "scatter"}, {"balls", 4}});
  options["hall"]["lamps"] = {{"flicker_low", 1}, {"flicker_high", 1}};
  const Recording shown = draw_frames(demo(), 0, format, size.width, size.height, 1, options);
  LearntColors learnt =
      learn_colors({shown.views, scene_of(demo(), 0, size.width, size.height), league_patterns()});
  if (!learnt.lut)
    throw std::runtime_error(fmt::format("{} hall: not learnt: {}", look.hall, learnt.problem));
  return learnt.lut;
}

/// Size of the largest cache, as reported by Linux.
std::size_t cache_bytes() {
  std::size_t largest = 32 << 20;
  for (int i = 0; i < 5; ++i) {
    std::ifstream in(fmt::format("/sys/devices/system/cpu/cpu0/cache/index{}/size", i));
    std::size_t kib = 0;
    if (in >> kib) largest = std::max(largest, kib << 10);
  }
  return largest;
}

/// Copies of a few images, used in turn: with `cold`, more than fit into the cache.
class Pictures {
 public:
  Pictures(const Recording& drawn, bool cold, std::shared_ptr<const Lut> lut) : lut_(std::move(lut)) {
    const std::size_t bytes = drawn.buffers.front().size();
    const std::size_t count = cold ? cache_bytes() * 3 / 2 / bytes + 1 : 1;
    for (std::size_t i = 0; i < count; ++i) {
      buffers_.push_back(drawn.buffers[i % drawn.buffers.size()]);
      ImageView view = drawn.views.front();
      view.data = buffers_.back().data();
      images_.emplace_back(view, nullptr, nullptr, nullptr);
    }
  }
  const Image& next() { return images_[++at_ % images_.size()]; }
  std::size_t bytes() const { return buffers_.front().size(); }
  const Lut& lut() const { return *lut_; }

 private:
  std::shared_ptr<const Lut> lut_;
  std::vector<std::vector<std::uint8_t>> buffers_;
  std::vector<Image> images_;
  std::size_t at_ = 0;
};

Recording scene(PixelFormat format, Size size, const Look& look) {
  return draw_frames(demo(), 0, format, size.width, size.height, kDrawn, options_of(look));
}

Recording copy_of(const Recording& from) {
  Recording copy = from;
  for (std::size_t i = 0; i < copy.views.size(); ++i) copy.views[i].data = copy.buffers[i].data();
  return copy;
}

/// Sets every pixel (or pair or quad, depending on the format) to one of the first `colors` colours of
/// interest with probability `share`.
Recording speckled(const Recording& from, double share, unsigned colors = 5) {
  constexpr Rgb kColors[] = {{70, 225, 90}, {240, 120, 40}, {230, 210, 40}, {30, 80, 200}, {235, 90, 170}};
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
        const Rgb c = kColors[random() % colors];
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

/// Instruction sets to measure: the best of this CPU, and AVX2, which most field PCs have.
std::vector<std::int64_t> targets() {
  const std::vector<std::int64_t> all = cpu_targets();
  std::vector<std::int64_t> chosen{all.front()};
  if (all.front() != HWY_AVX2 && std::count(all.begin(), all.end(), HWY_AVX2) > 0) chosen.push_back(HWY_AVX2);
  return chosen;
}

using MakePictures = std::function<Pictures()>;

/// The current benchmark's images: those of all benchmarks would not fit into memory.
Pictures& pictures_of(const std::string& kind, const MakePictures& make) {
  static std::string made_for;
  static std::unique_ptr<Pictures> made;
  if (made_for != kind) {
    made.reset();
    made = std::make_unique<Pictures>(make());
    made_for = kind;
  }
  return *made;
}

void time_segment(benchmark::State& state, std::int64_t target, const Segment::Params& params,
                  Pictures& pictures) {
  const OnlyTarget only(target);
  Segment segment;
  const Mask mask;
  RunList runs;
  RegionList regions;
  // Enough runs to grow the boxes of the background for these images.
  for (int i = 0; i < 40; ++i) segment.process(params, pictures.lut(), mask, pictures.next(), runs, regions);
  for (auto _ : state) segment.process(params, pictures.lut(), mask, pictures.next(), runs, regions);
  state.counters["runs"] = static_cast<double>(runs.runs.size());
  state.counters["regions"] = static_cast<double>(regions.regions.size());
  state.counters["capped"] = runs.flood.blocks > 0 || regions.capped;
}

void time_three_passes(benchmark::State& state, Pictures& pictures) {
  ThreePasses passes(pictures.lut());
  std::size_t regions = passes.process(pictures.next().view()).size();
  for (auto _ : state) regions = passes.process(pictures.next().view()).size();
  state.counters["regions"] = static_cast<double>(regions);
}

void time_byte_sum(benchmark::State& state, Pictures& pictures) {
  for (auto _ : state) benchmark::DoNotOptimize(byte_sum(pictures.next().view().data, pictures.bytes()));
}

/// Registers the benchmarks for one kind of image, named "kind/what".
void add(const std::string& kind, const MakePictures& make, const Segment::Params& params) {
  const auto time = [&](const std::string& what, auto run) {
    benchmark::RegisterBenchmark((kind + "/" + what).c_str(),
                                 [=](benchmark::State& state) {
                                   try {
                                     run(state, pictures_of(kind, make));
                                   } catch (const std::runtime_error& not_learnt) {
                                     state.SkipWithError(not_learnt.what());
                                   }
                                 })
        ->Unit(benchmark::kMicrosecond)
        ->MinTime(0.03)
        ->Repetitions(7)
        ->UseRealTime();
  };
  for (const std::int64_t target : targets()) {
    time("segment " + name_of_target(target),
         [=](benchmark::State& state, Pictures& pictures) { time_segment(state, target, params, pictures); });
  }
  if (params.threads == 1) {
    time("three passes", time_three_passes);
    time("byte sum", time_byte_sum);
  }
}

/// Worst time among many frames, with and without table edits ten times a second: a table made by another
/// thread is swapped in between two frames.
void print_worst_frames() {
  constexpr int kFrames = 1500, kFramesPerEdit = 7;
  std::cout << "\n| picture | table | median us | p99 us | worst us |\n|---|---|---|---|---|\n";
  const auto other = make_lut(demo().cameras[1].colors, "");
  for (const Size size : kSizes) {
    Pictures pictures(scene(PixelFormat::kUyvy, size, kLooks[0]), false, demo_lut());
    for (const bool edited : {false, true}) {
      Segment segment;
      RunList runs;
      RegionList regions;
      std::vector<double> us;
      for (int i = -100; i < kFrames; ++i) {
        const Lut& lut = edited && i / kFramesPerEdit % 2 == 0 ? *other : *demo_lut();
        const Image& image = pictures.next();
        const auto before = std::chrono::steady_clock::now();
        segment.process({}, lut, Mask(), image, runs, regions);
        const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - before;
        if (i >= 0) us.push_back(took.count());
      }
      std::sort(us.begin(), us.end());
      std::cout << fmt::format("| uyvy {} | {} | {:.1f} | {:.1f} | {:.1f} |\n", bench::name_of(size),
                               edited ? "another every 7th frame" : "the same", us[us.size() / 2],
                               us[us.size() * 99 / 100], us.back());
    }
  }
}

/// Reports progress as usual and keeps the minimum time of every benchmark.
class Reporter : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    benchmark::ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Iteration || run.error_occurred) continue;
      const std::string& name = run.run_name.function_name;
      const std::string kind = name.substr(0, name.find('/'));
      if (std::find(kinds_.begin(), kinds_.end(), kind) == kinds_.end()) kinds_.push_back(kind);
      double& least = min_us_.try_emplace(name, run.GetAdjustedRealTime()).first->second;
      least = std::min(least, run.GetAdjustedRealTime());
    }
  }

  /// In the format of docs/measured/speed.md.
  void print_table() const {
    if (kinds_.empty()) return;
    std::cout << "\n| picture | three passes | reading |";
    for (const std::int64_t target : targets())
      std::cout << fmt::format(" {} | x faster | x reading |", name_of_target(target));
    std::cout << "\n|---|---|---|";
    for (std::size_t i = 0; i < targets().size(); ++i) std::cout << "---|---|---|";
    std::cout << '\n';
    for (const std::string& kind : kinds_) {
      // Runs with threads are compared with the three passes in one thread.
      const std::string single = kind.substr(0, kind.find(kTwoThreads));
      const double passes = least(single + "/three passes"), reading = least(single + "/byte sum");
      std::cout << fmt::format("| {} | {:.0f} | {:.0f} |", kind, passes, reading);
      for (const std::int64_t target : targets()) {
        const double us = least(kind + "/segment " + name_of_target(target));
        std::cout << fmt::format(" {:.0f} | {:.1f} | {:.2f} |", us, passes / us, us / reading);
      }
      std::cout << '\n';
    }
  }

 private:
  /// NaN for a benchmark that was filtered out.
  double least(const std::string& name) const {
    const auto found = min_us_.find(name);
    return found == min_us_.end() ? std::numeric_limits<double>::quiet_NaN() : found->second;
  }

  std::vector<std::string> kinds_;  // in order of registration
  std::map<std::string, double> min_us_;
};

}  // namespace
}  // namespace sslv::bench

int main(int argc, char** argv) {
  using namespace sslv;
  using namespace sslv::bench;
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 64;
  Segment::Params two_threads;
  two_threads.threads = 2;
  for (const Look& look : kLooks) {
    for (const PixelFormat format : kFormats) {
      for (const Size size : kSizes) {
        const std::string kind =
            fmt::format("{} hall, {} table, {} {}", look.hall, look.learnt ? "learnt" : "demo's",
                        sslv::name_of(format), bench::name_of(size));
        const auto drawn = [=](bool cold, auto change) {
          return
              [=] { return Pictures(change(scene(format, size, look)), cold, lut_of(look, format, size)); };
        };
        const auto same = [](Recording recording) { return recording; };
        add(kind + " warm", drawn(false, same), {});
        add(kind + " cold", drawn(true, same), {});
        const bool also_hostile = &look == &kLooks[0] || &look == &kLooks[3];
        if (size.width != kSizes[2].width || !also_hostile) continue;
        add(kind + " warm" + kTwoThreads, drawn(false, same), two_threads);
        add(kind + " cold" + kTwoThreads, drawn(true, same), two_threads);
        const auto speckle = [=](double share, unsigned colors = 5) {
          return drawn(false, [=](const Recording& recording) { return speckled(recording, share, colors); });
        };
        add(kind + " 1 % speckle", speckle(0.01), {});
        add(kind + " 5 % green", speckle(0.05, 1), {});
        add(kind + " 50 % green", speckle(0.5, 1), {});
        add(kind + " 50 % speckle", speckle(0.5), {});
        add(kind + " random bytes", drawn(false, random_bytes), {});
      }
    }
  }
  Reporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  reporter.print_table();
  print_worst_frames();
  return 0;
}
