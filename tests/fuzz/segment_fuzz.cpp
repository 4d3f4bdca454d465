// SPDX-License-Identifier: Apache-2.0
// libFuzzer: for any image, mask and parameters, the fused stage gives the same runs and regions as the plain
// stages, on every instruction set. ./run test-long
#include "support/segment_check.h"
#include "support/simd_target.h"

#include <cstdio>

#include <fuzzer/FuzzedDataProvider.h>

namespace sslv {
namespace {

Mask read_mask(FuzzedDataProvider& data) {
  MaskSettings settings;
  for (auto* polygons : {&settings.include, &settings.exclude}) {
    for (int count = data.ConsumeIntegralInRange(0, 2); count > 0; --count) {
      MaskPolygon& polygon = polygons->emplace_back();
      for (int corners = data.ConsumeIntegralInRange(3, 5); corners > 0; --corners) {
        polygon.points.push_back(
            {data.ConsumeIntegralInRange(-8, 600) * 0.5, data.ConsumeIntegralInRange(-8, 60) * 0.5});
      }
    }
  }
  return Mask(settings);
}

void check(FuzzedDataProvider& data) {
  const auto format =
      static_cast<PixelFormat>(data.ConsumeIntegralInRange(0, static_cast<int>(PixelFormat::kBayerBg8)));
  const int unit = is_bayer(format) || is_yuv422(format) ? 2 : 1;
  const int width = unit * data.ConsumeIntegralInRange(1, 300 / unit);
  const int height = (is_bayer(format) ? 2 : 1) * data.ConsumeIntegralInRange(1, 8);
  const Mask mask = read_mask(data);
  Segment::Params params;
  params.runs.max_runs = data.ConsumeBool() ? 65'536 : data.ConsumeIntegralInRange(1, 200);
  params.regions.max_regions = data.ConsumeBool() ? 20'000 : data.ConsumeIntegralInRange(1, 50);
  params.regions.min_cells = data.ConsumeIntegralInRange(1, 4);
  params.regions.connectivity = data.ConsumeBool() ? Connectivity::kEight : Connectivity::kFour;
  static const auto targets = cpu_targets();
  const OnlyTarget only(targets[data.ConsumeIntegralInRange<std::size_t>(0, targets.size() - 1)]);

  Segment segment;
  PlainSegmentation plain;
  RunList runs;
  RegionList regions;
  for (int frame = 0; frame < 2; ++frame) {
    const Lut& lut = *test_luts()[data.ConsumeIntegralInRange<std::size_t>(0, test_luts().size() - 1)];
    const auto size = static_cast<std::size_t>(width * bytes_per_pixel(format) * height);
    // Pixels beyond the end of the input have one colour, so that short inputs are valid images too.
    std::vector<std::uint8_t> bytes(size, data.ConsumeIntegral<std::uint8_t>());
    data.ConsumeData(bytes.data(), frame == 0 ? size / 2 : size);
    const Image image({bytes.data(), width, height, width * bytes_per_pixel(format), format}, nullptr,
                      nullptr, nullptr);
    plain.process(params, lut, mask, image);
    segment.process(params, lut, mask, image, runs, regions);
    const std::string differs = difference(plain, runs, regions);
    if (differs.empty()) continue;
    const std::string target(search_runs_target()), name(name_of(format));
    std::fprintf(stderr, "%s, %s %d x %d: %s\n", target.c_str(), name.c_str(), width, height,
                 differs.c_str());
    std::abort();
  }
}

}  // namespace
}  // namespace sslv

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  FuzzedDataProvider data(bytes, size);
  sslv::check(data);
  return 0;
}
