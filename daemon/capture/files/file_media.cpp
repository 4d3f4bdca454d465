// SPDX-License-Identifier: Apache-2.0
#include "capture/files/file_media.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/imgutils.h>
#include <libswscale/swscale.h>
}

#include <algorithm>
#include <array>
#include <cstdint>
#include <mutex>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

namespace sslv {
namespace {

std::string reason_of(int error) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  av_strerror(error, text.data(), text.size());
  return text.data();
}

void check(int result, const char* what) {
  if (result < 0) throw std::runtime_error(std::string(what) + ": " + reason_of(result));
}

template <class T>
T* allocated(T* object) {
  if (object == nullptr) throw std::bad_alloc();
  return object;
}

/// The deprecated "J" formats imply full range, which swscale needs as a separate setting.
AVPixelFormat without_range(AVPixelFormat format) {
  switch (format) {
    case AV_PIX_FMT_YUVJ411P: return AV_PIX_FMT_YUV411P;
    case AV_PIX_FMT_YUVJ420P: return AV_PIX_FMT_YUV420P;
    case AV_PIX_FMT_YUVJ422P: return AV_PIX_FMT_YUV422P;
    case AV_PIX_FMT_YUVJ440P: return AV_PIX_FMT_YUV440P;
    case AV_PIX_FMT_YUVJ444P: return AV_PIX_FMT_YUV444P;
    default: return format;
  }
}

}  // namespace

struct MediaReader::Libraries {
  AVFormatContext* container = nullptr;
  AVCodecContext* decoder = nullptr;
  AVPacket* packet = allocated(av_packet_alloc());
  AVFrame* frame = allocated(av_frame_alloc());
  SwsContext* converter = nullptr;
  int stream = 0;
  std::vector<std::int64_t> times;  // times of all images, ascending; filled by read_times()
  bool is_reading_times = false, has_times = false;
  std::int64_t skip_before = AV_NOPTS_VALUE;  // skip images before this time, after a seek
  bool draining = false;                      // end of file reached; the decoder may still hold images

  Libraries() = default;
  Libraries(const Libraries&) = delete;
  Libraries& operator=(const Libraries&) = delete;
  ~Libraries() {
    sws_freeContext(converter);
    av_frame_free(&frame);
    av_packet_free(&packet);
    avcodec_free_context(&decoder);
    avformat_close_input(&container);
  }

  void feed();
  bool read_times(Clock::time_point until);
  void convert(std::uint8_t* rgb);
};

MediaReader::MediaReader(const std::string& path, bool still) : av_(std::make_unique<Libraries>()) {
  // Errors reach the admin as our own messages, not as the libraries' output.
  static std::once_flag quiet;
  std::call_once(quiet, [] { av_log_set_level(AV_LOG_QUIET); });

  // The name is one local file, neither a pattern nor a URL.
  AVDictionary* options = nullptr;
  av_dict_set(&options, "pattern_type", "none", 0);
  av_dict_set(&options, "protocol_whitelist", "file", 0);
  const int opened = avformat_open_input(&av_->container, ("file:" + path).c_str(), nullptr, &options);
  av_dict_free(&options);
  check(opened, "cannot be opened");
  check(avformat_find_stream_info(av_->container, nullptr), "cannot be read");
  const AVCodec* codec = nullptr;
  av_->stream = av_find_best_stream(av_->container, AVMEDIA_TYPE_VIDEO, -1, -1, &codec, 0);
  check(av_->stream, "no images in it");

  av_->decoder = allocated(avcodec_alloc_context3(codec));
  check(avcodec_parameters_to_context(av_->decoder, av_->container->streams[av_->stream]->codecpar),
        "cannot be decoded");
  constexpr std::int64_t kMaxPixels = 16384LL * 16384;
  av_->decoder->max_pixels = kMaxPixels;
  if (still) av_->decoder->err_recognition = AV_EF_CRCCHECK | AV_EF_BITSTREAM | AV_EF_BUFFER | AV_EF_EXPLODE;
  check(avcodec_open2(av_->decoder, codec, nullptr), "cannot be decoded");
}

MediaReader::~MediaReader() = default;

double MediaReader::frame_rate_hz() const {
  const AVRational rate = av_guess_frame_rate(av_->container, av_->container->streams[av_->stream], nullptr);
  return rate.num > 0 && rate.den > 0 ? av_q2d(rate) : 0;
}

std::int64_t MediaReader::count() const {
  const AVStream& stream = *av_->container->streams[av_->stream];
  if (stream.nb_frames > 0) return stream.nb_frames;
  const double length_s = static_cast<double>(av_->container->duration) / AV_TIME_BASE;
  return length_s > 0 ? static_cast<std::int64_t>(length_s * frame_rate_hz() + 0.5) : 0;
}

std::optional<double> MediaReader::time_s() const {
  const std::int64_t time = av_->frame->best_effort_timestamp;
  if (time == AV_NOPTS_VALUE) return std::nullopt;
  return static_cast<double>(time) * av_q2d(av_->container->streams[av_->stream]->time_base);
}

bool MediaReader::seek(std::int64_t picture, Clock::time_point until) {
  if (!av_->read_times(until)) return false;
  if (picture < 0 || picture >= static_cast<std::int64_t>(av_->times.size()))
    throw std::runtime_error("it has only " + std::to_string(av_->times.size()) + " images");
  const std::int64_t time = av_->times[static_cast<std::size_t>(picture)];
  check(av_seek_frame(av_->container, av_->stream, time, AVSEEK_FLAG_BACKWARD), "cannot be searched");
  avcodec_flush_buffers(av_->decoder);
  av_->draining = false;
  av_->skip_before = time;
  return true;
}

/// Reads the times of all images and sorts them, because packets are stored in decoding order. False if not
/// all times were read by `until`; the next call continues.
bool MediaReader::Libraries::read_times(Clock::time_point until) {
  constexpr std::size_t kMaxPictures = 4'000'000;  // five hours at 200 Hz
  if (has_times) return true;
  if (!is_reading_times)
    check(av_seek_frame(container, stream, 0, AVSEEK_FLAG_BACKWARD), "cannot be searched");
  is_reading_times = true;
  do {
    if (av_read_frame(container, packet) < 0) {
      std::sort(times.begin(), times.end());
      has_times = true;
      return true;
    }
    const std::int64_t time = packet->pts != AV_NOPTS_VALUE ? packet->pts : packet->dts;
    if (packet->stream_index == stream && time != AV_NOPTS_VALUE) times.push_back(time);
    av_packet_unref(packet);
    if (times.size() > kMaxPictures) throw std::runtime_error("it has too many images to be searched");
  } while (Clock::now() < until);
  return false;
}

/// Passes the next packet to the decoder, or signals the end of the file. Throws std::runtime_error for a
/// packet that the decoder rejects.
void MediaReader::Libraries::feed() {
  for (;;) {
    const int read = av_read_frame(container, packet);
    if (read < 0) {
      draining = true;
      avcodec_send_packet(decoder, nullptr);
      if (read != AVERROR_EOF) check(read, "cannot be read any further");
      return;
    }
    const bool ours = packet->stream_index == stream;
    const int sent = ours ? avcodec_send_packet(decoder, packet) : 0;
    av_packet_unref(packet);
    check(sent, "damaged");
    if (ours) return;
  }
}

void MediaReader::Libraries::convert(std::uint8_t* rgb) {
  const auto given = static_cast<AVPixelFormat>(frame->format);
  const AVPixelFormat format = without_range(given);
  converter = sws_getCachedContext(
      converter, frame->width, frame->height, format, frame->width, frame->height, AV_PIX_FMT_RGB24,
      SWS_BILINEAR | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT, nullptr, nullptr, nullptr);
  if (converter == nullptr) throw std::runtime_error("its pixels cannot be converted to rgb24");
  const int full_range = format != given || frame->color_range == AVCOL_RANGE_JPEG;
  const int colorspace = frame->colorspace == AVCOL_SPC_UNSPECIFIED ? SWS_CS_DEFAULT : frame->colorspace;
  sws_setColorspaceDetails(converter, sws_getCoefficients(colorspace), full_range,
                           sws_getCoefficients(SWS_CS_DEFAULT), 1, 0, 1 << 16, 1 << 16);
  const std::array<std::uint8_t*, 4> planes{rgb, nullptr, nullptr, nullptr};
  const std::array<int, 4> strides{frame->width * 3, 0, 0, 0};
  check(sws_scale(converter, frame->data, frame->linesize, 0, frame->height, planes.data(), strides.data()),
        "damaged");
}

MediaReader::Result MediaReader::read(PicturePool& pool, Image& image, std::string& problem,
                                      Clock::time_point until) {
  try {
    for (;;) {
      const int received = avcodec_receive_frame(av_->decoder, av_->frame);
      if (received == AVERROR_EOF) return Result::kEnd;
      const bool is_late = av_->skip_before != AV_NOPTS_VALUE && Clock::now() >= until;
      if (received == AVERROR(EAGAIN)) {
        av_->feed();
        if (is_late) return Result::kSearching;
        continue;
      }
      check(received, "damaged");
      const bool is_on_the_way = av_->skip_before != AV_NOPTS_VALUE &&
                                 av_->frame->best_effort_timestamp != AV_NOPTS_VALUE &&
                                 av_->frame->best_effort_timestamp < av_->skip_before;
      if (is_on_the_way && is_late) return Result::kSearching;
      if (is_on_the_way) continue;
      av_->skip_before = AV_NOPTS_VALUE;
      if (av_->frame->decode_error_flags != 0 || (av_->frame->flags & AV_FRAME_FLAG_CORRUPT) != 0) {
        throw std::runtime_error("damaged");
      }
      if (!is_valid_size(PixelFormat::kRgb24, av_->frame->width, av_->frame->height)) {
        throw std::runtime_error("its size is not 2 .. 16384 pixels a side");
      }
      std::uint8_t* pixels = nullptr;
      Image taken = pool.take(PixelFormat::kRgb24, av_->frame->width, av_->frame->height, pixels);
      av_->convert(pixels);
      image = std::move(taken);
      return Result::kPicture;
    }
  } catch (const std::exception& error) {
    problem = error.what();
    return Result::kDamaged;
  }
}

}  // namespace sslv
