// SPDX-License-Identifier: Apache-2.0
// libFuzzer: the callers of the image decoders allocate buffers that are large enough. The first byte
// selects how the rest is used: a camera's JPEG, or an image or video file. ./run test-long
#include "capture/files/file_media.h"
#include "fuzz/expect.h"
#include "image/jpeg_decoder.h"

#include <array>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <unistd.h>

extern "C" {
#include <libavutil/log.h>
}

namespace sslv {

unsigned seen = 0;  // keeps the compiler from removing the reads

namespace {

/// Larger images would take too long; those of real cameras are far smaller.
constexpr int kLargestSide = 4096;

/// Reads every pixel, so that sanitizers detect out-of-bounds data.
void look_at(const ImageView& image) {
  if (image.width == 0) return;
  const std::size_t row_bytes =
      static_cast<std::size_t>(image.width) * (image.format == PixelFormat::kRgb24 ? 3 : 2);
  for (int y = 0; y < image.height; ++y) {
    const std::uint8_t* row = image.data + static_cast<std::ptrdiff_t>(y) * image.stride_bytes;
    for (std::size_t x = 0; x < row_bytes; ++x) seen += row[x];
  }
}

void check_jpeg(std::span<const std::uint8_t> jpeg) {
  static JpegDecoder decoder;
  std::string problem;
  const ImageView layout = decoder.layout(jpeg, problem);
  if (layout.width == 0) return expect(!problem.empty(), "no picture, and no reason");
  expect(layout.width > 0 && layout.height > 0, "a size below zero");
  if (layout.width > kLargestSide || layout.height > kLargestSide) return;
  expect(layout.format == PixelFormat::kUyvy || layout.format == PixelFormat::kRgb24, "another format");
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(layout.stride_bytes) *
                                   static_cast<std::size_t>(layout.height));
  if (!decoder.decode(jpeg, pixels.data(), problem))
    return expect(!problem.empty(), "damaged, and no reason");
  look_at({pixels.data(), layout.width, layout.height, layout.stride_bytes, layout.format});
}

void check_file(std::span<const std::uint8_t> bytes, const char* extension, bool still) {
  static const std::string stem = "/dev/shm/ssl-visiond-fuzz-" + std::to_string(getpid());
  const std::string name = stem + extension;
  std::ofstream(name, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  try {
    MediaReader reader(name, still);
    PicturePool pool;
    for (int i = 0; i < 8; ++i) {
      Image image;
      std::string problem;
      const auto result = reader.read(pool, image, problem);
      if (result == MediaReader::Result::kEnd) break;
      if (result == MediaReader::Result::kDamaged) expect(!problem.empty(), "damaged, and no reason");
      if (result == MediaReader::Result::kPicture) look_at(image.view());
    }
  } catch (const std::runtime_error& error) {
    expect(std::string(error.what()).size() > 0, "no reason");
  }
  std::filesystem::remove(name);
}

}  // namespace
}  // namespace sslv

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  av_log_set_level(AV_LOG_QUIET);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  if (size == 0) return 0;
  static constexpr std::array kExtensions{".png", ".jpg", ".bmp", ".ppm", ".mp4", ".avi"};
  const std::span<const std::uint8_t> rest(bytes + 1, size - 1);
  const std::size_t kind = bytes[0] % (kExtensions.size() + 1);
  if (kind == kExtensions.size()) {
    sslv::check_jpeg(rest);
  } else {
    sslv::check_file(rest, kExtensions[kind], kind < 4);
  }
  return 0;
}
