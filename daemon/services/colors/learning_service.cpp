// SPDX-License-Identifier: Apache-2.0
#include "services/colors/learning_service.h"

#include "base/clock.h"
#include "base/log.h"
#include "colors/pixel_figures.h"
#include "services/cameras/camera_routes.h"
#include "services/colors/color_commands.h"
#include "services/colors/colors_json.h"
#include "vision/label_image.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace sslv {

LearningService::LearningService(Cameras& cameras, Pictures& pictures, ColorTables& tables,
                                 ColorService& colors)
    : cameras_(cameras),
      pictures_(pictures),
      tables_(tables),
      colors_(colors),
      jobs_(make_color_learning(frames_of(cameras))) {
  cameras.add_observer(*this);
}

void LearningService::cameras_changed(const std::set<int>& camera_ids) noexcept {
  invalidate(jobs_, camera_ids);
}

std::vector<Route> LearningService::routes() {
  const auto call = [this](Response (LearningService::*handle)(const Request&)) -> Handler {
    return [this, handle](const Request& request) {
      cameras_.get(path_camera_id(request));
      return (this->*handle)(request);
    };
  };
  return {
      {"GET", R"(/api/cameras/(\d+)/colors/learning)",
       [this](const Request& request) { return json_response(state_json(path_camera_id(request))); }},
      {"POST", R"(/api/cameras/(\d+)/colors/learning)", call(&LearningService::start)},
      {"DELETE", R"(/api/cameras/(\d+)/colors/learning)", call(&LearningService::cancel), Needs::kChange},
      {"POST", R"(/api/cameras/(\d+)/colors/learning/accept)", call(&LearningService::accept)},
      {"POST", R"(/api/cameras/(\d+)/colors/learning/reject)", call(&LearningService::reject),
       Needs::kChange},
      {"GET", R"(/api/cameras/(\d+)/colors/learning/pictures/(\d+))", call(&LearningService::get_picture)},
  };
}

Json LearningService::state_json(int camera_id) const {
  const CameraNow camera = cameras_.get(camera_id);
  return learning_json(camera_id, jobs_.job(camera_id), *camera.context().labels);
}

Response LearningService::start(const Request& request) {
  const CameraNow camera = cameras_.get(path_camera_id(request));
  const LearningRequest wanted = read_learning_request(body_json(request));
  LearningOrder order{wanted.frames, {}, *camera.settings, camera.context(), request.address, unix_time_s()};
  for (std::size_t i = 0; i < wanted.guide.size(); ++i) {
    const LearningClick& click = wanted.guide[i];
    const std::string path = fmt::format("/guide/{}", i);
    const Label label = find_label(*order.context.labels, click.label, path + "/label");
    const LentPicture looked = pictures_.look(camera.id, click.still);
    const PixelFigures figures =
        figures_of(read_pixels(looked.image, {click.x - 1, click.y - 1, 3, 3}, *order.context.adapted_lut));
    if (figures.count == 0) throw SettingsError(path + ": lies outside the image");
    const auto byte = [](double value) { return static_cast<std::uint8_t>(std::lround(value)); };
    order.guide.push_back(
        {label, to_rgb({byte(figures.mean[0]), byte(figures.mean[1]), byte(figures.mean[2])})});
  }
  if (!jobs_.start(camera.id, std::move(order)))
    throw HttpError(409,
                    fmt::format("camera {} is learning its colours already; cancel that first", camera.id));
  log::info("camera {}: learning of colours started by {}", camera.id, request.address);
  return json_response(state_json(camera.id), 202);
}

std::shared_ptr<const LearningReport> LearningService::report_of(int camera_id) const {
  auto report = jobs_.job(camera_id).report;
  if (!report) throw HttpError(409, fmt::format("camera {} has no finished learning", camera_id));
  return report;
}

std::shared_ptr<const Lut> LearningService::learnt_table(int camera_id) const {
  const auto report = jobs_.job(camera_id).report;
  return report ? report->learnt.lut : nullptr;
}

Response LearningService::cancel(const Request& request) {
  const int camera_id = path_camera_id(request);
  if (!jobs_.cancel(camera_id))
    throw HttpError(409, fmt::format("camera {} is not learning its colours", camera_id));
  return json_response(state_json(camera_id));
}

Response LearningService::reject(const Request& request) {
  const int camera_id = path_camera_id(request);
  const auto job = jobs_.job(camera_id);
  if (!job.order || !jobs_.forget(camera_id, job.report.get()))
    throw HttpError(409, fmt::format("camera {} has no finished learning", camera_id));
  return json_response(state_json(camera_id));
}

Response LearningService::accept(const Request& request) {
  const int camera_id = path_camera_id(request);
  const auto report = report_of(camera_id);
  if (!report->learnt.lut)
    throw HttpError(409, fmt::format("camera {} has learnt nothing: {}", camera_id, report->learnt.problem));
  {
    ColorTables::AtDesk at = tables_.open(camera_id);
    tables_.take_over(at, report->learnt.lut,
                      fmt::format("learnt from {} robots", report->learnt.robots.size()), request.address);
  }
  jobs_.forget(camera_id, report.get());
  return json_response(colors_.state_json(camera_id));
}

Response LearningService::get_picture(const Request& request) {
  const int camera_id = path_camera_id(request);
  const int picture = read_whole_number("picture", request.matches[2], 0, kMaxRouteNumber);
  const std::size_t labels = query_choice(request, "labels", {"", "before", "after"});
  const auto report = report_of(camera_id);
  if (static_cast<std::size_t>(picture) >= report->pictures.size())
    throw HttpError(404, fmt::format("no image {}; there are {}", picture, report->pictures.size()));
  const StillPicture& still = *report->pictures[static_cast<std::size_t>(picture)].picture;
  if (labels == 0) return jpeg_response(still.view, request);
  const auto& lut = labels == 2 ? report->learnt.lut : report->before;
  if (!lut) throw HttpError(404, "nothing was learnt");
  return bytes_response(label_image_bytes(still.view, *lut, cameras_.get(camera_id).context().looked_at()));
}

}  // namespace sslv
