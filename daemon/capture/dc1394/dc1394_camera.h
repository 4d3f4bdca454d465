// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <dc1394/dc1394.h>

namespace sslv::iidc {

struct FreeContext {
  void operator()(dc1394_t* context) const { dc1394_free(context); }
};
struct FreeCamera {
  void operator()(dc1394camera_t* camera) const { dc1394_camera_free(camera); }
};
using Context = std::unique_ptr<dc1394_t, FreeContext>;

/// An open camera that does not send and has no memory for images yet.
struct Handle {
  Context context;
  std::unique_ptr<dc1394camera_t, FreeCamera> camera;  // destroyed before its context
};

/// The GUID as 16 hexadecimal digits.
std::string text_of(std::uint64_t guid);
/// Parses up to 16 hexadecimal digits, with or without "0x".
std::optional<std::uint64_t> guid_of(std::string_view text);

/// GUIDs of the existing cameras, in the library's order; empty if `context` is null. Needs no root, but
/// finds only cameras that the user may open. Takes a few milliseconds.
std::vector<std::uint64_t> find_cameras(const Context& context);
/// Creates a context; redirects the library's messages to our log.
Context new_context();

/// Opens the camera with this GUID, or the first camera if the text is empty. Throws CaptureError that lists
/// the existing cameras.
Handle open_camera(const std::string& guid);

/// Throws CaptureError `camera "LABEL": WHAT: REASON` if a call failed.
void check(dc1394error_t error, std::string_view label, std::string_view what);

template <class T>
struct Named {
  std::string_view name;
  T value;
};

inline constexpr std::array kModes{
    Named<dc1394video_mode_t>{"160x120_yuv444", DC1394_VIDEO_MODE_160x120_YUV444},
    Named<dc1394video_mode_t>{"320x240_yuv422", DC1394_VIDEO_MODE_320x240_YUV422},
    Named<dc1394video_mode_t>{"640x480_yuv411", DC1394_VIDEO_MODE_640x480_YUV411},
    Named<dc1394video_mode_t>{"640x480_yuv422", DC1394_VIDEO_MODE_640x480_YUV422},
    Named<dc1394video_mode_t>{"640x480_rgb8", DC1394_VIDEO_MODE_640x480_RGB8},
    Named<dc1394video_mode_t>{"640x480_mono8", DC1394_VIDEO_MODE_640x480_MONO8},
    Named<dc1394video_mode_t>{"640x480_mono16", DC1394_VIDEO_MODE_640x480_MONO16},
    Named<dc1394video_mode_t>{"800x600_yuv422", DC1394_VIDEO_MODE_800x600_YUV422},
    Named<dc1394video_mode_t>{"800x600_rgb8", DC1394_VIDEO_MODE_800x600_RGB8},
    Named<dc1394video_mode_t>{"800x600_mono8", DC1394_VIDEO_MODE_800x600_MONO8},
    Named<dc1394video_mode_t>{"1024x768_yuv422", DC1394_VIDEO_MODE_1024x768_YUV422},
    Named<dc1394video_mode_t>{"1024x768_rgb8", DC1394_VIDEO_MODE_1024x768_RGB8},
    Named<dc1394video_mode_t>{"1024x768_mono8", DC1394_VIDEO_MODE_1024x768_MONO8},
    Named<dc1394video_mode_t>{"800x600_mono16", DC1394_VIDEO_MODE_800x600_MONO16},
    Named<dc1394video_mode_t>{"1024x768_mono16", DC1394_VIDEO_MODE_1024x768_MONO16},
    Named<dc1394video_mode_t>{"1280x960_yuv422", DC1394_VIDEO_MODE_1280x960_YUV422},
    Named<dc1394video_mode_t>{"1280x960_rgb8", DC1394_VIDEO_MODE_1280x960_RGB8},
    Named<dc1394video_mode_t>{"1280x960_mono8", DC1394_VIDEO_MODE_1280x960_MONO8},
    Named<dc1394video_mode_t>{"1600x1200_yuv422", DC1394_VIDEO_MODE_1600x1200_YUV422},
    Named<dc1394video_mode_t>{"1600x1200_rgb8", DC1394_VIDEO_MODE_1600x1200_RGB8},
    Named<dc1394video_mode_t>{"1600x1200_mono8", DC1394_VIDEO_MODE_1600x1200_MONO8},
    Named<dc1394video_mode_t>{"1280x960_mono16", DC1394_VIDEO_MODE_1280x960_MONO16},
    Named<dc1394video_mode_t>{"1600x1200_mono16", DC1394_VIDEO_MODE_1600x1200_MONO16},
    Named<dc1394video_mode_t>{"format7_0", DC1394_VIDEO_MODE_FORMAT7_0},
    Named<dc1394video_mode_t>{"format7_1", DC1394_VIDEO_MODE_FORMAT7_1},
    Named<dc1394video_mode_t>{"format7_2", DC1394_VIDEO_MODE_FORMAT7_2},
    Named<dc1394video_mode_t>{"format7_3", DC1394_VIDEO_MODE_FORMAT7_3},
    Named<dc1394video_mode_t>{"format7_4", DC1394_VIDEO_MODE_FORMAT7_4},
    Named<dc1394video_mode_t>{"format7_5", DC1394_VIDEO_MODE_FORMAT7_5},
    Named<dc1394video_mode_t>{"format7_6", DC1394_VIDEO_MODE_FORMAT7_6},
    Named<dc1394video_mode_t>{"format7_7", DC1394_VIDEO_MODE_FORMAT7_7},
};

/// The supported codings, best first.
inline constexpr std::array kCodings{
    Named<dc1394color_coding_t>{"yuv422", DC1394_COLOR_CODING_YUV422},
    Named<dc1394color_coding_t>{"raw8", DC1394_COLOR_CODING_RAW8},
    Named<dc1394color_coding_t>{"rgb8", DC1394_COLOR_CODING_RGB8},
    Named<dc1394color_coding_t>{"yuv411", DC1394_COLOR_CODING_YUV411},
    Named<dc1394color_coding_t>{"yuv444", DC1394_COLOR_CODING_YUV444},
    Named<dc1394color_coding_t>{"mono8", DC1394_COLOR_CODING_MONO8},
    Named<dc1394color_coding_t>{"raw16", DC1394_COLOR_CODING_RAW16},
    Named<dc1394color_coding_t>{"mono16", DC1394_COLOR_CODING_MONO16},
};

inline constexpr std::array kBayerOrders{
    Named<dc1394color_filter_t>{"rggb", DC1394_COLOR_FILTER_RGGB},
    Named<dc1394color_filter_t>{"gbrg", DC1394_COLOR_FILTER_GBRG},
    Named<dc1394color_filter_t>{"grbg", DC1394_COLOR_FILTER_GRBG},
    Named<dc1394color_filter_t>{"bggr", DC1394_COLOR_FILTER_BGGR},
};

/// Bus speeds in Mbit/s, named like the bus's S-numbers (S400: "400").
inline constexpr std::array kSpeeds{
    Named<dc1394speed_t>{"100", DC1394_ISO_SPEED_100},   Named<dc1394speed_t>{"200", DC1394_ISO_SPEED_200},
    Named<dc1394speed_t>{"400", DC1394_ISO_SPEED_400},   Named<dc1394speed_t>{"800", DC1394_ISO_SPEED_800},
    Named<dc1394speed_t>{"1600", DC1394_ISO_SPEED_1600}, Named<dc1394speed_t>{"3200", DC1394_ISO_SPEED_3200},
};

template <class Table, class T>
constexpr std::string_view name_in(const Table& table, T value) {
  for (const auto& row : table) {
    if (row.value == value) return row.name;
  }
  return "unknown";
}

constexpr bool is_format7(dc1394video_mode_t mode) {
  return mode >= DC1394_VIDEO_MODE_FORMAT7_MIN;
}

/// Modes with a supported coding. Throws CaptureError.
std::vector<dc1394video_mode_t> modes_of(dc1394camera_t* camera, std::string_view label);
/// Supported codings of a mode, best first. Throws CaptureError.
std::vector<dc1394color_coding_t> codings_of(dc1394camera_t* camera, dc1394video_mode_t mode,
                                             std::string_view label);

}  // namespace sslv::iidc
