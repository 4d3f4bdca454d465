// SPDX-License-Identifier: Apache-2.0
#include "capture/aravis/aravis_images.h"

#include "capture/unpack.h"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

namespace sslv {
namespace {

std::string_view text_of(ArvBufferStatus status) {
  switch (status) {
    case ARV_BUFFER_STATUS_TIMEOUT: return "its last packets did not arrive";
    case ARV_BUFFER_STATUS_MISSING_PACKETS: return "packets are missing";
    case ARV_BUFFER_STATUS_WRONG_PACKET_ID: return "a packet has a wrong number";
    case ARV_BUFFER_STATUS_SIZE_MISMATCH: return "more bytes arrived than announced";
    case ARV_BUFFER_STATUS_FILLING: return "it was still being filled";
    case ARV_BUFFER_STATUS_ABORTED: return "it was aborted";
    default: return "it was not filled";
  }
}

/// Without padding, rows follow each other without a gap, even within a byte.
std::size_t bytes_of(const AravisFormat& format, const SentPicture& sent) {
  const auto width = static_cast<std::size_t>(sent.width), height = static_cast<std::size_t>(sent.height);
  if (sent.padding_bytes == 0) return sent_bytes(format, width * height);
  return (sent_bytes(format, width) + sent.padding_bytes) * height - sent.padding_bytes;
}

void unpack_pixels(const SentPicture& sent, const ImageView& layout, std::uint8_t* to) {
  const auto width = static_cast<std::size_t>(sent.width), height = static_cast<std::size_t>(sent.height);
  const auto unpack = [&](const std::uint8_t* from, std::size_t pixels, std::uint8_t* row) {
    if (sent.format->unpack != nullptr) return sent.format->unpack(from, pixels, row);
    sent.format->split(from, pixels, row, row + layout.to_low_bits);
  };
  if (sent.padding_bytes == 0) return unpack(sent.data, width * height, to);
  const std::size_t from_bytes = sent_bytes(*sent.format, width) + sent.padding_bytes;
  const auto to_bytes = static_cast<std::size_t>(layout.stride_bytes);
  for (std::size_t y = 0; y < height; ++y) unpack(sent.data + y * from_bytes, width, to + y * to_bytes);
}

}  // namespace

ImageView view_of(const SentPicture& sent) {
  const auto row_bytes = sent_bytes(*sent.format, static_cast<std::size_t>(sent.width));
  return {sent.data, sent.width, sent.height, static_cast<std::ptrdiff_t>(row_bytes + sent.padding_bytes),
          sent.format->format};
}

void AravisBufferReader::read_region(ArvCamera* camera, std::string_view label) {
  Failure failure;
  gint sensor_width = 0, sensor_height = 0, x = 0, y = 0, width = 0, height = 0, bin_x = 1, bin_y = 1;
  arv_camera_get_sensor_size(camera, &sensor_width, &sensor_height, failure);
  failure.require_answer(label);
  if (failure.failed()) return;
  arv_camera_get_region(camera, &x, &y, &width, &height, failure);
  failure.require_answer(label);
  if (failure.failed()) return;
  arv_camera_get_binning(camera, &bin_x, &bin_y, failure);
  failure.require_answer(label);
  const WholePicture sensor{sensor_width / std::max(1, bin_x), sensor_height / std::max(1, bin_y), x, y};
  const bool is_part = width < sensor.width || height < sensor.height;
  const bool is_within = x + width <= sensor.width && y + height <= sensor.height;
  if (is_part && is_within) whole_ = sensor;
}

SentPicture sound_picture(const ClaimedPicture& claimed, const std::uint8_t* begin, std::string& problem) {
  const AravisFormat* format = find_aravis_format(claimed.format);
  // In YUV 4:1:1 four pixels share a colour.
  const int group = format != nullptr && format->unpack == yuv411_to_uyvy ? 4 : 1;
  if (format == nullptr || claimed.padding_bytes < 0 || claimed.width % group != 0 ||
      !is_valid_size(format->format, claimed.width, claimed.height)) {
    problem = fmt::format("{}x{} pixels of format 0x{:08x} are not supported", claimed.width, claimed.height,
                          claimed.format);
    return {};
  }
  SentPicture sent;
  sent.width = claimed.width;
  sent.height = claimed.height;
  sent.padding_bytes = static_cast<std::size_t>(claimed.padding_bytes);
  const std::size_t needed = bytes_of(*format, sent), there = std::min(claimed.came, claimed.allocated);
  const std::size_t size = claimed.offset < there ? std::min(claimed.bytes, there - claimed.offset) : 0;
  if (size < needed) {
    problem = fmt::format("{} bytes arrived; {}x{} of format 0x{:08x} needs {}", size, sent.width,
                          sent.height, format->arv, needed);
    return {};
  }
  sent.data = begin + claimed.offset;
  sent.format = format;
  return sent;
}

bool AravisBufferReader::is_within(ArvBuffer* buffer) const {
  std::size_t came = 0;
  arv_buffer_get_data(buffer, &came);
  return came <= buffer_bytes_;
}

/// The library does not report the layout of a damaged image, so this assumes the layout of the last complete
/// image.
SentPicture AravisBufferReader::damaged_picture_in(ArvBuffer* buffer) const {
  SentPicture sent = last_whole_;
  std::size_t size = 0;
  sent.data = static_cast<const std::uint8_t*>(arv_buffer_get_data(buffer, &size)) + last_whole_offset_;
  return sent;
}

SentPicture AravisBufferReader::picture_in(ArvBuffer* buffer, std::string& problem) {
  const ArvBufferStatus status = arv_buffer_get_status(buffer);
  const bool lacks_packets =
      status == ARV_BUFFER_STATUS_TIMEOUT || status == ARV_BUFFER_STATUS_MISSING_PACKETS;
  if (status != ARV_BUFFER_STATUS_SUCCESS) {
    problem = text_of(status);
    return lacks_packets && use_incomplete_ ? damaged_picture_in(buffer) : SentPicture{};
  }
  // The sender's raw number, which need not be a value of the library's enum.
  const int payload = arv_buffer_get_payload_type(buffer);
  if (payload != ARV_BUFFER_PAYLOAD_TYPE_IMAGE && payload != ARV_BUFFER_PAYLOAD_TYPE_EXTENDED_CHUNK_DATA &&
      payload != ARV_BUFFER_PAYLOAD_TYPE_MULTIPART) {
    problem = fmt::format("it has payload type {}, not an image", payload);
    return {};
  }
  // In a multipart buffer the image is the first part.
  if (arv_buffer_get_n_parts(buffer) == 0 ||
      arv_buffer_get_part_data_type(buffer, 0) != ARV_BUFFER_PART_DATA_TYPE_2D_IMAGE) {
    problem = "its first part is not an image";
    return {};
  }
  ClaimedPicture claimed;
  claimed.format = arv_buffer_get_image_pixel_format(buffer);
  claimed.width = arv_buffer_get_image_width(buffer);
  claimed.height = arv_buffer_get_image_height(buffer);
  gint y_padding = 0;
  arv_buffer_get_image_padding(buffer, &claimed.padding_bytes, &y_padding);
  const auto* begin = static_cast<const std::uint8_t*>(arv_buffer_get_data(buffer, &claimed.came));
  const void* data = arv_buffer_get_image_data(buffer, &claimed.bytes);
  claimed.offset = reinterpret_cast<std::uintptr_t>(data) - reinterpret_cast<std::uintptr_t>(begin);
  claimed.allocated = buffer_bytes_;
  const SentPicture sent = sound_picture(claimed, begin, problem);
  if (sent.format == nullptr) return {};
  last_whole_ = sent;
  last_whole_offset_ = sent.data - begin;
  return sent;
}

bool AravisUnpacker::unpack(const SentPicture& sent, Image& image) {
  ImageView layout{nullptr, sent.width, sent.height, 0, sent.format->format};
  layout.stride_bytes = std::ptrdiff_t{sent.width} * bytes_per_pixel(layout.format);
  const std::ptrdiff_t plane_bytes = layout.stride_bytes * sent.height;
  if (sent.format->split != nullptr) layout.to_low_bits = plane_bytes;
  const auto picture_bytes = static_cast<std::size_t>(plane_bytes + layout.to_low_bits);
  if (picture_bytes > pool_bytes_) {
    pool_.emplace(static_cast<std::size_t>(buffers_), picture_bytes);
    pool_bytes_ = picture_bytes;
  }
  std::uint8_t* to = nullptr;
  image = pool_->take(layout, to);
  if (to == nullptr) {
    ++dropped_;
    return false;
  }
  unpack_pixels(sent, layout, to);
  return true;
}

}  // namespace sslv
