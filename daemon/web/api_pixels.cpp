// SPDX-License-Identifier: Apache-2.0
#include "web/api.h"
#include "web/http.h"

#include <limits>

#include <httplib.h>

namespace sslv {
namespace {

constexpr int kMaxNumber = std::numeric_limits<int>::max();
constexpr int kMaxSide = 16384;

int path_still(const httplib::Request& request) {
  return read_whole_number("still", request.matches[2].str(), 0, kMaxNumber);
}

}  // namespace

void get_pixels(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  const std::uint32_t id = path_camera(host, request);
  PixelWish wish;
  wish.x = query_number(request, "x", 0, -kMaxSide, kMaxSide);
  wish.y = query_number(request, "y", 0, -kMaxSide, kMaxSide);
  wish.width = query_number(request, "width", 1, 1, kMaxSide);
  wish.height = query_number(request, "height", 1, 1, kMaxSide);
  if (request.has_param("region")) {
    const std::string region = request.get_param_value("region");
    if (region != "true" && region != "false")
      throw HttpError(400, "region: \"" + region.substr(0, 40) + "\" is not allowed; expected true or false");
    wish.region = region == "true";
  }
  if (request.has_param("still")) wish.still = query_number(request, "still", 0, 0, kMaxNumber);
  set_json(response, host.colors.pixels(id, wish));
}

void take_still(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  set_json(response, host.colors.take_still(path_camera(host, request)));
  response.status = 201;
}

void get_still_picture(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  const std::uint32_t id = path_camera(host, request);
  set_picture(response, host.colors.still_picture(id, path_still(request)), request);
}

void get_still_labels(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  const std::uint32_t id = path_camera(host, request);
  const std::vector<std::uint8_t> labels = host.colors.still_labels(id, path_still(request));
  response.set_content(reinterpret_cast<const char*>(labels.data()), labels.size(),
                       "application/octet-stream");
}

}  // namespace sslv
