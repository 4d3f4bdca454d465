// SPDX-License-Identifier: Apache-2.0
#include "web/api.h"
#include "web/http.h"
#include "web/picture.h"

#include <algorithm>
#include <limits>

#include <httplib.h>

namespace sslv {
namespace {

PictureKind query_picture(const httplib::Request& request) {
  const std::string name = request.has_param("picture") ? request.get_param_value("picture") : "camera";
  for (const auto& choice : kPictureChoices) {
    if (choice.name == name) return choice.value;
  }
  throw HttpError(
      400, "picture: \"" + name.substr(0, 40) + "\" is not allowed; expected \"camera\" or \"labels\"");
}

}  // namespace

std::uint32_t path_camera(const WebHost& host, const httplib::Request& request) {
  const int id = read_whole_number("camera", request.matches[1].str(), 0, std::numeric_limits<int>::max());
  const std::vector<std::uint32_t> known = host.camera_ids();
  if (std::find(known.begin(), known.end(), static_cast<std::uint32_t>(id)) == known.end()) {
    throw HttpError(404, "no camera " + std::to_string(id));
  }
  return static_cast<std::uint32_t>(id);
}

void get_snapshot(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  constexpr int kMaxWidth = 16384;
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

void get_lut(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  const std::uint32_t id = path_camera(host, request);
  const std::vector<std::uint8_t> file = host.lut_file(id);
  response.set_header("Content-Disposition",
                      "attachment; filename=\"camera-" + std::to_string(id) + ".lut\"");
  response.set_content(reinterpret_cast<const char*>(file.data()), file.size(), "application/octet-stream");
}

}  // namespace sslv
