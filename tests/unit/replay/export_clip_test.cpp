// SPDX-License-Identifier: Apache-2.0
#include "replay/export_clip.h"

#include "base/error.h"
#include "image/pixel_at.h"
#include "lab/score.h"
#include "lab/truth.h"
#include "replay/png_file.h"
#include "support/live_run.h"
#include "support/temporary_folder.h"

#include <fstream>
#include <iterator>

#include <gmock/gmock.h>
#include <zlib.h>

namespace sslv::export_clip_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

std::vector<std::uint8_t> bytes_in(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::uint32_t number_at(const std::vector<std::uint8_t>& bytes, std::size_t at) {
  return static_cast<std::uint32_t>(bytes[at] << 24 | bytes[at + 1] << 16 | bytes[at + 2] << 8 |
                                    bytes[at + 3]);
}

struct ReadPng {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
  Rgb at(std::uint32_t x, std::uint32_t y) const {
    const std::uint8_t* pixel = rgb.data() + 3 * (y * std::size_t{width} + x);
    return {pixel[0], pixel[1], pixel[2]};
  }
};

/// Reads what png_file() writes, by the PNG specification, and checks every checksum.
ReadPng read_png(const std::vector<std::uint8_t>& file) {
  ReadPng out;
  std::vector<std::uint8_t> packed;
  for (std::size_t at = 8; at + 12 <= file.size();) {
    const std::size_t bytes = number_at(file, at);
    const std::string type(file.begin() + static_cast<std::ptrdiff_t>(at) + 4,
                           file.begin() + static_cast<std::ptrdiff_t>(at) + 8);
    EXPECT_EQ(crc32(0, file.data() + at + 4, static_cast<uInt>(bytes + 4)), number_at(file, at + 8 + bytes));
    if (type == "IHDR") {
      out.width = number_at(file, at + 8);
      out.height = number_at(file, at + 12);
      EXPECT_EQ(file[at + 16], 8);
      EXPECT_EQ(file[at + 17], 2);
    } else if (type == "IDAT") {
      packed.assign(file.begin() + static_cast<std::ptrdiff_t>(at) + 8,
                    file.begin() + static_cast<std::ptrdiff_t>(at + 8 + bytes));
    }
    at += 12 + bytes;
  }
  const std::size_t row_bytes = 1 + 3 * std::size_t{out.width};
  std::vector<std::uint8_t> rows(row_bytes * out.height);
  uLongf got = rows.size();
  EXPECT_EQ(uncompress(rows.data(), &got, packed.data(), packed.size()), Z_OK);
  EXPECT_EQ(got, rows.size());
  for (std::size_t y = 0; y < out.height; ++y) {
    std::array<std::uint8_t, 3> before{};
    EXPECT_EQ(rows[y * row_bytes], 1);
    for (std::size_t i = 0; i < 3 * std::size_t{out.width}; ++i) {
      before[i % 3] = static_cast<std::uint8_t>(before[i % 3] + rows[y * row_bytes + 1 + i]);
      out.rgb.push_back(before[i % 3]);
    }
  }
  return out;
}

TEST(PngFile, KeepsEveryPixel) {
  for (const PixelFormat format : {PixelFormat::kRgb24, PixelFormat::kUyvy, PixelFormat::kBayerGb8}) {
    constexpr int kWidth = 34, kHeight = 20;
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(kWidth * kHeight * bytes_per_pixel(format)));
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * i * 7 + i / 5);
    const ImageView view{bytes.data(), kWidth, kHeight, kWidth * bytes_per_pixel(format), format};
    const ReadPng png = read_png(png_file(view));
    ASSERT_EQ(png.width, 34u);
    ASSERT_EQ(png.height, 20u);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x)
        ASSERT_EQ(png.at(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)), rgb_at(view, x, y));
    }
  }
}

class ExportClip : public testing::Test {
 protected:
  /// A short clip whose first frame has number 6.
  std::filesystem::path clip(const Json& settings, double seconds = 0.1) {
    LiveRun live(settings);
    live.run(0.1);
    live.begin_clip(folder_.file("clip"));
    live.run(seconds);
    live.end_clip();
    return folder_.file("clip");
  }
  const test::TemporaryFolder folder_;
};

TEST_F(ExportClip, WritesFramesAndWhatWasFound) {
  ClipReader reader(clip(live_settings()));
  ExportOptions options;
  options.folder = folder_.file("out");
  options.with_coco = true;
  const auto exported = export_clip(reader, options);
  ASSERT_EQ(exported.size(), 2u);
  EXPECT_EQ(exported[0].frames, 6u);
  EXPECT_GT(exported[0].robots, 10u);
  EXPECT_THAT(exported[0].doubts, testing::IsEmpty());
  const auto folder = options.folder / "camera_0";
  const ReadPng png = read_png(bytes_in(folder / "frame_000006.png"));
  EXPECT_EQ(png.width, 390u);
  EXPECT_EQ(png.height, 290u);

  // The file has the form of annotate's drafts, and scores perfectly against itself.
  const std::vector<Json> truth = read_truth(folder / "truth.jsonl");
  ASSERT_EQ(truth.size(), 6u);
  EXPECT_EQ(truth[0]["frame"], "frame_000006");
  EXPECT_EQ(truth[0]["checked"], false);
  const Score score = score_files(folder / "truth.jsonl", folder / "truth.jsonl", {});
  EXPECT_EQ(score_json(score)["robots"]["recall"], 1.0);

  const Json coco = Json::parse(std::ifstream(folder / "coco.json"));
  EXPECT_EQ(coco["images"].size(), 6u);
  EXPECT_EQ(coco["annotations"].size(), exported[0].robots + exported[0].balls);
  EXPECT_EQ(coco["categories"].size(), 3u);
  std::size_t place = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    for (const char* kind : {"robots", "balls"}) {
      for (const Json& thing : truth[i][kind]) {
        const Json& one = coco["annotations"][place++];
        EXPECT_EQ(one["image_id"], i + 1);
        const auto box = one["bbox"].get<std::array<double, 4>>();
        EXPECT_LE(box[0], thing["pixel_x"].get<double>() + 0.5);
        EXPECT_LE(box[1], thing["pixel_y"].get<double>() + 0.5);
        EXPECT_GE(box[0] + box[2], thing["pixel_x"].get<double>() + 0.5);
        EXPECT_GE(box[1] + box[3], thing["pixel_y"].get<double>() + 0.5);
        // Robots are 180 mm wide and balls 43 mm, at 0.116 px/mm; robots lean away from the image's centre.
        const bool is_ball = std::string(kind) == "balls";
        EXPECT_GT(box[2], is_ball ? 2 : 9);
        EXPECT_LT(box[2], is_ball ? 8 : 34);
      }
    }
  }
}

TEST_F(ExportClip, WritesTheCamerasBytes) {
  ClipReader reader(clip(live_settings("bayer_rg8")));
  ExportOptions options;
  options.folder = folder_.file("out");
  options.format = ExportFormat::kRaw;
  options.camera_id = 1;
  options.span = {0.03, 0.06};
  const auto exported = export_clip(reader, options);
  ASSERT_EQ(exported.size(), 1u);
  EXPECT_EQ(exported[0].frames, 2u);
  EXPECT_EQ(bytes_in(options.folder / "camera_1" / "frame_000008.raw").size(), 390u * 290);
  EXPECT_FALSE(std::filesystem::exists(options.folder / "camera_1" / "coco.json"));
  EXPECT_THAT([&] { export_clip(reader, options); },
              ThrowsMessage<StorageError>(AllOf(HasSubstr("is not empty"), HasSubstr("out"))));
}

TEST_F(ExportClip, ShowsOnlyTheFieldWhenItIsAnonymous) {
  for (const char* format : {"uyvy", "yuyv", "bgr24"}) {
    Json settings = live_settings(format);
    // The field is small: the camera sees its surroundings, too.
    settings["field"] = {{"field_length", 3000}, {"field_width", 2000}, {"boundary_width", 1000}};
    for (Json& camera : settings["cameras"])
      camera["source"].update(Json{{"robots_yellow", 1}, {"robots_blue", 1}, {"distractors", 0}});
    ClipReader reader(clip(settings, 0.03));
    ExportOptions options;
    options.folder = folder_.file(std::string("out ") + format);
    options.is_anonymous = true;
    export_clip(reader, options);
    const ReadPng png = read_png(bytes_in(options.folder / "camera_0" / "frame_000006.png"));
    const CameraModel camera = *make_context(read_config(settings), 0).scene->camera;
    constexpr double kMarginMm = 300, kCellMm = 250;  // whole cells of 16 px are shown
    int black = 0, shown = 0;
    for (std::uint32_t y = 0; y < png.height; y += 3) {
      for (std::uint32_t x = 0; x < png.width; x += 3) {
        const Rgb color = png.at(x, y);
        const bool is_black = color == Rgb{0, 0, 0};
        black += is_black, shown += !is_black;
        const auto on_floor = camera.unproject({x, y}, 0), on_robots = camera.unproject({x, y}, 150);
        ASSERT_TRUE(on_floor && on_robots);
        const auto is_within = [](const Eigen::Vector2d& place, double by_mm) {
          return std::abs(place.x()) < 1500 + by_mm && std::abs(place.y()) < 1000 + by_mm;
        };
        if (!is_within(*on_floor, kMarginMm + kCellMm) && !is_within(*on_robots, kMarginMm + kCellMm)) {
          EXPECT_TRUE(is_black) << x << ", " << y;
        }
        if (is_within(*on_floor, kMarginMm)) {
          EXPECT_FALSE(is_black) << x << ", " << y;
        }
      }
    }
    EXPECT_GT(black, 500) << format;
    EXPECT_GT(shown, 500) << format;
    std::filesystem::remove(folder_.file("clip"));
  }
}

TEST_F(ExportClip, IsNotAnonymousWithoutACalibration) {
  Json settings = live_settings();
  LiveRun live(settings);
  for (Json& camera : settings["cameras"]) camera["calibration"] = nullptr;
  live.change_settings(settings);
  live.begin_clip(folder_.file("clip"));
  live.run(0.03);
  live.end_clip();
  ClipReader reader(folder_.file("clip"));
  ExportOptions options;
  options.folder = folder_.file("out");
  options.is_anonymous = true;
  EXPECT_THAT([&] { export_clip(reader, options); },
              ThrowsMessage<StorageError>(HasSubstr("camera 0 is not calibrated in frame 0")));
  EXPECT_FALSE(std::filesystem::exists(options.folder / "camera_0" / "frame_000000.png"));
  options.folder = folder_.file("seen");
  options.is_anonymous = false;
  EXPECT_EQ(export_clip(reader, options)[0].frames, 2u);
}

}  // namespace
}  // namespace sslv::export_clip_test
