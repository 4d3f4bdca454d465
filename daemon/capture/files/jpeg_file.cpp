// SPDX-License-Identifier: Apache-2.0
#include "capture/files/jpeg_file.h"

#include "image/jpeg_decoder.h"

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace sslv {

Image read_jpeg_file(const std::string& path, PicturePool& pool) {
  constexpr std::uintmax_t kMaxBytes = 256 * 1024 * 1024;
  const std::uintmax_t size = std::filesystem::file_size(path);  // throws if there is no such file
  if (size > kMaxBytes) throw std::runtime_error(fmt::format("{} bytes are too many for an image", size));
  std::vector<std::uint8_t> bytes(size);
  std::ifstream in(path, std::ios::binary);
  if (!in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size)))
    throw std::system_error(errno, std::generic_category(), "cannot be read");

  JpegDecoder decoder;
  std::string problem = "not a JPEG";
  const ImageView layout = decoder.layout(bytes, problem);
  if (layout.width == 0) throw std::runtime_error(problem);
  std::uint8_t* pixels = nullptr;
  Image image = pool.take(layout.format, layout.width, layout.height, pixels);
  if (!decoder.decode(bytes, pixels, problem)) throw std::runtime_error(problem);
  return image;
}

}  // namespace sslv
