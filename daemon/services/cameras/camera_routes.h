// SPDX-License-Identifier: Apache-2.0
#pragma once

// Cameras over HTTP: docs/api.md.

#include "health/timeline.h"
#include "services/cameras/running_camera.h"
#include "services/event.h"
#include "web/route.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace sslv {

/// Objects that the routes use; all must outlive the routes.
struct CameraRoutes {
  ViewSource& views;
  const Timeline& timeline;
  std::function<std::shared_ptr<RunningCamera>(int id)> find;  // null: there is no such camera
  EventQueue& events;
};

std::vector<Route> camera_routes(const CameraRoutes& of);

/// Returns the camera id in the path, whether or not there is such a camera. Throws HttpError 400.
int path_camera_id(const Request& request);

/// Returns a JPEG of an image, with the width and quality in the query. Throws HttpError 400.
Response jpeg_response(const ImageView& image, const Request& request, Chroma chroma = Chroma::kHalved);

/// Returns the newest frame's image as a JPEG. Throws HttpError 503 if there is none.
std::string full_jpeg(const RunningCamera& camera);

}  // namespace sslv
