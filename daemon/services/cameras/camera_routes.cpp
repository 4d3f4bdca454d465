// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/camera_routes.h"

#include "base/log.h"
#include "capture/control_queue.h"
#include "capture/source.h"
#include "image/jpeg.h"
#include "services/cameras/camera_json.h"
#include "services/service.h"

#include <algorithm>
#include <chrono>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr int kMaxWidth_px = 16384;

PictureKind query_picture(const Request& request) {
  const auto found = request.query.find("picture");
  if (found == request.query.end()) return PictureKind::kCamera;
  for (const auto& choice : kPictureChoices) {
    if (choice.name == found->second) return choice.value;
  }
  throw HttpError(400, "picture: \"" + found->second.substr(0, 40) +
                           "\" is not allowed; expected \"camera\" or \"labels\"");
}

StreamWish stream_wish(const Request& request) {
  StreamWish wish{static_cast<std::uint32_t>(path_camera_id(request)), {}};
  PreviewWish& preview = wish.preview;
  preview.width = query_number(request, "width", preview.width, 1, kMaxWidth_px);
  preview.quality = query_number(request, "quality", preview.quality, 1, 100);
  if (const auto fps = request.query.find("fps"); fps != request.query.end())
    preview.fps = read_number("fps", fps->second, kMinFps, kMaxFps);
  preview.picture = query_picture(request);
  return wish;
}

/// Throws HttpError 404.
std::shared_ptr<RunningCamera> camera_of(const CameraRoutes& of, const Request& request) {
  const int id = path_camera_id(request);
  auto camera = of.find(id);
  if (!camera) throw HttpError(404, fmt::format("no camera {}", id));
  return camera;
}

Response get_snapshot(const CameraRoutes& of, const Request& request) {
  const int id = camera_of(of, request)->settings()->id;
  query_number(request, "width", kMaxWidth_px, 1, kMaxWidth_px);
  query_number(request, "quality", 85, 1, 100);
  const PictureKind wished = query_picture(request);
  const auto view = of.views.wait_view(static_cast<std::uint32_t>(id), 0, std::chrono::milliseconds(0));
  if (!view) throw HttpError(503, fmt::format("camera {} has no image yet", id));
  std::vector<std::uint8_t> buffer;
  const Picture picture = picture_of(*view, wished, buffer);
  return jpeg_response(picture.image, request, picture.chroma);
}

Response get_stream(const CameraRoutes& of, const Request& request) {
  camera_of(of, request);
  Response response{200, kStreamType, {}};
  response.stream = stream_wish(request);
  return response;
}

/// Queries an open camera. Throws HttpError 409 if the camera is not open or has no controls, 503 if it does
/// not answer.
template <class Ask>
auto ask_camera(const RunningCamera& camera, const Ask& ask) {
  const auto controls = camera.controls();
  if (!controls) {
    const bool is_open = camera.health().state == CameraState::kRunning;
    throw HttpError(
        409, fmt::format("camera {} {}", camera.settings()->id, is_open ? "has no controls" : "is not open"));
  }
  try {
    return ask(controls->queue());
  } catch (const CaptureError& error) {
    throw HttpError(503, error.what());
  } catch (const NeedsReopening& error) {
    throw HttpError(409, error.what());
  }
}

/// Lists controls, each with its saved value and whether the current value is unsaved.
Response list_response(const RunningCamera& camera, const std::vector<Control>& all) {
  const Json saved = camera.saved_controls();
  const std::vector<UnsavedControl> unsaved = camera.unsaved_controls();
  Json out = Json::array();
  for (const Control& control : all) out.push_back(control_json(control, saved, unsaved));
  return json_response({{"controls", std::move(out)}});
}

Response get_controls(const CameraRoutes& of, const Request& request) {
  const auto camera = camera_of(of, request);
  return list_response(*camera, ask_camera(*camera, [](ControlQueue& queue) { return queue.list(); }));
}

Response set_control(const CameraRoutes& of, const Request& request) {
  const auto camera = camera_of(of, request);
  const Json body = body_json(request);
  const bool is_fine = body.is_object() && (body.empty() || (body.size() == 1 && body.contains("value")));
  if (!is_fine) throw HttpError(400, R"(expected {"value": ...}, or nothing for an action)");
  const Json value = body.empty() ? Json(nullptr) : body.at("value");
  const std::string name = request.matches[2];
  const std::size_t before = camera->unsaved_controls().size();
  const Control now = ask_camera(*camera, [&](ControlQueue& queue) { return queue.set(name, value); });
  const int id = camera->settings()->id;
  log::info("camera {}: {} set to {} by {}, not saved", id, json_text(Json(name)), json_text(value),
            request.address);
  // One event for each control, not for each step of a slider.
  if (camera->unsaved_controls().size() > before)
    of.events.add(
        {"controls_set", fmt::format("Camera {}: {} was set and not saved", id, name), request.address, id});
  return json_response(control_json(now, camera->saved_controls(), camera->unsaved_controls()));
}

/// Answers without waiting for the camera; its status will show the result.
Response reopen_camera(const CameraRoutes& of, const Request& request) {
  const auto camera = camera_of(of, request);
  const int id = camera->settings()->id;
  switch (camera->try_now()) {
    case CameraState::kLost: break;
    case CameraState::kOpening: throw HttpError(409, fmt::format("camera {} is being opened", id));
    case CameraState::kRunning: throw HttpError(409, fmt::format("camera {} is open", id));
    case CameraState::kEnded: throw HttpError(409, fmt::format("the recording of camera {} has ended", id));
  }
  log::info("camera {}: {} asked to reopen it", id, request.address);
  of.events.add({"camera_reopen_asked", fmt::format("Asked to reopen camera {}", id), request.address, id});
  return json_response(camera_json(*camera));
}

/// Returns the controls that the body names; empty: all. Throws HttpError 400.
std::set<std::string> names_in(const Request& request) {
  std::set<std::string> names;
  const Json body = body_json(request);
  const bool has_names = body.is_object() && body.size() == 1 && body.contains("names") &&
                         body.at("names").is_array() && !body.at("names").empty();
  if (!has_names && body != Json::object())
    throw HttpError(400, R"(expected {"names": [...]}, or nothing for all)");
  if (!has_names) return names;
  for (const Json& name : body.at("names")) {
    if (!name.is_string()) throw HttpError(400, "names: expected texts");
    names.insert(name.get<std::string>());
  }
  return names;
}

Response revert_controls(const CameraRoutes& of, const Request& request) {
  const auto camera = camera_of(of, request);
  const std::size_t before = camera->unsaved_controls().size();
  const std::set<std::string> names = names_in(request);
  const Json saved = camera->saved_controls();
  const auto list = ask_camera(*camera, [&](ControlQueue& queue) { return queue.revert(names, saved); });
  const int id = camera->settings()->id;
  const std::size_t after = camera->unsaved_controls().size();
  if (after < before) {
    const std::size_t count = before - after;
    of.events.add(
        {"controls_reverted",
         fmt::format("Camera {}: {} unsaved control{} reverted", id, count, count == 1 ? " was" : "s were"),
         request.address, id});
  }
  return list_response(*camera, list);
}

Response get_field_view(const CameraRoutes& of, const Request& request) {
  return json_response(field_view_json(camera_of(of, request)->pipeline().setup()->context.field_view.get()));
}

Response get_cameras(const CameraRoutes& of) {
  Json out = Json::array();
  for (const std::uint32_t id : of.views.camera_ids()) {
    if (const auto camera = of.find(static_cast<int>(id))) {
      out.push_back(camera_json(*camera));
    }
  }
  return json_response(out);
}

}  // namespace

int path_camera_id(const Request& request) {
  return read_whole_number("camera", request.matches[1], 0, kMaxRouteNumber);
}

Response jpeg_response(const ImageView& image, const Request& request, Chroma chroma) {
  const int width = query_number(request, "width", kMaxWidth_px, 1, kMaxWidth_px);
  const int quality = query_number(request, "quality", 85, 1, 100);
  JpegEncoder encoder;
  return bytes_response(encoder.encode(image, width, quality, chroma), "image/jpeg");
}

std::string full_jpeg(const RunningCamera& camera) {
  const auto newest = camera.pipeline().finished().peek();
  if (!newest) throw HttpError(503, "no image yet");
  const ImageView image = newest->value->image.view();
  JpegEncoder encoder;
  const std::span<const std::uint8_t> jpeg = encoder.encode(image, image.width, 90, Chroma::kHalved);
  return {jpeg.begin(), jpeg.end()};
}

std::vector<Route> camera_routes(const CameraRoutes& of) {
  const auto about = [&of](Response (*handle)(const CameraRoutes&, const Request&)) -> Handler {
    return [of, handle](const Request& request) { return handle(of, request); };
  };
  return {
      {"GET", "/api/cameras", [of](const Request&) { return get_cameras(of); }},
      {"GET", R"(/api/cameras/(\d+)/snapshot\.jpg)", about(get_snapshot)},
      {"GET", R"(/api/cameras/(\d+)/stream\.mjpg)", about(get_stream), Needs::kByMethod, Speed::kMayWait,
       true},
      {"GET", R"(/api/cameras/(\d+)/controls)", about(get_controls)},
      {"POST", R"(/api/cameras/(\d+)/controls/([^/]+))", about(set_control)},
      // Allowed during a match, because a camera may be lost during a match.
      {"POST", R"(/api/cameras/(\d+)/reopen)", about(reopen_camera), Needs::kChange},
      {"POST", R"(/api/cameras/(\d+)/revert_controls)", about(revert_controls)},
      {"GET", R"(/api/cameras/(\d+)/field_view)", about(get_field_view)},
      {"GET", "/api/timeline",
       [of](const Request& request) {
         const int seconds = query_number(request, "seconds", 600, 1, 600);
         return json_response(of.timeline.to_json(static_cast<std::size_t>(seconds)));
       }},
  };
}

}  // namespace sslv
