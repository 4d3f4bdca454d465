// SPDX-License-Identifier: Apache-2.0
// What tracks are worth: ours, and those that teams use today, of the same sightings.

#include "incumbent.h"
#include "ours.h"
#include "score.h"

#include <cstdlib>
#include <string>

#include <fmt/format.h>

namespace sslv::worlds {
namespace {

void print(const Score& score) {
  for (const auto& [name, errors] : score.errors)
    fmt::print("{:32} rms {:9.3f} p50 {:9.3f} p99 {:9.3f} n {}\n", name, errors.rms(), errors.quantile(0.5),
               errors.quantile(0.99), errors.count());
  for (const auto& [name, count] : score.counts) fmt::print("{:32} {:9.2f}\n", name, count);
}

}  // namespace
}  // namespace sslv::worlds

int main(int argc, char** argv) {
  using namespace sslv::worlds;
  WorldOptions options;
  int seeds = 3, first = 1;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string name = argv[i];
    const double value = std::atof(argv[i + 1]);
    if (name == "--seeds") seeds = static_cast<int>(value);
    if (name == "--first") first = static_cast<int>(value);
    if (name == "--seconds") options.duration_s = value;
    if (name == "--wobble") options.wobble_mm = value;
    if (name == "--jitter") options.jitter_sigma_s = value * 1e-3;
    if (name == "--latency") options.latency_s = value * 1e-3;
    if (name == "--heights") options.robot_height_spread_mm = value;
    if (name == "--bias") options.robot_bias_mm = options.floor_bias_mm = value;
    if (name == "--second") options.has_second_ball = value > 0;
    if (name == "--chips") options.only_chips = value > 0;
    if (name == "--offsets") options.clock_offset_sigma_s = value * 1e-3;
  }
  Score total, others;
  for (int seed = first; seed <= seeds; ++seed) {
    options.seed = static_cast<std::uint64_t>(seed);
    const World world(options);
    Ours ours(world);
    total.append(score(world, ours));
    Incumbent incumbent;
    others.append(score(world, incumbent));
    if (options.robot_height_spread_mm > 0) {
      for (int i = 0; i < options.robots; ++i) {
        const auto height = ours.tracker().agreement().height_of({World::team_of(i), World::id_of(i)});
        if (height)
          total.errors["height"].add(height->more_mm - (world.height_of(i) - World::kRobotHeightMm));
      }
    }
  }
  print(others);
  fmt::print("\n");
  print(total);
  return 0;
}
