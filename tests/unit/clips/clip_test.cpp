// SPDX-License-Identifier: Apache-2.0
#include "base/error.h"
#include "clips/clip_format.h"
#include "clips/clip_reader.h"
#include "clips/clip_writer.h"
#include "image/pixel_format_names.h"
#include "support/clip_images.h"

#include <algorithm>
#include <array>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

namespace sslv {
namespace {

namespace fs = std::filesystem;
using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

const ClipAbout kAbout{
    .site = "Halle 3", .version = "1.2", .why = "kept by hand", .begin_s = 1000, .end_s = 1012};

std::vector<std::byte> bytes_from(const std::string& text) {
  std::vector<std::byte> out(text.size());
  std::ranges::transform(text, out.begin(), [](char c) { return static_cast<std::byte>(c); });
  return out;
}

std::string text_from(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// What was added to a clip, to be compared with what is read.
struct Kept {
  FrameInfo info;
  std::uint32_t setup = 0;
  std::vector<std::uint8_t> pixels;
  PixelFormat format = PixelFormat::kMono8;
  int width = 0, height = 0, tile_px = 0;
  std::string packet, memory;

  explicit Kept(const ClipFrame& frame)
      : info(frame.info),
        setup(frame.setup),
        pixels(pixels_of(frame.image)),
        format(frame.image.format),
        width(frame.image.width),
        height(frame.image.height),
        tile_px(frame.tile_px),
        packet(text_from(frame.packet)),
        memory(text_from(frame.memory)) {}
};

void expect_same(const Kept& a, const Kept& b) {
  EXPECT_EQ(a.info.camera_id, b.info.camera_id);
  EXPECT_EQ(a.info.number, b.info.number);
  EXPECT_EQ(a.info.times.t_capture_s, b.info.times.t_capture_s);
  EXPECT_EQ(a.info.times.t_capture_camera_s, b.info.times.t_capture_camera_s);
  EXPECT_EQ(a.info.times.t_capture_sigma_s, b.info.times.t_capture_sigma_s);
  EXPECT_EQ(a.info.times.is_by_ptp, b.info.times.is_by_ptp);
  EXPECT_THAT((std::array{a.info.whole.width, a.info.whole.height, a.info.whole.x, a.info.whole.y}),
              ElementsAre(b.info.whole.width, b.info.whole.height, b.info.whole.x, b.info.whole.y));
  EXPECT_EQ(a.setup, b.setup);
  EXPECT_EQ(a.format, b.format);
  EXPECT_THAT((std::array{a.width, a.height, a.tile_px}), ElementsAre(b.width, b.height, b.tile_px));
  EXPECT_TRUE(a.pixels == b.pixels);
  EXPECT_EQ(a.packet, b.packet);
  EXPECT_EQ(a.memory, b.memory);
}

/// A folder of its own for each test.
class Clip : public testing::Test {
 protected:
  Clip() {
    std::string name = (fs::temp_directory_path() / "sslv_clip_XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~Clip() override { fs::remove_all(folder_); }

  fs::path path(const std::string& name = "a.clip") const { return folder_ / name; }
  std::string read_file(const std::string& name = "a.clip") const {
    std::ifstream file(path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void write_file(const std::string& name, const std::string& bytes) const {
    std::ofstream(path(name), std::ios::binary) << bytes;
  }
  std::string refusal(const std::string& name) const {
    try {
      const ClipReader reader(path(name));
    } catch (const ClipError& error) {
      EXPECT_THAT(error.what(), StartsWith(path(name).string() + ": "));
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      return std::string(error.what()).substr(path(name).string().size() + 2);
    }
    return "";
  }

  /// Two cameras, a second setup, events, tiles; returns the frames in the order of their capture, and where
  /// blocks begin.
  std::vector<Kept> write_small(bool finishes = true) {
    std::vector<Kept> out;
    ClipWriter writer(path(), kAbout);
    const auto mark = [&] { block_ends_.push_back(writer.bytes()); };
    mark();
    writer.add(
        ClipSetup{.camera_id = 0, .about = {{"settings", {{"gain", 3}}}}, .table = bytes_from("a table")});
    mark();
    writer.add(ClipSetup{.camera_id = 7, .about = {{"patterns", nullptr}}});
    mark();
    for (unsigned i = 0; i < 6; ++i) {
      for (const std::uint32_t camera_id : {0U, 7U}) {
        const bool is_deep = camera_id == 7;
        const OwnedImage image = noise_image(camera_id == 0 ? PixelFormat::kBayerRg8 : PixelFormat::kUyvy, 18,
                                             10, i * 10 + camera_id, is_deep ? 3 : 0, is_deep);
        const auto packet = bytes_from("packet " + std::to_string(i)),
                   memory = bytes_from(std::string(30 * i, 'm'));
        ClipFrame frame;
        frame.info.camera_id = camera_id;
        frame.info.number = 100 + i;
        frame.info.times.t_capture_s = 1000 + i * 0.0125 + camera_id * 0.001;
        if (camera_id == 7) frame.info.times.t_capture_camera_s = i * 0.0125;
        if (i % 2 == 0) frame.info.times.t_capture_sigma_s = 1e-5;
        frame.info.times.is_by_ptp = i == 3;
        if (camera_id == 0) frame.info.whole = {.width = 64, .height = 48, .x = 32, .y = 6};
        frame.setup = camera_id == 0 ? 0 : 1;
        frame.image = image.view;
        if (i != 2) frame.packet = packet;
        if (i % 2 == 1) frame.memory = memory;
        Kept kept(frame);
        // Tiles of 8 px: 3 columns, 2 rows; the last ones are 2 px wide and high.
        static constexpr std::array kMap{std::byte{0b100101}};
        if (i == 4 || i == 5) {
          frame.tile_px = kept.tile_px = 8;
          frame.tiles = kMap;
          kept.pixels = mixed(last_whole_[camera_id], kept, std::to_integer<unsigned>(kMap[0]));
        } else {
          last_whole_[camera_id] = kept.pixels;
        }
        writer.add(frame);
        mark();
        out.push_back(kept);
      }
      if (i == 2) {
        writer.add(ClipEvent{1000.02, "goal", "Yellow, 1:0"});
        mark();
      }
    }
    writer.note_missing(7, 3);
    mark();
    writer.note_missing(7, 2);
    mark();
    if (finishes) {
      writer.finish();
      mark();
    }
    return out;
  }

  /// The whole image with the marked tiles of the other.
  static std::vector<std::uint8_t> mixed(std::vector<std::uint8_t> base, const Kept& top, unsigned map) {
    const int pixel_bytes = bytes_per_pixel(top.format);
    for (std::size_t i = 0; i < base.size(); ++i) {
      const auto in_plane = static_cast<int>(i) % (top.width * top.height * pixel_bytes);
      const int x = in_plane / pixel_bytes % top.width, y = in_plane / pixel_bytes / top.width;
      if ((map >> (y / 8 * 3 + x / 8) & 1) != 0) base[i] = top.pixels[i];
    }
    return base;
  }

  fs::path folder_;
  std::vector<std::uint64_t> block_ends_;
  std::map<std::uint32_t, std::vector<std::uint8_t>> last_whole_;
};

TEST_F(Clip, GivesBackAllThatWasAdded) {
  const std::vector<Kept> kept = write_small();
  ClipReader reader(path());
  EXPECT_FALSE(reader.is_unfinished());
  EXPECT_EQ(reader.problem(), "");
  EXPECT_EQ(reader.about().site, "Halle 3");
  EXPECT_EQ(reader.about().version, "1.2");
  EXPECT_EQ(reader.about().why, "kept by hand");
  EXPECT_EQ(reader.about().begin_s, 1000);
  EXPECT_EQ(reader.about().end_s, 1012);
  ASSERT_EQ(reader.setups().size(), 2U);
  EXPECT_EQ(reader.setups()[0].about, (Json{{"settings", {{"gain", 3}}}}));
  EXPECT_EQ(text_from(reader.setups()[0].table), "a table");
  EXPECT_EQ(reader.setups()[1].camera_id, 7);
  EXPECT_THAT(reader.setups()[1].table, IsEmpty());
  ASSERT_EQ(reader.events().size(), 1U);
  EXPECT_EQ(reader.events()[0].time_s, 1000.02);
  EXPECT_EQ(reader.events()[0].kind, "goal");
  EXPECT_EQ(reader.events()[0].text, "Yellow, 1:0");
  ASSERT_EQ(reader.cameras().size(), 2U);
  EXPECT_EQ(reader.cameras()[0].missing, 0U);
  ASSERT_NE(reader.camera(7), nullptr);
  EXPECT_EQ(reader.camera(7)->missing, 5U);
  EXPECT_THAT(reader.camera(7)->frames, ElementsAre(1, 3, 5, 7, 9, 11));
  EXPECT_EQ(reader.camera(1), nullptr);
  ASSERT_EQ(reader.entries().size(), kept.size());
  // Backwards too: a frame in tiles is read before the whole one it lies on.
  for (std::size_t k = 0; k < 2 * kept.size(); ++k) {
    const std::size_t i = k < kept.size() ? k : 2 * kept.size() - 1 - k;
    SCOPED_TRACE(i);
    EXPECT_EQ(reader.entries()[i].camera_id, kept[i].info.camera_id);
    EXPECT_EQ(reader.entries()[i].number, kept[i].info.number);
    EXPECT_EQ(reader.entries()[i].t_capture_s, kept[i].info.times.t_capture_s);
    EXPECT_EQ(reader.entries()[i].has_memory, !kept[i].memory.empty());
    EXPECT_EQ(reader.entries()[i].is_whole, kept[i].tile_px == 0);
    expect_same(Kept(reader.read(i)), kept[i]);
  }
}

TEST_F(Clip, HoldsEveryPixelFormat) {
  std::vector<Kept> kept;
  {
    ClipWriter writer(path(), kAbout);
    writer.add(ClipSetup{});
    double time_s = 5;
    for (const NamedPixelFormat& named : kPixelFormatNames) {
      for (const int padding : {0, 7}) {
        for (const bool is_deep : {false, true}) {
          // Rows of more than one writev(2).
          const OwnedImage image = noise_image(named.format, 6, 1100, 3, padding, is_deep);
          ClipFrame frame;
          frame.info.times.t_capture_s = time_s += 1;
          frame.image = image.view;
          writer.add(frame);
          kept.emplace_back(frame);
        }
      }
    }
    writer.finish();
  }
  ClipReader reader(path());
  ASSERT_EQ(reader.entries().size(), kept.size());
  for (std::size_t i = 0; i < kept.size(); ++i) {
    SCOPED_TRACE(i);
    expect_same(Kept(reader.read(i)), kept[i]);
    std::vector<std::uint8_t> room;
    const ClipFrame& frame = reader.read(i, [&](std::size_t bytes) {
      room.resize(bytes);
      return room.data();
    });
    EXPECT_EQ(frame.image.data, room.data());
    expect_same(Kept(frame), kept[i]);
  }
}

TEST_F(Clip, AFrameMayHaveNoImage) {
  {
    ClipWriter writer(path(), kAbout);
    writer.add(ClipSetup{});
    const auto packet = bytes_from("sent");
    ClipFrame frame;
    frame.packet = packet;
    writer.add(frame);
    writer.finish();
  }
  ClipReader reader(path());
  const ClipFrame& frame = reader.read(0, [](std::size_t) -> std::uint8_t* { throw std::bad_alloc(); });
  EXPECT_TRUE(frame.image.empty());
  EXPECT_EQ(text_from(frame.packet), "sent");
  EXPECT_FALSE(reader.entries()[0].is_whole);
}

TEST_F(Clip, FramesAreInTheOrderOfTheirCapture) {
  {
    ClipWriter writer(path(), kAbout);
    writer.add(ClipSetup{});
    for (const double time_s : {3.0, 1.0, 2.0}) {
      ClipFrame frame;
      frame.info.camera_id = static_cast<std::uint32_t>(time_s);
      frame.info.times.t_capture_s = time_s;
      writer.add(frame);
    }
    writer.finish();
  }
  const ClipReader reader(path());
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_EQ(reader.entries()[i].t_capture_s, 1.0 + static_cast<double>(i));
}

}  // namespace
}  // namespace sslv
