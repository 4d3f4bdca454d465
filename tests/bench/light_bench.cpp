// SPDX-License-Identifier: Apache-2.0
// Time to convert a table to another light.
#include "colors/table_in_light.h"
#include "support/drawn_scene.h"

#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

namespace sslv {
namespace {

void table_in(benchmark::State& state, const LightChange& change) {
  DrawnScene drawn;
  for (auto _ : state) {
    benchmark::DoNotOptimize(Lut(table_in_light(drawn.lut(), change)));
  }
}

BENCHMARK_CAPTURE(table_in, dim, LightChange{{0.4, 0.4, 0.4}})->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(table_in, bright, LightChange{{1.5, 1.5, 1.5}})->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(table_in, uneven, LightChange{{0.7, 0.7, 0.7}, 0.7, 1.3})->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sslv

BENCHMARK_MAIN();
