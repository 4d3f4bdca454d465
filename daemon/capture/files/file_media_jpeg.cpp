// SPDX-License-Identifier: Apache-2.0
// MediaReader of a program built without FFmpeg: supports only JPEGs, with the library that previews and
// webcams need anyway.
#include "capture/files/file_media.h"
#include "capture/files/jpeg_file.h"

#include <cstdint>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace sslv {
namespace {

bool is_jpeg(std::string_view path) {
  for (const std::string_view ending : {".jpg", ".jpeg", ".JPG", ".JPEG"})
    if (path.ends_with(ending)) return true;
  return false;
}

}  // namespace

struct MediaReader::Libraries {
  std::string path;
  bool is_read = false;
};

MediaReader::MediaReader(const std::string& path, bool still) : av_(std::make_unique<Libraries>()) {
  if (!still || !is_jpeg(path)) {
    throw std::runtime_error(
        "this program reads JPEGs and raw frames only; for other images and videos, install "
        "libavformat-dev, libavcodec-dev, libavutil-dev and libswscale-dev and build again");
  }
  av_->path = path;
}

MediaReader::~MediaReader() = default;

double MediaReader::frame_rate_hz() const {
  return 0;
}

std::int64_t MediaReader::count() const {
  return 1;
}

bool MediaReader::seek(std::int64_t /*image*/, Clock::time_point /*until*/) {
  av_->is_read = false;
  return true;
}

std::optional<double> MediaReader::time_s() const {
  return std::nullopt;
}

MediaReader::Result MediaReader::read(PicturePool& pool, Image& image, std::string& problem,
                                      Clock::time_point /*until*/) {
  if (std::exchange(av_->is_read, true)) return Result::kEnd;
  try {
    image = read_jpeg_file(av_->path, pool);
    return Result::kPicture;
  } catch (const std::exception& error) {
    problem = error.what();
    return Result::kDamaged;
  }
}

}  // namespace sslv
