// SPDX-License-Identifier: Apache-2.0
#include "services/sources/source_service.h"

#include "base/log.h"
#include "config/backends.h"
#include "config/config.h"
#include "services/sources/file_list.h"
#include "settings/named_files.h"

#include <algorithm>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr int kMaxImageWidth_px = 2048;

/// Whether only one program at a time can open this camera.
bool is_exclusive(const Json& source) {
  return source.at("backend") != "files" && source.at("backend") != "simulator";
}

const std::string& query_text(const Request& request, const std::string& name) {
  static const std::string kNone;
  const auto found = request.query.find(name);
  return found == request.query.end() ? kNone : found->second;
}

}  // namespace

SourceService::SourceService(StateFolder& folder, SettingsEditor& settings, const Cameras& cameras,
                             std::vector<std::filesystem::path> file_folders)
    : settings_(settings), cameras_(cameras), file_folders_(std::move(file_folders)), uploaded_(folder) {}

std::vector<Route> SourceService::routes() {
  return {
      {"GET", "/api/sources", [this](const Request&) { return get_sources(); }},
      {"POST", "/api/sources/image", [this](const Request& request) { return take_image(request); }},
      {"GET", "/api/files", [this](const Request& request) { return get_files(request); }, Needs::kChange},
      {"GET", "/api/images", [this](const Request&) { return get_images(); }},
      {"POST", "/api/images", [this](const Request& request) { return upload_image(request); },
       Needs::kByMethod, Speed::kMayWait, false, UploadedImages::kMaxImageBytes},
      {"DELETE", "/api/images/([^/]+)", [this](const Request& request) { return remove_images(request); }},
  };
}

std::optional<int> SourceService::user_of(const Json& source, std::span<const FoundCamera> found) const {
  const std::vector<std::string> names = names_of_camera(source, found);
  for (const CameraNow& camera : cameras_.all()) {
    const Json& used = camera_source(camera.settings->source);
    if (used.at("backend") != source.at("backend")) continue;
    for (const std::string& name : names_of_camera(used, found)) {
      if (std::ranges::find(names, name) != names.end()) return camera.id;
    }
  }
  return std::nullopt;
}

std::vector<FoundCamera> SourceService::found_with(const Json& source) {
  const std::string name = source.value("camera", "");
  {
    const std::lock_guard lock(found_mutex_);
    if (!name.empty() && names_of_camera(source, found_).size() > 1) return found_;
  }
  std::vector<FoundCamera> found = found_cameras();
  const std::lock_guard lock(found_mutex_);
  found_ = found;
  return found;
}

Response SourceService::get_sources() {
  Json out = Json::array();
  const std::vector<FoundCamera> all = found_cameras();
  {
    const std::lock_guard lock(found_mutex_);
    found_ = all;
  }
  for (const FoundCamera& found : all) {
    Json& one = out.emplace_back(found_camera_json(found));
    const auto user = user_of(found.source, all);
    one["camera"] = user ? Json(*user) : Json(nullptr);
  }
  return json_response({{"sources", std::move(out)}});
}

Json SourceService::allowed_source(const Json& source) const {
  if (!source.is_object()) throw SettingsError("/source: is missing; expected a camera's source");
  Json complete = complete_source(source, "/source");
  static const Json kSchema = settings_schema();
  check_named_files(kSchema, {{"cameras", {{{"source", complete}}}}}, {settings_.current().settings},
                    file_folders_);
  complete.erase("controls");
  if (complete.at("backend") == "tile") complete.at("of").erase("controls");
  return complete;
}

Response SourceService::take_image(const Request& request) {
  const int width = query_number(request, "width", 640, 1, kMaxImageWidth_px);
  const Json body = body_json(request);
  if (!body.is_object() || body.size() != 1 || !body.contains("source"))
    throw HttpError(400, R"(expected {"source": {...}})");
  const Json source = allowed_source(body.at("source"));
  if (const Json& camera = camera_source(source); is_exclusive(camera)) {
    if (const auto user = user_of(camera, found_with(camera)))
      throw HttpError(409, fmt::format("camera {} of this service is using it", *user));
  }
  Scene scene;
  scene.field = settings_.current().config->field;
  try {
    return bytes_response(source_images_.take(source, scene, width), "image/jpeg");
  } catch (const CaptureError& error) {
    throw HttpError(503, error.what());
  }
}

Response SourceService::get_files(const Request& request) const {
  return json_response(list_files(query_text(request, "folder"), file_folders_));
}

Response SourceService::get_images() const {
  Json folders = Json::array();
  for (const UploadedImages::Folder& folder : uploaded_.folders()) {
    folders.push_back({{"name", folder.name},
                       {"path", folder.path.string()},
                       {"images", folder.images},
                       {"bytes", folder.bytes}});
  }
  return json_response({{"folders", std::move(folders)},
                        {"max_image_bytes", UploadedImages::kMaxImageBytes},
                        {"max_images", UploadedImages::kMaxImages},
                        {"max_folders", UploadedImages::kMaxFolders},
                        {"max_bytes", UploadedImages::kMaxBytes}});
}

Response SourceService::upload_image(const Request& request) {
  const auto path = uploaded_.save(query_text(request, "folder"), query_text(request, "name"), request.body);
  return json_response({{"path", path.string()}});
}

Response SourceService::remove_images(const Request& request) {
  const std::string& name = request.matches[1];
  const std::filesystem::path path = uploaded_.path_of(name);
  const Json settings = settings_.current().settings;
  static const Json kSchema = settings_schema();
  for (const NamedFile& one : named_files(kSchema, settings)) {
    if (lies_in(one.file, path))
      throw HttpError(409, fmt::format("{} names these images; remove that camera first", one.path));
  }
  if (!uploaded_.remove(name)) throw HttpError(404, fmt::format("no folder of images \"{}\"", name));
  log::info("folder of images \"{}\" removed by {}", name, request.address);
  return json_response(Json::object());
}

}  // namespace sslv
