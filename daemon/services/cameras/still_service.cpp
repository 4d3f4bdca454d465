// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/still_service.h"

#include "colors/pixel_figures.h"
#include "colors/pixels_json.h"
#include "services/cameras/camera_routes.h"
#include "vision/label_image.h"

#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr int kMaxSide_px = 16384;

int path_still(const Request& request) {
  return read_whole_number("still", request.matches[2], 0, kMaxRouteNumber);
}

}  // namespace

LentPicture StillService::look(int camera_id, std::optional<int> still) {
  if (still) {
    const auto picture = stills_.find(camera_id, *still);
    if (!picture) {
      throw HttpError(404, fmt::format("camera {} has no still {}; it may have expired. Take a new one",
                                       camera_id, *still));
    }
    return {picture, picture->view, picture->frame_number, picture->t_capture_s};
  }
  cameras_.get(camera_id);
  auto frame = cameras_.wait_frame(camera_id, 0, std::chrono::milliseconds(0));
  if (!frame) throw HttpError(503, fmt::format("camera {} has no image yet", camera_id));
  return {std::move(frame->hold), frame->image, frame->number, frame->t_capture_s};
}

std::vector<Route> StillService::routes() {
  const auto call = [this](Response (StillService::*handle)(const Request&)) -> Handler {
    return [this, handle](const Request& request) { return (this->*handle)(request); };
  };
  return {
      {"GET", R"(/api/cameras/(\d+)/pixels)", call(&StillService::get_pixels)},
      {"POST", R"(/api/cameras/(\d+)/stills)", call(&StillService::take_still), Needs::kChange},
      {"GET", R"(/api/cameras/(\d+)/stills/(\d+)/picture\.jpg)", call(&StillService::get_picture)},
      {"GET", R"(/api/cameras/(\d+)/stills/(\d+)/labels)", call(&StillService::get_labels)},
  };
}

Response StillService::get_pixels(const Request& request) {
  constexpr int kRegionReach_px = 200;
  const CameraNow camera = cameras_.get(path_camera_id(request));
  const int x = query_number(request, "x", 0, -kMaxSide_px, kMaxSide_px);
  const int y = query_number(request, "y", 0, -kMaxSide_px, kMaxSide_px);
  const int width = query_number(request, "width", 1, 1, kMaxSide_px);
  const int height = query_number(request, "height", 1, 1, kMaxSide_px);
  const bool of_region = query_flag(request, "region");
  std::optional<int> still;
  if (request.query.contains("still")) still = query_number(request, "still", 0, 0, kMaxRouteNumber);

  const LentPicture looked = look(camera.id, still);
  PixelBox box{x, y, width, height};
  const int middle_x = x + width / 2, middle_y = y + height / 2;
  if (of_region)
    box = {middle_x - kRegionReach_px, middle_y - kRegionReach_px, 2 * kRegionReach_px, 2 * kRegionReach_px};
  PixelBlock block = read_pixels(looked.image, box, *camera.context().adapted_lut);
  const PixelFigures figures =
      figures_of(block, of_region ? region_around(block, middle_x, middle_y) : std::vector<bool>{});
  return json_response(pixels_json(block, figures, looked.frame_number, *camera.context().labels));
}

Response StillService::take_still(const Request& request) {
  const int camera_id = cameras_.get(path_camera_id(request)).id;
  const LentPicture looked = look(camera_id, {});
  const int still =
      stills_.keep(camera_id, StillPicture(looked.image, looked.frame_number, looked.t_capture_s));
  return json_response({{"still", still},
                        {"frame", looked.frame_number},
                        {"t_capture", looked.t_capture_s},
                        {"width", looked.image.width},
                        {"height", looked.image.height}},
                       201);
}

Response StillService::get_picture(const Request& request) {
  const int camera_id = cameras_.get(path_camera_id(request)).id;
  return jpeg_response(look(camera_id, path_still(request)).image, request);
}

Response StillService::get_labels(const Request& request) {
  const CameraNow camera = cameras_.get(path_camera_id(request));
  const LentPicture looked = look(camera.id, path_still(request));
  return bytes_response(
      label_image_bytes(looked.image, *camera.context().adapted_lut, camera.context().looked_at()));
}

}  // namespace sslv
