// SPDX-License-Identifier: Apache-2.0
#include "base/error.h"
#include "clips/clip_format.h"
#include "clips/clip_reader.h"
#include "clips/clip_writer.h"
#include "image/pixel_format_names.h"
#include "support/allocation_count.h"
#include "support/clip_images.h"
#include "support/little_memory.h"
#include "support/paths.h"
#include "support/temporary_folder.h"

#include <algorithm>
#include <array>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <new>
#include <span>
#include <string>
#include <vector>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

namespace sslv::clip_test {
namespace {

namespace fs = std::filesystem;
using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

const ClipAbout kAbout{.site = "Halle 3",
                       .version = "1.2",
                       .kind = "kept",
                       .why = "kept by hand",
                       .begin_s = 1000,
                       .end_s = 1012};

std::vector<std::byte> bytes_from(const std::string& text) {
  std::vector<std::byte> out(text.size());
  std::ranges::transform(text, out.begin(), [](char c) { return static_cast<std::byte>(c); });
  return out;
}

std::string text_from(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Copy of a frame, to compare written frames with read ones.
struct Kept {
  FrameInfo info;
  std::uint32_t setup = 0;
  std::vector<std::uint8_t> pixels;
  PixelFormat format = PixelFormat::kMono8;
  int width = 0, height = 0;
  std::string packet, memory;

  explicit Kept(const ClipFrame& frame)
      : info(frame.info),
        setup(frame.setup),
        pixels(pixels_of(frame.image)),
        format(frame.image.format),
        width(frame.image.width),
        height(frame.image.height),
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
  EXPECT_THAT((std::array{a.width, a.height}), ElementsAre(b.width, b.height));
  EXPECT_TRUE(a.pixels == b.pixels);
  EXPECT_EQ(a.packet, b.packet);
  EXPECT_EQ(a.memory, b.memory);
}

/// Each test has its own folder.
class Clip : public testing::Test {
 protected:
  fs::path path(const std::string& name = "a.clip") const { return folder_.path() / name; }
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

  /// Writes two cameras with a setup each, and an event. Returns the frames in order of capture; adds the end
  /// of each block to block_ends_.
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
        writer.add(frame);
        mark();
        out.emplace_back(frame);
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

  test::TemporaryFolder folder_;
  std::vector<std::uint64_t> block_ends_;
};

TEST_F(Clip, ACamerasFramesStayInTheirOrderWhenTheClockIsSetBack) {
  {
    ClipWriter writer(path(), kAbout);
    writer.add(ClipSetup{.camera_id = 0});
    const OwnedImage image = noise_image(PixelFormat::kMono8, 16, 16, 1);
    for (std::uint32_t number = 10; number < 16; ++number) {
      ClipFrame frame;
      frame.info.number = number;
      frame.info.times.t_capture_s = number < 13 ? 1000 + number : 900 + number;
      frame.image = image.view;
      writer.add(frame);
    }
    writer.finish();
  }
  ClipReader clip(path());
  std::vector<std::uint32_t> numbers;
  for (const std::size_t place : clip.cameras().at(0).frames) numbers.push_back(clip.entries()[place].number);
  EXPECT_EQ(numbers, (std::vector<std::uint32_t>{10, 11, 12, 13, 14, 15}));
}

TEST_F(Clip, GivesBackAllThatWasAdded) {
  const std::vector<Kept> kept = write_small();
  ClipReader reader(path());
  EXPECT_FALSE(reader.is_unfinished());
  EXPECT_EQ(reader.problem(), "");
  EXPECT_EQ(reader.about().site, "Halle 3");
  EXPECT_EQ(reader.about().version, "1.2");
  EXPECT_EQ(reader.about().kind, "kept");
  EXPECT_EQ(reader.about().why, "kept by hand");
  EXPECT_EQ(reader.about().begin_s, 1000);
  EXPECT_EQ(reader.about().end_s, 1012);
  ASSERT_EQ(reader.setup_count(), 2U);
  EXPECT_EQ(reader.setup(0).about, (Json{{"settings", {{"gain", 3}}}}));
  EXPECT_EQ(text_from(reader.setup(0).table), "a table");
  EXPECT_EQ(reader.setup(1).camera_id, 7);
  EXPECT_THAT(reader.setup(1).table, IsEmpty());
  EXPECT_TRUE(reader.setup(2).about.is_null());
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
  for (std::size_t i = 0; i < kept.size(); ++i) {
    SCOPED_TRACE(i);
    EXPECT_EQ(reader.entries()[i].camera_id, kept[i].info.camera_id);
    EXPECT_EQ(reader.entries()[i].number, kept[i].info.number);
    EXPECT_EQ(reader.entries()[i].t_capture_s, kept[i].info.times.t_capture_s);
    EXPECT_EQ(reader.entries()[i].has_memory, !kept[i].memory.empty());
    EXPECT_TRUE(reader.entries()[i].is_whole);
    expect_same(Kept(reader.read(i)), kept[i]);
  }
}

/// tests/e2e/clip_reader.test.mjs reads the same file with a reader written from the format's description.
TEST_F(Clip, IsWrittenAsItWasDescribed) {
  write_small();
  std::ifstream file(source_path("/tests/golden/small.clip"), std::ios::binary);
  const std::string golden{std::istreambuf_iterator<char>(file), {}};
  EXPECT_TRUE(read_file() == golden) << "another format is another version, with its description";
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
          // More rows than one writev(2) can write.
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

/// Expects each readable frame to equal a written one. Returns the number of readable frames.
std::size_t expect_no_other(ClipReader& reader, const std::vector<Kept>& kept) {
  std::size_t good = 0;
  for (std::size_t i = 0; i < reader.entries().size(); ++i) {
    try {
      const Kept got(reader.read(i));
      const auto same = std::ranges::find_if(kept, [&](const Kept& one) {
        return one.info.camera_id == got.info.camera_id && one.info.number == got.info.number;
      });
      EXPECT_NE(same, kept.end());
      if (same != kept.end()) expect_same(got, *same);
      ++good;
    } catch (const ClipError& error) {
      EXPECT_THAT(error.what(), HasSubstr("frame "));
    }
  }
  for (std::size_t i = 0; i < reader.setup_count(); ++i)
    EXPECT_THAT(reader.setup(i).about.dump(),
                AnyOf("null", R"({"settings":{"gain":3}})", R"({"patterns":null})"));
  for (const ClipEvent& event : reader.events()) EXPECT_EQ(event.text, "Yellow, 1:0");
  return good;
}

TEST_F(Clip, WithoutAnIndexAllIsThere) {
  const std::vector<Kept> kept = write_small(false);
  ClipReader reader(path());
  EXPECT_TRUE(reader.is_unfinished());
  EXPECT_THAT(reader.problem(), HasSubstr("was not finished"));
  EXPECT_EQ(expect_no_other(reader, kept), kept.size());
  EXPECT_EQ(reader.about().site, "Halle 3");
  EXPECT_EQ(reader.setup_count(), 2U);
  EXPECT_EQ(reader.events().size(), 1U);
  EXPECT_EQ(reader.camera(7)->missing, 5U);
}

TEST_F(Clip, ATruncatedClipHasItsCompleteFrames) {
  const std::vector<Kept> kept = write_small();
  const std::uint64_t size = fs::file_size(path());
  const std::uint64_t index_begin = block_ends_[block_ends_.size() - 2];
  for (std::uint64_t end = size - 1; end >= kClipHeadBytes; --end) {
    ASSERT_EQ(::truncate(path().c_str(), static_cast<off_t>(end)), 0);
    SCOPED_TRACE(end);
    ClipReader reader(path());
    EXPECT_TRUE(reader.is_unfinished());
    const std::size_t good = expect_no_other(reader, kept);
    EXPECT_TRUE(end < index_begin || good == kept.size());
    // A lower bound: a block is readable even without its padding.
    const auto whole = static_cast<std::size_t>(
        std::ranges::count_if(block_ends_, [&](std::uint64_t block_end) { return block_end <= end; }));
    const std::size_t frames = whole <= 3 ? 0 : std::min(kept.size(), whole - 3 - (whole > 9 ? 1 : 0));
    EXPECT_GE(good, frames);
    if (HasFailure()) return;
  }
  for (const std::uint64_t end : {15, 9, 1}) {
    ASSERT_EQ(::truncate(path().c_str(), static_cast<off_t>(end)), 0);
    EXPECT_EQ(refusal("a.clip"), "is not a clip: it ends within its header");
  }
  ASSERT_EQ(::truncate(path().c_str(), 0), 0);
  EXPECT_EQ(refusal("a.clip"), "is not a clip: it is empty");
}

TEST_F(Clip, NoDamageGoesUnnoticed) {
  for (const bool finishes : {true, false}) {
    fs::remove(path());
    const std::vector<Kept> kept = write_small(finishes);
    const std::string whole = read_file();
    const int file = ::open(path().c_str(), O_WRONLY | O_CLOEXEC);
    for (std::size_t i = kClipHeadBytes; i < whole.size(); ++i) {
      SCOPED_TRACE(i);
      const char bad = static_cast<char>(whole[i] ^ (1 << i % 8));
      ASSERT_EQ(::pwrite(file, &bad, 1, static_cast<off_t>(i)), 1);
      ClipReader reader(path());
      const std::size_t good = expect_no_other(reader, kept);
      // With an index, at most one frame is lost.
      EXPECT_TRUE(!finishes || good >= kept.size() - 1) << good;
      if (HasFailure()) return;
      ASSERT_EQ(::pwrite(file, &whole[i], 1, static_cast<off_t>(i)), 1);
    }
    ::close(file);
  }
}

TEST_F(Clip, OtherFilesAreRefused) {
  write_small();
  const std::string whole = read_file();
  write_file("empty.clip", "");
  write_file("text.clip", "this is a text and no clip at all");
  write_file("log.clip", "SSL_LOG_FILE" + std::string(100, '\0'));
  write_file("as_text.clip", "\x89SSL_CLIP\n\x1a" + whole.substr(12));
  std::string other = whole;
  other[12] = 2;
  write_file("new.clip", other);
  ASSERT_EQ(::mkfifo(path("pipe.clip").c_str(), 0600), 0);
  EXPECT_EQ(refusal("empty.clip"), "is not a clip: it is empty");
  EXPECT_EQ(refusal("text.clip"), "is not a clip: it does not start with the clip signature");
  EXPECT_EQ(refusal("log.clip"), "is not a clip: it does not start with the clip signature");
  EXPECT_EQ(refusal("as_text.clip"), "was damaged by a transfer in text mode; transfer it in binary mode");
  EXPECT_EQ(refusal("new.clip"), "has an unknown clip version 2; expected 1");
  EXPECT_EQ(refusal("pipe.clip"), "is not a clip: not a regular file");
  EXPECT_EQ(refusal("."), "is not a clip: not a regular file");
  EXPECT_EQ(refusal("nowhere.clip"), "cannot be read: No such file or directory");
  EXPECT_THROW(ClipReader("/dev/zero"), ClipError);
}

/// A block with correct checksums.
std::string block(std::uint32_t type, std::uint32_t camera_id, const std::string& payload) {
  const auto payload_bytes = bytes_from(payload);
  const auto head = encoded(ClipBlockHead{
      .type = type, .camera_id = camera_id, .bytes = payload.size(), .sum = clip_sum(payload_bytes)});
  return text_from(head) + payload + std::string(clip_padding(payload.size()), '\0');
}
std::string block(ClipBlock type, std::uint32_t camera_id, const std::string& payload) {
  return block(static_cast<std::uint32_t>(type), camera_id, payload);
}
std::string with_index(const std::string& blocks, const std::vector<ClipIndexLine>& lines) {
  std::string payload;
  for (const ClipIndexLine& line : lines) payload += text_from(encoded(line));
  return blocks + block(ClipBlock::kIndex, 0, payload) + text_from(clip_trailer(blocks.size()));
}
/// A frame block, by default of 4 x 2 px, mono8, with `value` at offset `place` of its head.
std::string frame_block(std::uint32_t camera_id, ClipFrameHead head, const std::string& rest,
                        std::size_t place = 68, std::uint32_t value = 0) {
  if (head.width == 0) head.width = 4, head.height = 2;
  if (head.image_bytes == 0) head.image_bytes = 8;
  auto bytes = encoded(head);
  put_u32(bytes, place, value);
  put_u32(bytes, 124, clip_sum(std::span(bytes).first(124)));
  return block(ClipBlock::kFrame, camera_id, text_from(bytes) + rest);
}
std::string setup_block(std::uint32_t number, const std::string& json) {
  std::array<std::byte, kClipSetupBytes> head{};
  put_u32(head, 0, number);
  put_u64(head, 8, json.size());
  return block(ClipBlock::kSetup, 0, text_from(head) + json);
}

TEST_F(Clip, BlocksOfLaterProgramsAreSkipped) {
  write_file("a.clip", text_from(clip_head()) + block(99, 3, "something") + setup_block(0, "{}") +
                           frame_block(0, {}, "pixels!!") + block(77, 0, ""));
  ClipReader reader(path());
  ASSERT_EQ(reader.entries().size(), 1U);
  EXPECT_THAT(pixels_of(reader.read(0).image), ElementsAre('p', 'i', 'x', 'e', 'l', 's', '!', '!'));
}

TEST_F(Clip, AWrongIndexIsIgnored) {
  const std::string blocks = text_from(clip_head()) + setup_block(0, "{}") + frame_block(0, {}, "pixels!!") +
                             frame_block(1, {}, "PIXELS!!");
  const std::uint64_t first = text_from(clip_head()).size() + setup_block(0, "{}").size();
  const std::uint64_t bytes = kClipFrameBytes + 8, second = first + clip_block_bytes(bytes);
  const auto frame = static_cast<std::uint32_t>(ClipBlock::kFrame);
  const ClipIndexLine good{.place = first, .bytes = bytes, .type = frame, .is_whole = true};
  const ClipIndexLine other{.place = second, .bytes = bytes, .type = frame, .camera_id = 1, .is_whole = true};
  const ClipIndexLine setup{.place = kClipHeadBytes,
                            .bytes = kClipSetupBytes + 2,
                            .type = static_cast<std::uint32_t>(ClipBlock::kSetup)};
  write_file("a.clip", with_index(blocks, {setup, good, other}));
  {
    ClipReader reader(path());
    EXPECT_FALSE(reader.is_unfinished());
    ASSERT_EQ(reader.entries().size(), 2U);
    EXPECT_EQ(reader.read(1).info.camera_id, 1U);
  }
  // With impossible places in the index, the reader searches the file for blocks.
  std::vector<std::vector<ClipIndexLine>> lies{{setup, other, good}, {good, good}};
  for (const std::uint64_t place : {std::uint64_t{0}, std::uint64_t{8}, first + 1, blocks.size() - 8,
                                    blocks.size() + 8, ~std::uint64_t{0}, ~std::uint64_t{0} - 39}) {
    lies.push_back({good});
    lies.back()[0].place = place;
  }
  for (const std::uint64_t count :
       {std::uint64_t{0}, std::uint64_t{127}, ~std::uint64_t{0}, std::uint64_t{1} << 62U}) {
    lies.push_back({good});
    lies.back()[0].bytes = count;
  }
  for (const auto& lines : lies) {
    write_file("a.clip", with_index(blocks, lines));
    ClipReader reader(path());
    EXPECT_TRUE(reader.is_unfinished());
    ASSERT_EQ(reader.entries().size(), 2U);
    EXPECT_EQ(reader.read(1).info.camera_id, 1U);
  }
  // The index contradicts the frame: reading it throws.
  for (int what = 0; what < 5; ++what) {
    ClipIndexLine lie = good;
    if (what == 0) lie.number = 5;
    if (what == 1) lie.camera_id = 1;
    if (what == 2) lie.t_capture_s = 1;
    if (what == 3) lie.has_memory = true;
    if (what == 4) lie.is_whole = false;
    write_file("a.clip", with_index(blocks, {setup, lie}));
    ClipReader reader(path());
    ASSERT_EQ(reader.entries().size(), 1U);
    EXPECT_THROW(reader.read(0), ClipError);
  }
}

TEST_F(Clip, WrongSizesAreRefused) {
  const std::string begin = text_from(clip_head()) + setup_block(0, "{}");
  std::vector<ClipFrameHead> lies(9);
  lies[0].packet_bytes = ~std::uint64_t{0};
  lies[1].memory_bytes = 1;
  lies[2].width = 16384, lies[2].height = 16384;
  lies[3].width = -4, lies[3].height = -2;
  lies[4].is_deep = true;
  lies[5].info.times.t_capture_s = std::numeric_limits<double>::quiet_NaN();
  lies[6].info.times.t_capture_camera_s = std::numeric_limits<double>::infinity();
  lies[7].width = 4, lies[7].height = 2, lies[7].format = PixelFormat::kRgb24;
  lies[8].info.whole.x = -1;
  std::vector<std::string> blocks;
  blocks.reserve(lies.size() + 2);
  for (const ClipFrameHead& lie : lies) blocks.push_back(frame_block(0, lie, "pixels!!"));
  blocks.push_back(frame_block(0, {}, "pixels!!", 88, 4));  // size of the bitmap of an image in parts
  blocks.push_back(frame_block(0, {.image_bytes = 9}, "pixels!!!"));
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    SCOPED_TRACE(i);
    write_file("a.clip", begin + blocks[i] + frame_block(4, {}, "pixels!!"));
    ClipReader reader(path());
    ASSERT_EQ(reader.entries().size(), 1U);
    EXPECT_EQ(reader.read(0).info.camera_id, 4U);
  }
  // A setup with a large number does not allocate memory for all smaller numbers.
  write_file("a.clip",
             begin + setup_block(4'000'000'000, "{}") + frame_block(0, {.setup = 4'000'000'000}, "pixels!!"));
  ClipReader reader(path());
  EXPECT_EQ(reader.setup_count(), 1U);
  EXPECT_THROW(reader.read(0), ClipError);
  // Blocks larger than the file.
  std::string huge = text_from(encoded(ClipBlockHead{.type = 3, .bytes = std::uint64_t{1} << 62U}));
  write_file("a.clip", begin + huge);
  EXPECT_EQ(ClipReader(path()).entries().size(), 0U);
  huge = text_from(encoded(ClipBlockHead{.type = 2, .bytes = ~std::uint64_t{0} - 31}));
  write_file("a.clip", begin + huge);
  EXPECT_EQ(ClipReader(path()).entries().size(), 0U);
}

/// Written by an earlier version, which could store parts of images, as in each camera's last two frames.
TEST_F(Clip, PartialImagesAreSkipped) {
  ClipReader reader(source_path("/tests/golden/parts.clip"));
  EXPECT_EQ(reader.problem(), "");
  EXPECT_EQ(reader.about().kind, "");
  ASSERT_EQ(reader.entries().size(), 12U);
  for (std::size_t i = 0; i < 12; ++i) {
    SCOPED_TRACE(i);
    const ClipFrame& frame = reader.read(i);
    EXPECT_EQ(frame.info.number, 100 + i / 2);
    EXPECT_EQ(text_from(frame.packet), i / 2 == 2 ? "" : "packet " + std::to_string(i / 2));
    EXPECT_EQ(frame.image.empty(), i >= 8);
    EXPECT_EQ(reader.entries()[i].is_whole, i < 8);
  }
}

TEST_F(Clip, CrashClipsOfEarlierVersionsAreRecognised) {
  const auto kind_of = [&](const std::string& about) {
    write_file("a.clip", text_from(clip_head()) + block(ClipBlock::kAbout, 0, about));
    return ClipReader(path()).about().kind;
  };
  EXPECT_EQ(kind_of(R"({"why": "the service crashed"})"), "crash");
  EXPECT_EQ(kind_of(R"({"why": "kept by hand"})"), "");
  EXPECT_EQ(kind_of(R"({"why": "the service crashed", "kind": "alert"})"), "alert");
  EXPECT_EQ(kind_of(R"({"kind": 7})"), "");
}

TEST_F(Clip, ControlCharactersInTextsAreEscaped) {
  write_file("a.clip",
             text_from(clip_head()) + block(ClipBlock::kAbout, 0, R"({"site": "a\u001b[2Jb", "why": 3})") +
                 block(ClipBlock::kEvent, 0, R"({"time_s": 5, "kind": "x", "text": "a\nb"})") +
                 block(ClipBlock::kEvent, 0, "[1, 2") + block(ClipBlock::kEvent, 0, std::string(200, '[')));
  const ClipReader reader(path());
  EXPECT_EQ(reader.about().site, "a\\u001b[2Jb");
  EXPECT_EQ(reader.about().why, "");
  ASSERT_EQ(reader.events().size(), 1U);
  EXPECT_EQ(reader.events()[0].text, "a\\u000ab");
}

/// During its lifetime, this process can write no file larger than `bytes`.
class SmallDisk {
 public:
  explicit SmallDisk(std::uint64_t bytes) : handler_(::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &limit_);
    const rlimit small{bytes, limit_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &small);
  }
  ~SmallDisk() {
    ::setrlimit(RLIMIT_FSIZE, &limit_);
    ::signal(SIGXFSZ, handler_);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

 private:
  rlimit limit_{};
  void (*handler_)(int);
};

TEST_F(Clip, AFullDiskLeavesTheCompleteFrames) {
  const OwnedImage image = noise_image(PixelFormat::kMono8, 40, 30, 1);
  ClipFrame frame;
  frame.image = image.view;
  std::size_t added = 0;
  std::uint64_t bytes = 0;
  {
    ClipWriter writer(path(), kAbout);
    writer.add(ClipSetup{});
    {
      const SmallDisk disk(10'000);
      try {
        for (;; ++added) {
          frame.info.number = static_cast<std::uint32_t>(added);
          frame.info.times.t_capture_s = static_cast<double>(added);
          writer.add(frame);
        }
      } catch (const StorageError& error) {
        EXPECT_EQ(error.what(), path().string() + ": cannot be written: File too large");
      }
    }
    EXPECT_GE(added, 5U);
    bytes = writer.bytes();
    EXPECT_EQ(fs::file_size(path()), bytes) << "what was written in part is cut off";
    {
      ClipReader reader(path());
      EXPECT_EQ(reader.entries().size(), added);
      EXPECT_TRUE(reader.is_unfinished());
    }
    // The disk has space again.
    writer.add(frame);
    writer.finish();
  }
  ClipReader reader(path());
  EXPECT_FALSE(reader.is_unfinished());
  ASSERT_EQ(reader.entries().size(), added + 1);
  for (std::size_t i = 0; i <= added; ++i) EXPECT_TRUE(pixels_of(reader.read(i).image) == image.bytes);
}

TEST_F(Clip, WriteErrorsNameTheFile) {
  write_file("there.clip", "");
  for (const std::string name : {"there.clip", "no/folder.clip"}) {
    try {
      ClipWriter(path(name), kAbout);
      ADD_FAILURE() << name;
    } catch (const StorageError& error) {
      EXPECT_THAT(error.what(), StartsWith(path(name).string() + ": cannot be written: "));
    }
  }
  ClipWriter writer(path(), kAbout);
  const OwnedImage image = noise_image(PixelFormat::kMono8, 8, 8, 1);
  ClipFrame frame;
  frame.image = image.view;
  EXPECT_THROW(writer.add(frame), StorageError);  // no setup was added
  writer.add(ClipSetup{});
  writer.add(frame);
  writer.add(frame);
  frame.image.width = 16385;
  EXPECT_THROW(writer.add(frame), StorageError);
  EXPECT_THROW(writer.add(ClipSetup{.table = std::vector<std::byte>(kMaxClipTableBytes + 1)}), StorageError);
  EXPECT_THROW(writer.add(ClipEvent{0, "x", std::string(kMaxClipJsonBytes, 'x')}), StorageError);
  writer.finish();
  EXPECT_EQ(ClipReader(path()).entries().size(), 2U);
}

TEST_F(Clip, GoesOnWhenItIsRemoved) {
  const std::vector<Kept> kept = write_small();
  ClipReader reader(path());
  fs::remove(path());
  EXPECT_EQ(expect_no_other(reader, kept), kept.size());
}

/// Bytes that this program has read so far.
std::uint64_t bytes_read() {
  std::ifstream io("/proc/self/io");
  std::string key;
  std::uint64_t value = 0;
  io >> key >> value;
  return key == "rchar:" ? value : 0;
}

TEST_F(Clip, OpeningReadsNoImages) {
  if (bytes_read() == 0) GTEST_SKIP() << "the kernel does not say what was read";
  const OwnedImage image = noise_image(PixelFormat::kMono8, 1000, 1000, 1);
  std::vector<std::uint64_t> counts;
  for (const std::size_t frames : {5U, 50U}) {
    const std::string name = std::to_string(frames) + ".clip";
    {
      ClipWriter writer(path(name), kAbout);
      writer.add(ClipSetup{});
      ClipFrame frame;
      frame.image = image.view;
      for (std::size_t i = 0; i < frames; ++i) writer.add(frame);
      writer.finish();
    }
    const std::uint64_t before = bytes_read();
    const ClipReader reader(path(name));
    counts.push_back(bytes_read() - before);
    EXPECT_EQ(reader.entries().size(), frames);
  }
  EXPECT_LT(counts[1], counts[0] + 2 * 45 * kClipIndexBytes + 500)
      << "each frame is a line of the index, which is summed first";
}

/// A sparse file: only written data needs space on the disk.
class SparseFile {
 public:
  explicit SparseFile(const fs::path& path)
      : fd_(::open(path.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600)) {}
  ~SparseFile() { ::close(fd_); }
  SparseFile(const SparseFile&) = delete;
  SparseFile& operator=(const SparseFile&) = delete;

  void put(const std::string& bytes, std::uint64_t place) {
    EXPECT_EQ(::pwrite(fd_, bytes.data(), bytes.size(), static_cast<off_t>(place)),
              static_cast<ssize_t>(bytes.size()));
  }
  /// Writes a block's head and `payload`, followed by zeros. Returns the place of the next block.
  std::uint64_t put_block(ClipBlock type, const std::string& payload, std::uint64_t bytes,
                          std::uint64_t place) {
    std::vector<std::byte> all = bytes_from(payload);
    all.resize(bytes);
    put(text_from(encoded(
            ClipBlockHead{.type = static_cast<std::uint32_t>(type), .bytes = bytes, .sum = clip_sum(all)})),
        place);
    put(payload, place + kClipBlockBytes);
    const std::uint64_t end = place + clip_block_bytes(bytes);
    struct stat now {};
    if (::fstat(fd_, &now) != 0 || static_cast<std::uint64_t>(now.st_size) >= end) return end;
    EXPECT_EQ(::ftruncate(fd_, static_cast<off_t>(end)), 0);
    return end;
  }
  std::uint64_t bytes_on_disk() const {
    struct stat about {};
    ::fstat(fd_, &about);
    return static_cast<std::uint64_t>(about.st_blocks) * 512;
  }

 private:
  int fd_;
};

/// JSON of at most `max_bytes` whose values take much more memory than their text.
std::string json_of_many(const std::string& value, std::size_t max_bytes) {
  std::string out = R"({"a": [)" + value;
  while (out.size() + value.size() + 3 <= max_bytes) out += "," + value;
  return out + "]}";
}

TEST_F(Clip, AnIndexIsComparedWithItsLimitBeforeItIsRead) {
  if (!counts_allocations()) GTEST_SKIP() << "the sanitizer has its own allocator";
  constexpr std::uint64_t kBytes = std::uint64_t{kClipIndexBytes} * 37'500'000;
  {
    SparseFile file(path());
    file.put(text_from(clip_head()), 0);
    file.put(text_from(encoded(
                 ClipBlockHead{.type = static_cast<std::uint32_t>(ClipBlock::kIndex), .bytes = kBytes})),
             kClipHeadBytes);
    file.put(text_from(clip_trailer(kClipHeadBytes)), kClipHeadBytes + clip_block_bytes(kBytes));
    EXPECT_LE(file.bytes_on_disk(), 16'384U);
  }
  EXPECT_TRUE(test::fits_into(test::kMemoryForAFile, [&] { refusal("a.clip"); }));
  EXPECT_EQ(refusal("a.clip"), "has an index of 37500000 blocks; a clip has at most 524288");
}

TEST_F(Clip, NoFileTakesMuchMemory) {
  if (!counts_allocations()) GTEST_SKIP() << "the sanitizer has its own allocator";
  const auto fits = [&] {
    return test::fits_into(test::kMemoryForAFile, [&] {
      ClipReader reader(path());
      for (std::size_t i = 0; i < reader.setup_count(); ++i) reader.setup(i);
      try {
        for (std::size_t i = 0; i < std::min<std::size_t>(3, reader.entries().size()); ++i) reader.read(i);
      } catch (const ClipError&) {
      }
    });
  };
  const std::string begin = text_from(clip_head());
  {  // tables of maximum size, each with JSON of maximum size
    SparseFile file(path());
    file.put(begin, 0);
    std::uint64_t place = begin.size();
    for (std::uint32_t number = 0; number < 24; ++number) {
      const std::string json = json_of_many(R"("xx")", kMaxClipJsonBytes);
      place = file.put_block(ClipBlock::kSetup, text_from(setup_head(number, json.size())) + json,
                             kClipSetupBytes + json.size() + kMaxClipTableBytes, place);
    }
  }
  EXPECT_EQ(ClipReader(path()).setup_count(), 24U);
  EXPECT_EQ(ClipReader(path()).setup(23).table.size(), kMaxClipTableBytes);
  EXPECT_TRUE(fits());
  {  // events whose values take much more memory than their text
    SparseFile file(path());
    file.put(begin, 0);
    std::uint64_t place = begin.size();
    const std::string json = json_of_many("[1000]", kMaxClipEventBytes);
    for (int i = 0; i < 50; ++i) place = file.put_block(ClipBlock::kEvent, json, json.size(), place);
  }
  EXPECT_EQ(ClipReader(path()).events().size(), kMaxClipEventBytesInAll / kMaxClipEventBytes);
  EXPECT_TRUE(fits());
  {  // the maximum number of frames, of more cameras than allowed
    SparseFile file(path());
    file.put(begin, 0);
    std::string index;
    std::uint64_t place = begin.size();
    for (std::uint32_t number = 0; number < kMaxClipBlocks; ++number) {
      index += text_from(encoded(ClipIndexLine{.place = place,
                                               .bytes = kClipFrameBytes,
                                               .type = static_cast<std::uint32_t>(ClipBlock::kFrame),
                                               .camera_id = number % 300}));
      place += clip_block_bytes(kClipFrameBytes);
    }
    const std::uint64_t end = file.put_block(ClipBlock::kIndex, index, index.size(), place);
    file.put(text_from(clip_trailer(place)), end);
  }
  EXPECT_TRUE(fits());
  const ClipReader many(path());
  EXPECT_EQ(many.cameras().size(), 256U);
  EXPECT_THAT(many.problem(), HasSubstr("more than 524288 frames or 256 cameras; the rest is ignored"));
  {  // an image of zeros
    SparseFile file(path());
    file.put(begin, 0);
    const ClipFrameHead head{
        .format = PixelFormat::kRgb24, .width = 4096, .height = 4096, .image_bytes = std::uint64_t{3} << 24U};
    file.put_block(ClipBlock::kFrame, text_from(encoded(head)), kClipFrameBytes + head.image_bytes,
                   file.put_block(ClipBlock::kSetup, text_from(setup_head(0, 2)) + "{}", kClipSetupBytes + 2,
                                  begin.size()));
  }
  EXPECT_EQ(ClipReader(path()).read(0).image.width, 4096);
  EXPECT_TRUE(fits());
}

TEST_F(Clip, AllLimitsAtOnceTakeLittleMemory) {
  if (!counts_allocations()) GTEST_SKIP() << "the sanitizer has its own allocator";
  constexpr std::size_t kEvents = kMaxClipEventBytesInAll / kMaxClipEventBytes;
  constexpr std::size_t kFrames = kMaxClipBlocks - kEvents - 1;
  constexpr int kWidth = 4096, kHeight = (kMaxClipBytesInMemory - 28 * kFrames) / kWidth;
  {
    SparseFile file(path());
    file.put(text_from(clip_head()), 0);
    std::uint64_t place = kClipHeadBytes;
    std::string index;
    const auto note = [&](ClipBlock type, std::uint64_t bytes, double time_s = 0) {
      const bool is_frame = type == ClipBlock::kFrame;
      index += text_from(encoded(ClipIndexLine{.place = place,
                                               .bytes = bytes,
                                               .t_capture_s = time_s,
                                               .type = static_cast<std::uint32_t>(type),
                                               .has_memory = is_frame,
                                               .is_whole = is_frame}));
    };
    const std::string json = json_of_many(R"("xx")", kMaxClipJsonBytes);
    const std::uint64_t setup_bytes = kClipSetupBytes + json.size() + kMaxClipTableBytes;
    note(ClipBlock::kSetup, setup_bytes);
    place =
        file.put_block(ClipBlock::kSetup, text_from(setup_head(0, json.size())) + json, setup_bytes, place);
    // Each character has two bytes and is escaped to six.
    std::string event = R"({"text": ")";
    while (event.size() + 4 <= kMaxClipEventBytes) event += "\xc2\x85";
    event += R"("})";
    for (std::size_t i = 0; i < kEvents; ++i) {
      note(ClipBlock::kEvent, event.size());
      place = file.put_block(ClipBlock::kEvent, event, event.size(), place);
    }
    for (int i = 1; i <= 3; ++i) {  // images of zeros, each larger than the one before
      ClipFrameHead head{.width = kWidth, .height = kHeight * i / 3};
      head.info.times.t_capture_s = i;
      head.memory_bytes = kMaxClipMemoryBytes;
      head.image_bytes = clip_plane_bytes(head.format, head.width, head.height);
      const std::uint64_t bytes = kClipFrameBytes + head.memory_bytes + head.image_bytes;
      note(ClipBlock::kFrame, bytes, i);
      place = file.put_block(ClipBlock::kFrame, text_from(encoded(head)), bytes, place);
    }
    for (std::size_t i = 3; i < kFrames; ++i) {
      note(ClipBlock::kFrame, kClipFrameBytes, 9);
      place += clip_block_bytes(kClipFrameBytes);
    }
    const std::uint64_t end = file.put_block(ClipBlock::kIndex, index, index.size(), place);
    file.put(text_from(clip_trailer(place)), end);
  }
  {
    ClipReader reader(path());
    EXPECT_EQ(reader.entries().size(), kFrames);
    EXPECT_EQ(reader.events().size(), kEvents);
    EXPECT_EQ(reader.read(2).image.height, kHeight);
    EXPECT_EQ(reader.read(2).memory.size(), kMaxClipMemoryBytes);
    EXPECT_TRUE(reader.setup(0).about.is_object());
  }
  EXPECT_TRUE(test::fits_into(test::kMemoryForAFile, [&] {
    ClipReader reader(path());
    for (std::size_t i = 0; i < 3; ++i) reader.read(i);
  }));
  EXPECT_TRUE(test::fits_into(test::kMemoryForAFile, [&] { ClipReader(path()).setup(0); }));
}

TEST_F(Clip, TooLargeAnImageIsReported) {
  const ClipFrameHead head{
      .format = PixelFormat::kRgb24, .width = 4098, .height = 4098, .image_bytes = 3 * 4098 * 4098};
  {
    SparseFile file(path());
    file.put(text_from(clip_head()), 0);
    file.put_block(ClipBlock::kFrame, text_from(encoded(head)), kClipFrameBytes + head.image_bytes,
                   kClipHeadBytes);
  }
  ClipReader reader(path());
  ASSERT_EQ(reader.entries().size(), 1U);
  try {
    reader.read(0);
    ADD_FAILURE();
  } catch (const ClipError& error) {
    EXPECT_THAT(error.what(), HasSubstr("frame 0 of camera 0 has an image that is larger than 48 MiB"));
  }
}

}  // namespace
}  // namespace sslv::clip_test
