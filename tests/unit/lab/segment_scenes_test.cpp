// SPDX-License-Identifier: Apache-2.0
// Compares the fused stage with the plain ones on images as cameras send them: drawn ones, and a real
// photograph.
#include "config/backends.h"
#include "lab/bench.h"
#include "support/paths.h"
#include "support/segment_check.h"
#include "support/simd_target.h"
#include "support/test_data.h"

#include <fstream>

#include <gtest/gtest.h>

namespace sslv::segment_scenes_test {
namespace {

Config sample(const char* file) {
  std::ifstream in(source_path(file));
  return read_config(Json::parse(in));
}

void expect_equal_on(const Recording& recording, const Lut& lut, const Mask& mask) {
  PlainSegmentation plain;
  RunList runs;
  RegionList regions;
  for (const std::int64_t target : cpu_targets()) {
    const OnlyTarget only(target);
    Segment segment;
    std::size_t found = 0;
    for (const ImageView& view : recording.views) {
      const Image image(view, nullptr, nullptr, nullptr);
      plain.process({}, lut, mask, image);
      segment.process({}, lut, mask, image, runs, regions);
      ASSERT_EQ(difference(plain, runs, regions), "") << name_of_target(target) << " " << name_of(view.format)
                                                      << " " << view.width << " x " << view.height;
      found += regions.regions.size();
    }
    EXPECT_GT(found, 0u) << name_of(recording.views.front().format);
  }
}

TEST(SegmentScenes, EqualThePlainStagesInEveryFormat) {
  const Config demo = sample("/config/demo.json");
  const auto lut = make_lut(demo.cameras[0].colors, "");
  const Mask masks[] = {Mask(), Mask({{{{{15, 10}, {350, 30}, {380, 200}, {45, 280}}}}, {}})};
  for (const PixelFormat format :
       {PixelFormat::kUyvy, PixelFormat::kYuyv, PixelFormat::kRgb24, PixelFormat::kBgr24,
        PixelFormat::kBayerRg8, PixelFormat::kBayerGr8, PixelFormat::kBayerGb8, PixelFormat::kBayerBg8}) {
    // In Bayer images this small, some frames contain no region at all.
    const Recording recording = draw_frames(demo, 0, format, 390, 290, 6, {{"noise_sigma", 6}});
    for (const Mask& mask : masks) expect_equal_on(recording, *lut, mask);
  }
}

/// Expects equal results on one image, with the colours of these settings.
void expect_equal_on_picture(const std::filesystem::path& picture, const char* settings) {
  const Config config = sample(settings);
  const auto lut = make_lut(config.cameras[0].colors, "");
  const Backend& files = find_backend("files", "");
  const Json options{{"path", picture.string()}, {"frame_rate_hz", 0}, {"loop", false}};
  const auto source = files.open(files.complete(options, ""), {0, Scene{}});
  expect_equal_on(record(*source, 1), *lut, Mask());
}

// JPEG has block artefacts and smeared colours.
TEST(SegmentScenes, EqualThePlainStagesOnAJpeg) {
  expect_equal_on_picture(source_path("/tests/golden/division_b.jpg"), "/tests/golden/division_b.json");
}

TEST(SegmentScenes, EqualThePlainStagesOnARealPhotograph) {
  const auto photo = test_data_folder() / "real/ssl_blue6_win.jpg";
  if (!std::filesystem::exists(photo))
    GTEST_SKIP() << "no " << photo.string() << ": real photos are not part of the project";
  expect_equal_on_picture(photo, "/tests/golden/ssl_blue6.json");
}

}  // namespace
}  // namespace sslv::segment_scenes_test
