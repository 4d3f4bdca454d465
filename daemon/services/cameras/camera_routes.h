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

/// What the routes are about; all outlive them.
struct CameraRoutes {
  ViewSource& views;
  const Timeline& timeline;
  std::function<std::shared_ptr<RunningCamera>(int id)> find;  // null: there is no such camera
  EventQueue& events;
};

std::vector<Route> camera_routes(const CameraRoutes& of);

/// The id of a camera in the path, whether or not there is one. Throws HttpError 400.
int path_camera_id(const Request& request);

/// A JPEG of an image, of the width and quality that the query asks for. Throws HttpError 400.
Response jpeg_response(const ImageView& image, const Request& request, Chroma chroma = Chroma::kHalved);

/// The newest frame's image. Throws HttpError 503 when there is none.
std::string full_jpeg(const RunningCamera& camera);

}  // namespace sslv
