// SPDX-License-Identifier: Apache-2.0
#include "support/media_writer.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libswscale/swscale.h>
}

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <stdexcept>

namespace sslv {
namespace {

struct Format {
  AVCodecID codec;
  AVPixelFormat pixels;
};

const std::map<std::string, Format> kFileFormats{
    {".png", {AV_CODEC_ID_PNG, AV_PIX_FMT_RGB24}},     {".bmp", {AV_CODEC_ID_BMP, AV_PIX_FMT_BGR24}},
    {".ppm", {AV_CODEC_ID_PPM, AV_PIX_FMT_RGB24}},     {".mkv", {AV_CODEC_ID_FFV1, AV_PIX_FMT_0RGB32}},
    {".mp4", {AV_CODEC_ID_MPEG4, AV_PIX_FMT_YUV420P}},
};

void check(int result, const char* what) {
  if (result >= 0) return;
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  av_strerror(result, text.data(), text.size());
  throw std::runtime_error(std::string(what) + ": " + text.data());
}

template <auto Free>
struct Freer {
  template <class T>
  void operator()(T* object) const {
    Free(&object);
  }
};

}  // namespace

void write_media(const std::string& path, const std::vector<RgbPicture>& pictures, int rate_hz) {
  const Format format = kFileFormats.at(std::filesystem::path(path).extension().string());
  AVFormatContext* opened = nullptr;
  check(avformat_alloc_output_context2(&opened, nullptr, nullptr, path.c_str()), "muxer");
  const std::unique_ptr<AVFormatContext, void (*)(AVFormatContext*)> muxer(opened, avformat_free_context);
  const AVCodec* codec = avcodec_find_encoder(format.codec);
  if (codec == nullptr) throw std::runtime_error("no encoder for " + path);
  const std::unique_ptr<AVCodecContext, Freer<avcodec_free_context>> encoder(avcodec_alloc_context3(codec));
  encoder->width = pictures.at(0).width;
  encoder->height = pictures.at(0).height;
  encoder->pix_fmt = format.pixels;
  encoder->time_base = {1, rate_hz};
  encoder->framerate = {rate_hz, 1};
  encoder->bit_rate = 4000000;
  if (muxer->oformat->flags & AVFMT_GLOBALHEADER) encoder->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  check(avcodec_open2(encoder.get(), codec, nullptr), "encoder");
  AVStream* stream = avformat_new_stream(muxer.get(), nullptr);
  stream->time_base = encoder->time_base;
  stream->avg_frame_rate = encoder->framerate;
  check(avcodec_parameters_from_context(stream->codecpar, encoder.get()), "parameters");
  if (!(muxer->oformat->flags & AVFMT_NOFILE))
    check(avio_open(&muxer->pb, path.c_str(), AVIO_FLAG_WRITE), "open");
  AVDictionary* options = nullptr;
  av_dict_set(&options, "update", "1", 0);  // a single image, whose name is no pattern
  const int begun = avformat_write_header(muxer.get(), &options);
  av_dict_free(&options);
  check(begun, "header");

  const std::unique_ptr<AVFrame, Freer<av_frame_free>> frame(av_frame_alloc());
  frame->width = encoder->width;
  frame->height = encoder->height;
  frame->format = encoder->pix_fmt;
  check(av_frame_get_buffer(frame.get(), 0), "frame");
  const std::unique_ptr<SwsContext, void (*)(SwsContext*)> converter(
      sws_getContext(frame->width, frame->height, AV_PIX_FMT_RGB24, frame->width, frame->height,
                     format.pixels, SWS_BILINEAR | SWS_ACCURATE_RND, nullptr, nullptr, nullptr),
      sws_freeContext);
  const std::unique_ptr<AVPacket, Freer<av_packet_free>> packet(av_packet_alloc());
  const auto drain = [&] {
    while (avcodec_receive_packet(encoder.get(), packet.get()) >= 0) {
      av_packet_rescale_ts(packet.get(), encoder->time_base, stream->time_base);
      packet->stream_index = 0;
      check(av_interleaved_write_frame(muxer.get(), packet.get()), "write");
    }
  };
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    check(av_frame_make_writable(frame.get()), "frame");
    const std::array<const std::uint8_t*, 1> rows{pictures[i].rgb.data()};
    const std::array<int, 1> strides{pictures[i].width * 3};
    sws_scale(converter.get(), rows.data(), strides.data(), 0, frame->height, frame->data, frame->linesize);
    frame->pts = static_cast<std::int64_t>(i);
    check(avcodec_send_frame(encoder.get(), frame.get()), "encode");
    drain();
  }
  check(avcodec_send_frame(encoder.get(), nullptr), "encode");
  drain();
  check(av_write_trailer(muxer.get()), "trailer");
  if (!(muxer->oformat->flags & AVFMT_NOFILE)) avio_closep(&muxer->pb);
}

}  // namespace sslv
