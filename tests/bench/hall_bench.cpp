// SPDX-License-Identifier: Apache-2.0
// Segmentation in realistic halls: carpet texture, uneven lamps, each frame lit differently. One thread,
// images not in the cache; `segment`, the three passes and reading the bytes alternate.
#include "byte_sum.h"
#include "hall.h"
#include "support/simd_target.h"
#include "three_passes.h"
#include "vision/segment.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <iostream>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace sslv::bench {
namespace {

constexpr int kDrawn = 8;

/// More images than fit into any cache.
std::vector<std::vector<std::uint8_t>> copies(const Recording& drawn) {
  constexpr std::size_t kBytes = 96 << 20;
  std::vector<std::vector<std::uint8_t>> out;
  while (out.size() < kDrawn || out.size() * drawn.buffers.front().size() < kBytes)
    out.push_back(drawn.buffers[out.size() % drawn.buffers.size()]);
  return out;
}

template <class Work>
double us_of(const Work& work) {
  const auto before = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - before).count();
}

struct Times {
  std::vector<double> us;  // the minimum for each drawn image
  explicit Times() : us(kDrawn, std::numeric_limits<double>::infinity()) {}
  void add(std::size_t picture, double t) { us[picture % kDrawn] = std::min(us[picture % kDrawn], t); }
  double mean() const {
    double sum = 0;
    for (const double t : us) sum += t;
    return sum / static_cast<double>(us.size());
  }
  double worst() const { return *std::max_element(us.begin(), us.end()); }
};

void time_kind(const std::string& name, const Recording& drawn, const Lut& lut, int rounds) {
  const auto buffers = copies(drawn);
  std::vector<Image> images;
  for (const auto& buffer : buffers) {
    ImageView view = drawn.views.front();
    view.data = buffer.data();
    images.emplace_back(view, nullptr, nullptr, nullptr);
  }
  ThreePasses passes(lut);
  const Mask mask;
  RunList runs;
  RegionList regions;
  Times segment_us, passes_us, reading_us;
  Segment segment;
  std::size_t max_runs = 0;
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < images.size(); ++i) {
      segment_us.add(i, us_of([&] { segment.process({}, lut, mask, images[i], runs, regions); }));
      max_runs = std::max(max_runs, runs.runs.size());
    }
    for (std::size_t i = 0; i < images.size(); ++i)
      reading_us.add(i, us_of([&] {
                       volatile std::uint64_t sum = byte_sum(images[i].view().data, buffers[i].size());
                       (void)sum;
                     }));
    if (round % 4 != 0) continue;
    for (std::size_t i = 0; i < images.size(); ++i)
      passes_us.add(i, us_of([&] { passes.process(images[i].view()); }));
  }
  std::cout << fmt::format("| {} | {:.0f} | {:.0f} | {:.0f} | {:.0f} | {:.1f} | {:.2f} | {} |\n", name,
                           passes_us.mean(), reading_us.mean(), segment_us.mean(), segment_us.worst(),
                           passes_us.mean() / segment_us.mean(), segment_us.mean() / reading_us.mean(),
                           max_runs)
            << std::flush;
}

}  // namespace
}  // namespace sslv::bench

int main(int argc, char** argv) {
  using namespace sslv;
  using namespace sslv::bench;
  const std::string only = argc > 1 ? argv[1] : "";
  const int rounds = argc > 2 ? std::atoi(argv[2]) : 12;
  std::cout << "| picture, table | three passes us | reading us | segment us | worst | x faster | x reading "
               "| runs |\n"
               "|---|---|---|---|---|---|---|---|\n";
  for (const auto format : {PixelFormat::kUyvy, PixelFormat::kRgb24, PixelFormat::kBayerRg8}) {
    for (const auto& [width, height] : {std::array{780, 580}, std::array{2448, 2048}}) {
      for (const HallKind& hall : {kUsualHall, kHardHall}) {
        const std::string name = fmt::format("{} {}x{} {}", sslv::name_of(format), width, height, hall.name);
        if (name.find(only) == std::string::npos) continue;
        const Recording drawn = draw_hall(hall, format, width, height, kDrawn);
        time_kind(name + ", margins", drawn, *lut_with_margins(hall), rounds);
        if (const auto lut = learnt_lut(drawn, width, height))
          time_kind(name + ", learnt", drawn, *lut, rounds);
      }
    }
  }
  return 0;
}
