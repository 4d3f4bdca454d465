// SPDX-License-Identifier: Apache-2.0
#include "web/api.h"
#include "web/camera_feed.h"
#include "web/http.h"
#include "web/picture.h"
#include "web/picture_stream.h"

#include <algorithm>
#include <limits>

#include <httplib.h>

namespace sslv {
namespace {

constexpr int kMaxWidth = 16384;

PictureKind query_picture(const httplib::Request& request) {
  const std::string name = request.has_param("picture") ? request.get_param_value("picture") : "camera";
  for (const auto& choice : kPictureChoices) {
    if (choice.name == name) return choice.value;
  }
  throw HttpError(
      400, "picture: \"" + name.substr(0, 40) + "\" is not allowed; expected \"camera\" or \"labels\"");
}

std::uint32_t path_camera_id(const httplib::Request& request) {
  const int id = read_whole_number("camera", request.matches[1].str(), 0, std::numeric_limits<int>::max());
  return static_cast<std::uint32_t>(id);
}

}  // namespace

std::uint32_t path_camera(const WebHost& host, const httplib::Request& request) {
  const std::uint32_t id = path_camera_id(request);
  const std::vector<std::uint32_t> known = host.camera_ids();
  if (std::find(known.begin(), known.end(), id) == known.end()) {
    throw HttpError(404, "no camera " + std::to_string(id));
  }
  return id;
}

void set_picture(httplib::Response& response, const LentPicture& picture, const httplib::Request& request) {
  const int width = query_number(request, "width", kMaxWidth, 1, kMaxWidth);
  const int quality = query_number(request, "quality", 85, 1, 100);
  JpegEncoder encoder;
  const std::span<const std::uint8_t> jpeg = encoder.encode(picture.image, width, quality, Chroma::kHalved);
  response.set_content(reinterpret_cast<const char*>(jpeg.data()), jpeg.size(), "image/jpeg");
}

void get_snapshot(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  const std::uint32_t id = path_camera(host, request);
  const int width = query_number(request, "width", kMaxWidth, 1, kMaxWidth);
  const int quality = query_number(request, "quality", 85, 1, 100);
  const PictureKind wished = query_picture(request);
  const std::optional<View> view = host.wait_view(id, 0, std::chrono::milliseconds(0));
  if (!view) throw HttpError(503, "camera " + std::to_string(id) + " has no picture yet");
  std::vector<std::uint8_t> buffer;
  const Picture picture = picture_of(*view, wished, buffer);
  JpegEncoder encoder;
  const std::span<const std::uint8_t> jpeg = encoder.encode(picture.image, width, quality, picture.chroma);
  response.set_content(reinterpret_cast<const char*>(jpeg.data()), jpeg.size(), "image/jpeg");
}

StreamWish stream_wish(const httplib::Request& request) {
  StreamWish wish{path_camera_id(request), {}};
  PreviewWish& preview = wish.preview;
  preview.width = query_number(request, "width", preview.width, 1, kMaxWidth);
  preview.quality = query_number(request, "quality", preview.quality, 1, 100);
  if (request.has_param("fps"))
    preview.fps = read_number("fps", request.get_param_value("fps"), kMinFps, kMaxFps);
  preview.picture = query_picture(request);
  return wish;
}

void get_stream(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  path_camera(host, request);
  stream_wish(request);
  // Without a length: it ends with the connection.
  response.set_content_provider(kStreamType, [](std::size_t, httplib::DataSink& sink) {
    sink.done();
    return true;
  });
}

}  // namespace sslv
