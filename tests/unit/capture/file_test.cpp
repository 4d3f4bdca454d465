// SPDX-License-Identifier: Apache-2.0
#include "capture/files/file.h"

#include "base/error.h"
#include "image/jpeg.h"
#include "support/allocation_count.h"
#include "support/media_writer.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include <gmock/gmock.h>

namespace sslv::file_test {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Each test has its own folder.
class Files : public testing::Test {
 protected:
  Files() {
    std::string name = (fs::temp_directory_path() / "sslv_files_XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~Files() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream(path(name), std::ios::binary) << bytes;
  }
  std::string read(const std::string& name) const {
    std::ifstream file(path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  /// Plays as fast as possible unless `options` has a frame rate.
  std::unique_ptr<Source> open(const std::string& what, Json options = Json::object()) const {
    options["path"] = what;
    if (!options.contains("frame_rate_hz")) options["frame_rate_hz"] = 0;
    return file_backend().open(file_backend().complete(options, ""), {});
  }
  std::string refusal(const std::string& what, const Json& options = Json::object()) const {
    try {
      open(what, options);
    } catch (const CaptureError& error) {
      return error.what();
    }
    return "no error";
  }

  fs::path folder_;
};

/// An image of smooth colours, different for each seed.
RgbPicture picture(int seed, int width = 48, int height = 32) {
  RgbPicture out{width, height};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (const int value : {40 + 3 * x, 250 - 4 * y, 20 + 25 * (seed % 8)}) {
        out.rgb.push_back(static_cast<std::uint8_t>(value));
      }
    }
  }
  return out;
}

RgbPicture copy_of(const Image& image) {
  const ImageView& view = image.view();
  RgbPicture out{view.width, view.height};
  for (int y = 0; y < view.height; ++y) {
    out.rgb.insert(out.rgb.end(), view.row(y), view.row(y) + view.width * bytes_per_pixel(view.format));
  }
  return out;
}

int largest_difference(const RgbPicture& a, const RgbPicture& b) {
  EXPECT_EQ(a.rgb.size(), b.rgb.size());
  int most = 0;
  for (std::size_t i = 0; i < std::min(a.rgb.size(), b.rgb.size()); ++i) {
    most = std::max(most, std::abs(a.rgb[i] - b.rgb[i]));
  }
  return most;
}

struct Taken {
  CaptureStatus status;
  CapturedImage image;
  std::string problem;
};
Taken next(Source& source) {
  Taken out;
  out.status = source.next(out.image, out.problem, std::chrono::milliseconds(0));
  return out;
}

/// The image at the requested position; a video needs several calls to find it.
Taken sought(Source& source) {
  for (;;) {
    Taken taken = next(source);
    if (taken.status != CaptureStatus::kTimeout) return taken;
  }
}

/// All results until the end: the names of images, "!problem" for damaged ones.
std::vector<std::string> all_of(Source& source) {
  std::vector<std::string> out;
  for (;;) {
    const Taken taken = next(source);
    if (taken.status == CaptureStatus::kImage) {
      out.push_back(taken.image.name);
    } else if (taken.status == CaptureStatus::kIncomplete) {
      out.push_back("!" + taken.problem);
    } else {
      EXPECT_EQ(taken.status, CaptureStatus::kEnd) << taken.problem;
      return out;
    }
  }
}

TEST_F(Files, ReadsLosslessPicturesExactly) {
  for (const char* name : {"a.png", "a.bmp", "a.ppm"}) {
    write_media(path(name), {picture(1, 50, 30)});
    const auto source = open(path(name));
    const Taken taken = next(*source);
    ASSERT_EQ(taken.status, CaptureStatus::kImage) << name << ": " << taken.problem;
    EXPECT_EQ(taken.image.image.view().format, PixelFormat::kRgb24);
    EXPECT_EQ(copy_of(taken.image.image), picture(1, 50, 30)) << name;
    EXPECT_EQ(taken.image.name, "a");
    EXPECT_EQ(next(*source).status, CaptureStatus::kEnd);
  }
}

TEST_F(Files, ReadsJpegInFullRange) {
  for (const std::array<std::uint8_t, 3> rgb :
       {std::array<std::uint8_t, 3>{255, 255, 255}, {0, 0, 0}, {250, 120, 0}}) {
    RgbPicture plain{32, 32};
    for (int i = 0; i < 32 * 32; ++i) plain.rgb.insert(plain.rgb.end(), rgb.begin(), rgb.end());
    JpegEncoder encoder;
    const auto jpeg = encoder.encode({plain.rgb.data(), 32, 32, 96, PixelFormat::kRgb24}, 32, 95);
    write("a.JPG", std::string(jpeg.begin(), jpeg.end()));
    const auto source = open(path("a.JPG"));
    const Taken taken = next(*source);
    ASSERT_EQ(taken.status, CaptureStatus::kImage) << taken.problem;
    EXPECT_LE(largest_difference(copy_of(taken.image.image), plain), 3);
  }
}

TEST_F(Files, ReadsAFolderInTheOrderOfNames) {
  for (const char* name : {"b.png", "a10.bmp", "c.ppm", "a02.png"}) write_media(path(name), {picture(0)});
  write("notes.txt", "not a picture");
  EXPECT_THAT(all_of(*open(folder_.string())), ElementsAre("a02", "a10", "b", "c"));
}

TEST_F(Files, BeginsAgainWhenAskedTo) {
  write_media(path("a.png"), {picture(0)});
  write_media(path("b.png"), {picture(1)});
  const auto source = open(folder_.string(), {{"loop", true}});
  for (const char* name : {"a", "b", "a", "b", "a"}) EXPECT_EQ(next(*source).image.name, name);
}

TEST_F(Files, NamesDamagedPicturesAndGoesOn) {
  write_media(path("good.png"), {picture(0)});
  write_media(path("good.bmp"), {picture(0)});
  write_media(path("good.ppm"), {picture(0)});
  const std::string png = read("good.png"), bmp = read("good.bmp"), ppm = read("good.ppm");
  JpegEncoder encoder;
  const RgbPicture source_picture = picture(0, 480, 320);
  const auto jpeg =
      encoder.encode({source_picture.rgb.data(), 480, 320, 480 * 3, PixelFormat::kRgb24}, 480, 95);
  write("cut.bmp", bmp.substr(0, bmp.size() / 2));
  write("cut.jpg", std::string(jpeg.begin(), jpeg.begin() + static_cast<std::ptrdiff_t>(jpeg.size()) / 2));
  write("cut.png", png.substr(0, png.size() / 2));
  write("cut.ppm", ppm.substr(0, ppm.size() / 2));
  write("empty.png", "");
  write("text.png", "this is not a picture at all");
  const std::vector<std::string> given = all_of(*open(folder_.string()));
  EXPECT_THAT(given, ElementsAre(HasSubstr("/cut.bmp: "), HasSubstr("/cut.jpg: "), HasSubstr("/cut.png: "),
                                 HasSubstr("/cut.ppm: "), HasSubstr("/empty.png: "), "good", "good", "good",
                                 HasSubstr("/text.png: ")));
  for (const std::string& one : given) EXPECT_EQ(one.find('\n'), std::string::npos);
}

TEST_F(Files, GivesUpLoopingOverNothingReadable) {
  write("bad.png", "not a picture");
  const auto source = open(folder_.string(), {{"loop", true}});
  EXPECT_EQ(next(*source).status, CaptureStatus::kIncomplete);
  const Taken second = next(*source);
  EXPECT_EQ(second.status, CaptureStatus::kLost);
  EXPECT_THAT(second.problem, HasSubstr("nothing in it can be read"));
}

const Json kRawOptions{{"pixel_format", "uyvy"}, {"width", 8}, {"height", 4}};

TEST_F(Files, ReadsRawFramesAsTheyAre) {
  std::string bytes;
  for (int i = 0; i < 64; ++i) bytes.push_back(static_cast<char>(i * 5));
  write("frame.raw", bytes);
  const auto source = open(folder_.string(), kRawOptions);
  const Taken taken = next(*source);
  ASSERT_EQ(taken.status, CaptureStatus::kImage) << taken.problem;
  const ImageView& view = taken.image.image.view();
  EXPECT_EQ(view.format, PixelFormat::kUyvy);
  EXPECT_THAT((std::array{view.width, view.height}), ElementsAre(8, 4));
  EXPECT_EQ(std::string(view.data, view.data + 64), bytes);
}

TEST_F(Files, LowBitsMayFollowARawFrame) {
  std::string bytes;
  for (int i = 0; i < 64; ++i) bytes.push_back(static_cast<char>(i * 5));
  write("a.raw", bytes.substr(0, 32));
  write("b.raw", bytes);
  const Json options{{"pixel_format", "bayer_rg8"}, {"width", 8}, {"height", 4}};
  const auto source = open(folder_.string(), options);
  EXPECT_EQ(next(*source).image.image.view().to_low_bits, 0);
  const Taken taken = next(*source);
  ASSERT_EQ(taken.status, CaptureStatus::kImage) << taken.problem;
  const ImageView& view = taken.image.image.view();
  EXPECT_EQ(view.to_low_bits, 32);
  EXPECT_EQ(std::string(view.data, view.data + 64), bytes);
}

TEST_F(Files, NamesARawFrameOfTheWrongSize) {
  write("frame.raw", std::string(63, 'x'));
  EXPECT_THAT(all_of(*open(folder_.string(), kRawOptions)),
              ElementsAre("!" + path("frame.raw") + ": 63 bytes; expected 64 (8x4 uyvy)"));
}

TEST_F(Files, RawFramesNeedTheirSize) {
  write("frame.raw", std::string(64, 'x'));
  EXPECT_THAT(refusal(folder_.string()),
              HasSubstr("raw frames need pixel_format (not auto), width and height"));
  EXPECT_THAT(refusal(folder_.string(), {{"pixel_format", "bayer_rg8"}, {"width", 9}, {"height", 4}}),
              HasSubstr("they are bayer_rg8, 9 and 4"));
}

// In the formats of `clip export` and `simulate --raw`.
TEST_F(Files, AnIndexFileDescribesRawFrames) {
  write("frame.raw", std::string(64, 'x'));
  for (
      const std::string told :
      {R"({"camera": 0, "frames": [{"file": "frame.raw", "width": 8, "height": 4, "pixel_format": "uyvy"}]})",
       R"({"pixel_format": "uyvy", "width": 8, "height": 4, "frames": [{"file": "frame.raw", "t": 1}]})"}) {
    write("frames.json", told);
    for (const std::string& input : {folder_.string(), path("frame.raw")}) {
      const auto source = open(input);
      const Taken taken = next(*source);
      ASSERT_EQ(taken.status, CaptureStatus::kImage) << taken.problem;
      EXPECT_EQ(taken.image.image.view().format, PixelFormat::kUyvy);
      EXPECT_EQ(taken.image.image.view().width, 8);
    }
  }
  // Settings take precedence.
  const auto source = open(folder_.string(), {{"pixel_format", "mono8"}, {"width", 16}, {"height", 4}});
  EXPECT_EQ(next(*source).image.image.view().width, 16);
}

TEST_F(Files, AnIndexFileThatDescribesNothingIsRefused) {
  write("frame.raw", std::string(64, 'x'));
  for (const std::string told :
       {"", "no JSON", "[]", "7", "null", R"({"frames": []})", R"({"frames": {"0": 1}})",
        R"({"frames": [7]})", R"({"pixel_format": "uyvy", "width": 8})",
        R"({"pixel_format": 8, "width": 8, "height": 4})",
        R"({"pixel_format": "of course", "width": 8, "height": 4})",
        R"({"pixel_format": "uyvy", "width": 1e300, "height": 4})",
        R"({"pixel_format": "uyvy", "width": 99999999999999999999, "height": 4})",
        R"({"pixel_format": "uyvy", "width": -8, "height": 4})",
        R"({"pixel_format": "uyvy", "width": 8.5, "height": 4})",
        R"({"pixel_format": "uyvy", "width": "8", "height": 4})",
        R"({"frames": [{"pixel_format": "uyvy", "width": 8, "height": 4}, {}]})"}) {
    write("frames.json", told);
    EXPECT_THAT(refusal(folder_.string()),
                HasSubstr(path("frames.json") + ": pixel_format, width or height is missing or not allowed"))
        << told;
  }
  write("frames.json", R"({"frames": [{"pixel_format": "uyvy", "width": 8, "height": 4},
                                      {"pixel_format": "yuyv", "width": 8, "height": 4}]})");
  EXPECT_THAT(refusal(folder_.string()),
              HasSubstr(path("frames.json") + ": its frames have different formats or sizes"));
  std::string lists = "[[]";
  while (lists.size() < 5'000'000) lists += ",[]";
  write("frames.json", lists + "]");
  EXPECT_EQ(refusal(folder_.string()), path("frames.json") +
                                           ": JSON that takes more than 48 MiB of memory; set pixel_format, "
                                           "width and height for the camera");
  // A folder of that name is not used either.
  std::filesystem::remove(path("frames.json"));
  std::filesystem::create_directory(path("frames.json"));
  EXPECT_THAT(refusal(folder_.string()), HasSubstr("no frames.json states them"));
}

TEST_F(Files, RawFramesAllocateNothingOnceWarm) {
  write("a.raw", std::string(64, 'x'));
  write("b.raw", std::string(64, 'y'));
  Json options = kRawOptions;
  options["loop"] = true;
  const auto source = open(folder_.string(), options);
  CapturedImage image;
  std::string problem;
  for (int i = 0; i < 4; ++i) source->next(image, problem, std::chrono::milliseconds(0));
  if (!counts_allocations()) GTEST_SKIP() << "the sanitizer has its own allocator";
  const std::uint64_t before = allocation_count();
  for (int i = 0; i < 100; ++i) source->next(image, problem, std::chrono::milliseconds(0));
  EXPECT_EQ(allocation_count(), before);
}

TEST_F(Files, PicturesOutliveTheSource) {
  write_media(path("a.png"), {picture(3)});
  Taken taken;
  {
    const auto source = open(path("a.png"));
    taken = next(*source);
  }
  EXPECT_EQ(copy_of(taken.image.image), picture(3));
}

TEST_F(Files, AHeldPictureIsNotOverwritten) {
  write_media(path("a.png"), {picture(0)});
  write_media(path("b.png"), {picture(1, 96, 64)});
  const auto source = open(folder_.string(), {{"loop", true}});
  const Taken held = next(*source);
  for (int i = 0; i < 50; ++i) next(*source);
  EXPECT_EQ(copy_of(held.image.image), picture(0));
}

TEST_F(Files, ReadsAVideoFrameByFrame) {
  write_media(path("game.mkv"), {picture(0), picture(1), picture(2)});
  const auto source = open(path("game.mkv"));
  for (const int i : {0, 1, 2}) {
    const Taken taken = next(*source);
    ASSERT_EQ(taken.status, CaptureStatus::kImage) << taken.problem;
    EXPECT_EQ(copy_of(taken.image.image), picture(i));
    EXPECT_EQ(taken.image.name, "game00000" + std::to_string(i));
  }
  EXPECT_EQ(next(*source).status, CaptureStatus::kEnd);
  EXPECT_EQ(next(*source).status, CaptureStatus::kEnd);
}

TEST_F(Files, ALimitedRangeVideoComesOutInFullRange) {
  RgbPicture white{64, 64, std::vector<std::uint8_t>(64 * 64 * 3, 255)};
  RgbPicture black{64, 64, std::vector<std::uint8_t>(64 * 64 * 3, 0)};
  write_media(path("a.mp4"), {white, black});
  const auto source = open(path("a.mp4"));
  EXPECT_LE(largest_difference(copy_of(next(*source).image.image), white), 3);
  EXPECT_LE(largest_difference(copy_of(next(*source).image.image), black), 6);
}

TEST_F(Files, AVideoBeginsAgainWhenAskedTo) {
  write_media(path("a.mkv"), {picture(0), picture(1)});
  const auto source = open(path("a.mkv"), {{"loop", true}});
  for (const char* name : {"a000000", "a000001", "a000000", "a000001"})
    EXPECT_EQ(next(*source).image.name, name);
}

TEST_F(Files, AnyPictureOfAVideoCanBeShown) {
  for (const char* name : {"a.mkv", "a.mp4"}) {
    std::vector<RgbPicture> pictures;
    for (int i = 0; i < 40; ++i)
      pictures.push_back(
          {64, 64, std::vector<std::uint8_t>(64 * 64 * 3, static_cast<std::uint8_t>(10 + 5 * i))});
    write_media(path(name), pictures);
    const auto source = open(path(name));
    const auto controls = source->controls();
    for (const int i : {17, 3, 39, 0, 16, 17}) {
      controls->set("position", i);
      const Taken taken = sought(*source);
      ASSERT_EQ(taken.status, CaptureStatus::kImage) << taken.problem;
      EXPECT_LE(largest_difference(copy_of(taken.image.image), pictures[static_cast<std::size_t>(i)]), 3)
          << i;
      ASSERT_TRUE(taken.image.times.t_capture_camera_s);
      EXPECT_NEAR(*taken.image.times.t_capture_camera_s, i / 25.0, 0.01) << name;
    }
    controls->set("paused", true);
    EXPECT_EQ(next(*source).status, CaptureStatus::kTimeout);
    controls->set("step", nullptr);
    EXPECT_EQ(next(*source).image.name, "a000018");
    controls->set("step_back", nullptr);
    EXPECT_EQ(sought(*source).image.name, "a000017");
  }
}

/// A call takes no longer than its timeout, here 0; the next call continues.
TEST_F(Files, SearchingAVideoDoesNotHoldUpTheCamerasThread) {
  for (const char* name : {"a.mkv", "a.mp4"}) {
    write_media(path(name), std::vector<RgbPicture>(60, picture(1)));
    const auto source = open(path(name));
    source->controls()->set("position", 50);
    int turns = 0;
    Taken taken = next(*source);
    for (; taken.status == CaptureStatus::kTimeout; taken = next(*source)) ++turns;
    EXPECT_EQ(taken.image.name, "a000050");
    EXPECT_GE(turns, 60) << "all of the file is read once, one packet a turn";
    EXPECT_EQ(next(*source).image.name, "a000051") << "it plays on";
    // Another position is set during the search.
    const auto again = open(path(name));
    again->controls()->set("position", 50);
    EXPECT_EQ(next(*again).status, CaptureStatus::kTimeout);
    again->controls()->set("position", 7);
    EXPECT_EQ(sought(*again).image.name, "a000007");
    again->controls()->set("position", 40);
    EXPECT_EQ(next(*again).status, CaptureStatus::kTimeout);
    again->controls()->set("position", 0);
    EXPECT_EQ(sought(*again).image.name, "a000000");
    EXPECT_EQ(next(*again).image.name, "a000001");
  }
}

TEST_F(Files, ARecordingOpensAsItsControlsSay) {
  for (const char* name : {"a.png", "b.png", "c.png"}) write_media(path(name), {picture(0)});
  const auto source =
      open(folder_.string(), {{"controls", {{"position", 1}, {"paused", true}, {"zoom", 2}}}});
  ASSERT_EQ(source->warnings().size(), 1U);
  EXPECT_EQ(source->warnings()[0], "zoom: a recording has no such control");
}

TEST_F(Files, ACutVideoEnds) {
  write_media(path("a.mkv"), std::vector<RgbPicture>(20, picture(0)));
  const std::string whole = read("a.mkv");
  write("cut.mkv", whole.substr(0, whole.size() / 2));
  const std::vector<std::string> given = all_of(*open(path("cut.mkv")));
  EXPECT_GE(given.size(), 5U);
  EXPECT_LT(given.size(), 20U);
}

TEST_F(Files, KeepsItsPace) {
  write_media(path("a.png"), {picture(0)});
  write_media(path("b.png"), {picture(0)});
  const auto source = open(folder_.string(), {{"frame_rate_hz", 0.001}});
  EXPECT_EQ(next(*source).status, CaptureStatus::kImage);
  EXPECT_EQ(next(*source).status, CaptureStatus::kTimeout) << "the next one is due in 1000 s";
}

TEST_F(Files, UnreadableFilesAreNamed) {
  EXPECT_EQ(refusal(path("nowhere")), "path \"" + path("nowhere") +
                                          "\": No such file or directory; expected a folder of images, an "
                                          "image, a raw frame, a video or a clip");
  EXPECT_THAT(refusal(""), HasSubstr("path \"\": "));
  EXPECT_THAT(refusal(folder_.string()),
              HasSubstr("no images in this folder; expected files ending in .png"));
  write("noise.avi", std::string(5000, '\x5a'));
  EXPECT_THAT(refusal(path("noise.avi")), HasSubstr("noise.avi\": "));
}

TEST_F(Files, UnknownOptionsAreRefused) {
  EXPECT_THROW(file_backend().complete({{"paht", "x"}}, "/cameras/0/source"), SettingsError);
  EXPECT_THROW(file_backend().complete({{"pixel_format", "rgb"}}, "/cameras/0/source"), SettingsError);
  EXPECT_EQ(
      file_backend().complete(Json::object(), ""),
      Json::parse(
          R"({"path": "", "pixel_format": "auto", "width": 0, "height": 0, "camera_id": null, "frame_rate_hz": null,
                            "loop": false, "controls": {}})"));
}

/// Any damaged file yields only images and problems, and then ends.
TEST_F(Files, NoDamageBringsItDown) {
  write_media(path("good.png"), {picture(0)});
  write_media(path("good.bmp"), {picture(0)});
  write_media(path("good.mkv"), std::vector<RgbPicture>(3, picture(0)));
  JpegEncoder encoder;
  const RgbPicture source_picture = picture(0);
  const auto jpeg = encoder.encode({source_picture.rgb.data(), 48, 32, 48 * 3, PixelFormat::kRgb24}, 48, 80);
  write("good.jpg", std::string(jpeg.begin(), jpeg.end()));
  std::mt19937 random(7);
  for (const std::string ending : {".png", ".bmp", ".jpg", ".mkv"}) {
    const std::string good = read("good" + ending);
    for (int i = 0; i < 60; ++i) {
      std::string bad = good;
      for (int k = 0; k < 4; ++k) bad[random() % bad.size()] = static_cast<char>(random());
      write("bad" + ending, bad);
      try {
        const auto source = open(path("bad" + ending));
        all_of(*source);
      } catch (const CaptureError&) {  // a damaged video may not open
      }
    }
  }
}

}  // namespace
}  // namespace sslv::file_test
