// SPDX-License-Identifier: Apache-2.0
// libFuzzer: for any file, a clip's reader returns images of the stated size or throws a one-line error. The
// first byte selects whether checksums are corrected first, so that the code behind them is reached; the rest
// is the file. ./run test-long
#include "clips/clip_format.h"
#include "clips/clip_reader.h"
#include "fuzz/expect.h"
#include "fuzz/live_bytes.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <vector>

#include <unistd.h>

namespace sslv {

unsigned seen = 0;  // keeps the compiler from removing the reads

namespace {

/// Corrects the checksums of all consecutive blocks.
void repair_sums(std::span<std::byte> file) {
  if (file.size() < kClipHeadBytes) return;
  std::ranges::copy(clip_head(), file.begin());
  std::size_t place = kClipHeadBytes;
  while (file.size() - place >= kClipBlockBytes) {
    const std::span<std::byte> block = file.subspan(place);
    const std::uint64_t bytes = u64_at(block, 8);
    if (bytes > block.size() - kClipBlockBytes) return;
    const auto payload = block.subspan(kClipBlockBytes, static_cast<std::size_t>(bytes));
    if (u32_at(block, 0) == static_cast<std::uint32_t>(ClipBlock::kFrame) && bytes >= kClipFrameBytes)
      put_u32(payload, kClipFrameBytes - 4, clip_sum(payload.first(kClipFrameBytes - 4)));
    put_u32(block, 24, clip_sum(payload));
    put_u32(block, 28, clip_sum(block.first(28)));
    const std::uint64_t whole = clip_block_bytes(bytes);
    if (whole > block.size()) return;
    place += static_cast<std::size_t>(whole);
  }
}

void look_at(const ImageView& image, std::size_t file_bytes) {
  if (image.empty()) return;
  expect(is_valid_size(image.format, image.width, image.height), "an image of a size that none has");
  const int row_bytes = image.width * bytes_per_pixel(image.format);
  expect(static_cast<std::size_t>(row_bytes) * static_cast<std::size_t>(image.height) <= file_bytes,
         "an image that is larger than the file");
  for (const std::ptrdiff_t plane : {std::ptrdiff_t{0}, image.to_low_bits}) {
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < row_bytes; ++x) seen += (image.row(y) + plane)[x];
    }
  }
}

void read_all(const std::string& name, std::size_t file_bytes) {
  ClipReader reader(name);
  expect(reader.entries().size() * kClipFrameBytes <= file_bytes, "more frames than there is room for");
  expect(reader.setup_count() * kClipSetupBytes <= file_bytes, "more setups than there is room for");
  for (std::size_t i = 0; i < reader.setup_count(); ++i)
    expect(reader.setup(i).table.size() <= file_bytes, "a table that is larger than the file");
  std::size_t of_cameras = 0;
  for (const ClipReader::Camera& camera : reader.cameras()) of_cameras += camera.frames.size();
  expect(of_cameras == reader.entries().size(), "a frame of no camera");
  // Frames are ordered by time, except those of a camera after its clock was set back.
  std::map<std::uint32_t, double> latest_s;
  double before_s = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < reader.entries().size(); ++i) {
    const ClipReader::Entry& entry = reader.entries()[i];
    double& now_s = latest_s.emplace(entry.camera_id, entry.t_capture_s).first->second;
    now_s = std::max(now_s, entry.t_capture_s);
    expect(before_s <= now_s, "not in the order of capture");
    before_s = now_s;
    try {
      const ClipFrame& frame = reader.read(i);
      expect(frame.setup < reader.setup_count(), "a setup that is not there");
      expect(frame.info.number == reader.entries()[i].number, "another frame");
      expect(std::isfinite(frame.info.times.t_capture_s), "a time that is no number");
      look_at(frame.image, file_bytes);
      for (const auto part : {frame.packet, frame.memory}) {
        for (const std::byte byte : part) seen += std::to_integer<unsigned>(byte);
      }
    } catch (const ClipError& error) {
      expect(std::string(error.what()).starts_with(name), "an error that names no file");
    }
  }
}

}  // namespace
}  // namespace sslv

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace sslv;
  if (size == 0) return 0;
  const LiveBytes live(kMaxLiveBytes);
  static const std::string name = "/dev/shm/ssl-visiond-fuzz-" + std::to_string(getpid()) + ".clip";
  const auto input = std::as_bytes(std::span(bytes + 1, size - 1));
  std::vector<std::byte> file(input.begin(), input.end());
  if (bytes[0] % 4 != 0) repair_sums(file);
  std::ofstream(name, std::ios::binary)
      .write(reinterpret_cast<const char*>(file.data()), static_cast<std::streamsize>(file.size()));
  try {
    read_all(name, file.size());
  } catch (const ClipError& error) {
    expect(std::string(error.what()).starts_with(name), "an error that names no file");
  }
  std::filesystem::remove(name);
  return 0;
}
