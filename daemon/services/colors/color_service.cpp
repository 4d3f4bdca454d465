// SPDX-License-Identifier: Apache-2.0
#include "services/colors/color_service.h"

#include "base/log.h"
#include "base/params_json.h"
#include "colors/lut_file.h"
#include "colors/pixel_figures.h"
#include "colors/swapped_labels.h"
#include "services/cameras/camera_routes.h"
#include "services/colors/color_commands.h"
#include "services/colors/color_report.h"
#include "services/colors/colors_json.h"
#include "vision/lut_codec.h"

#include <array>
#include <cmath>
#include <span>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

FollowLight::Hooks light_hooks(Cameras& cameras, const RefereeListener& referee) {
  FollowLight::Hooks hooks;
  hooks.wait_frame = frames_of(cameras);
  hooks.cameras = [&cameras] {
    std::vector<FollowLight::Camera> out;
    for (const CameraNow& camera : cameras.all()) {
      const CameraContext& context = camera.context();
      out.push_back(
          {camera.id, camera.settings->follow_light, context.accepted_lut, context.scene, context.patterns});
    }
    return out;
  };
  hooks.game_is_running = [&referee] { return referee.game_is_running(); };
  hooks.put_table = [&cameras](int camera_id, const std::shared_ptr<const Lut>& accepted,
                               std::shared_ptr<const Lut> table) {
    cameras.change_light(camera_id, accepted, std::move(table));
  };
  return hooks;
}

ColorMargins::Hooks margin_hooks(Cameras& cameras) {
  ColorMargins::Hooks hooks;
  hooks.wait_frame = frames_of(cameras);
  hooks.cameras = [&cameras] {
    std::vector<ColorMargins::Camera> out;
    for (const CameraNow& camera : cameras.all()) {
      const CameraContext& context = camera.context();
      out.push_back({camera.id, context.adapted_lut, context.scene, context.mask, context.patterns});
    }
    return out;
  };
  return hooks;
}

Response file_response(Response response, int camera_id, const char* ending) {
  response.headers.emplace_back(
      "Content-Disposition",
      fmt::format("attachment; filename=\"colours-of-camera-{}{}\"", camera_id, ending));
  return response;
}

}  // namespace

ColorService::ColorService(Cameras& cameras, Pictures& pictures, ColorTables& tables, SavedTables& saved,
                           const RefereeListener& referee)
    : cameras_(cameras),
      pictures_(pictures),
      tables_(tables),
      saved_(saved),
      follow_light_(light_hooks(cameras, referee)),
      margins_(margin_hooks(cameras)) {
  cameras.add_observer(*this);
}

void ColorService::cameras_changed(const std::set<int>& camera_ids) noexcept {
  margins_.forget(camera_ids);
}

Plan ColorService::plan(const SettingsChange& change) const {
  if (change.origin != SettingsChange::Origin::kStart) return {};
  return {.apply = [this]() noexcept { saved_.end_start(); }};
}

Json ColorService::state_json(int camera_id) {
  return state_json(tables_.open(camera_id));
}

Json ColorService::state_json(const ColorTables::AtDesk& at) {
  // The camera's table may have changed since the desk was opened.
  const CameraNow camera = cameras_.get(at.camera.id);
  at.desk.take(camera.context().accepted_lut);
  const ColorSettings& colors = camera.settings->colors;
  const char* origin = !colors.table.empty() ? "table" : !colors.lut_file.empty() ? "file" : "classes";
  FollowLight::Status status = follow_light_.status(camera.id);
  const LightView light{std::move(status.state),
                        {status.steps.begin(), status.steps.end()},
                        camera.context().adapted_lut != camera.context().accepted_lut};
  return colors_json(camera.id, origin, at.desk, *camera.context().labels, light,
                     margins_.margins(camera.id, *camera.context().adapted_lut));
}

std::vector<SupportFile> ColorService::support_files() const {
  std::vector<SupportFile> files;
  for (const CameraNow& camera : cameras_.all()) {
    const auto add = [&](const char* name, const char* what, std::shared_ptr<const Lut> lut) {
      files.push_back({fmt::format("camera_{}/{}", camera.id, name), what,
                       [lut = std::move(lut), labels = camera.context().labels] {
                         const auto bytes = encode_lut(lut->color_table(), *labels);
                         return std::string(bytes.begin(), bytes.end());
                       }});
    };
    const CameraContext& context = camera.context();
    add("colors.lut", "its colour table", context.accepted_lut);
    if (context.adapted_lut != context.accepted_lut)
      add("colors_in_light.lut", "the same, adapted to the current light, as it is in use",
          context.adapted_lut);
  }
  return files;
}

std::vector<Route> ColorService::routes() {
  const auto call = [this](Response (ColorService::*handle)(const Request&)) -> Handler {
    return [this, handle](const Request& request) {
      cameras_.get(path_camera_id(request));
      return (this->*handle)(request);
    };
  };
  return {
      {"GET", R"(/api/cameras/(\d+)/colors)",
       [this](const Request& request) { return json_response(state_json(path_camera_id(request))); }},
      {"GET", R"(/api/cameras/(\d+)/colors/table)",
       [this](const Request& request) {
         const CameraNow camera = cameras_.get(path_camera_id(request));
         const CameraContext& context = camera.context();
         const Lut& lut = query_flag(request, "light") ? *context.adapted_lut : *context.accepted_lut;
         return bytes_response(encode_lut(lut.color_table(), *context.labels));
       }},
      {"POST", R"(/api/cameras/(\d+)/colors/edits)", call(&ColorService::edit)},
      {"POST", R"(/api/cameras/(\d+)/colors/undo)",
       [this](const Request& request) { return undo_or_redo(request, true); }},
      {"POST", R"(/api/cameras/(\d+)/colors/redo)",
       [this](const Request& request) { return undo_or_redo(request, false); }},
      {"POST", R"(/api/cameras/(\d+)/colors/reset)", call(&ColorService::reset)},
      {"POST", R"(/api/cameras/(\d+)/colors/copy)", call(&ColorService::copy)},
      {"POST", R"(/api/cameras/(\d+)/colors/import)", call(&ColorService::import)},
      {"GET", R"(/api/cameras/(\d+)/colors/export)", call(&ColorService::export_table)},
      {"POST", R"(/api/cameras/(\d+)/colors/light/revert)", call(&ColorService::revert_light)},
      {"POST", R"(/api/cameras/(\d+)/colors/light/keep)", call(&ColorService::keep_light)},
  };
}

TableEdit ColorService::read_command(const ColorTables::AtDesk& at, const Json& json,
                                     const std::string& path) {
  const Json op = json.is_object() ? json.value("op", Json()) : Json();
  if (op == "widen_margins") {
    params_from_json<WidenCommand>(json, path);
    auto surfaces = margins_.surfaces(at.camera.id);
    if (!surfaces) {
      throw SettingsError(fmt::format("{}: camera {}'s carpet has not been seen yet: its margins are unknown",
                                      path, at.camera.id));
    }
    return WidenMarginsEdit{std::move(surfaces)};
  }
  return op == "pick" ? read_pick(at, json, path) : read_table_edit(json, path, at.labels());
}

TableEdit ColorService::read_pick(const ColorTables::AtDesk& at, const Json& json, const std::string& path) {
  const auto pick = params_from_json<PickCommand>(json, path);
  const Label label = find_label(at.labels(), pick.label, path + "/label");
  const LentPicture looked = pictures_.look(at.camera.id, pick.still);
  const PixelBlock block =
      read_pixels(looked.image, {pick.x, pick.y, pick.width, pick.height}, *at.camera.context().adapted_lut);
  if (block.colors.empty()) {
    throw SettingsError(
        fmt::format("{}: the rectangle at ({}, {}) lies outside the image, which has {} x {} px", path,
                    pick.x, pick.y, looked.image.width, looked.image.height));
  }
  ColorCluster cluster{thinned(block.colors), {}};
  if (pick.take_away) return RemoveClusterEdit{label, std::move(cluster)};
  AddClusterEdit edit{label, std::move(cluster), Over::kAny};
  if (const auto surfaces = margins_.surfaces(at.camera.id); surfaces && !is_surface_label(label)) {
    // Users pick a colour of carpet or floor on purpose: then no cell has to stay clear.
    const PixelFigures figures = figures_of(block);
    const auto level = [&](std::size_t c) { return static_cast<std::uint8_t>(std::lround(figures.mean[c])); };
    const Yuv mean{level(0), level(1), level(2)};
    const auto is_seen_on = [&](SurfaceKind kind) {
      return reach_of(*surfaces, kind, {.darkest = 1, .brightest = 1})(mean);
    };
    if (!is_seen_on(SurfaceKind::kCarpet) && !is_seen_on(SurfaceKind::kFloor))
      edit.stays_clear = reach_of(*surfaces, SurfaceKind::kCarpet, {});
  }
  return edit;
}

Response ColorService::edit(const Request& request) {
  const EditRequest wanted = read_edit_request(parse_json(request.body));
  ColorTables::AtDesk at = tables_.open(path_camera_id(request));
  std::vector<TableEdit> edits;
  for (std::size_t i = 0; i < wanted.commands.size(); ++i)
    edits.push_back(read_command(at, wanted.commands[i], fmt::format("/commands/{}", i)));
  const ColorDesk before = at.desk;
  Json out;
  try {
    // The edit applies to the table in use, so an adapted table is accepted first. Both steps are saved and
    // take effect together.
    if (!wanted.only_try && at.is_adapted()) {
      at.desk.replace(with_bits(at.camera.context().adapted_lut, at.desk.table()->color_bits()),
                      "accepted as adapted to the light", request.address, [](const auto&, const auto&) {});
    }
    const TableChange change = at.desk.preview(edits);
    out = table_change_json(change, at.labels());
    if (!wanted.only_try) {
      at.desk.change(change, what_they_did(edits, at.labels()), request.address,
                     tables_.saver(at, request.address));
      // An edit that changes no cell saves nothing, but the adapted table must still be saved.
      if (at.desk.table() != before.table() && change.cells.empty()) {
        tables_.saver(at, request.address)(at.desk.table(), "accepted as adapted to the light");
      }
    }
  } catch (...) {
    at.desk = before;
    throw;
  }
  out["state"] = state_json(at);
  Response response = json_response(out);
  response.only_tried = wanted.only_try;
  return response;
}

Response ColorService::undo_or_redo(const Request& request, bool undo) {
  ColorTables::AtDesk at = tables_.open(path_camera_id(request));
  const auto save = tables_.saver(at, request.address);
  if (undo && !at.desk.undo(save)) {
    throw HttpError(409, fmt::format("camera {}'s table has no step to undo", at.camera.id));
  }
  if (!undo && !at.desk.redo(save))
    throw HttpError(409, fmt::format("camera {}'s table has no step to redo", at.camera.id));
  return json_response(state_json(at));
}

Response ColorService::reset(const Request& request) {
  ColorTables::AtDesk at = tables_.open(path_camera_id(request));
  ColorSettings colors = at.camera.settings->colors;
  if (colors.table.empty())
    throw HttpError(409, fmt::format("camera {} has the table of the settings already", at.camera.id));
  colors.table.clear();
  at.desk.replace(make_lut(colors, "the settings' colors", at.labels()), "reset to the settings' colours",
                  request.address, [&](const auto&, const std::string& what) {
                    tables_.name_table(at.camera.id, "", what, request.address);
                  });
  return json_response(state_json(at));
}

Response ColorService::copy(const Request& request) {
  const Json body = parse_json(request.body);
  if (!body.is_object() || body.size() != 1 || !body.contains("from") || !body["from"].is_number_unsigned())
    throw HttpError(400, R"(expected {"from": the id of another camera})");
  const int from = body["from"].get<int>();
  ColorTables::AtDesk at = tables_.open(path_camera_id(request));
  if (from == at.camera.id) throw HttpError(409, "a camera's table cannot be copied onto itself");
  tables_.take_over(at, cameras_.get(from).context().accepted_lut, fmt::format("copied from camera {}", from),
                    request.address);
  return json_response(state_json(at));
}

Response ColorService::import(const Request& request) {
  const auto name = request.query.find("name");
  const std::string file_name = name == request.query.end() ? "the file" : name->second;
  const bool only_try = query_flag(request, "try");
  std::optional<std::size_t> table;
  if (request.query.contains("table"))
    table = static_cast<std::size_t>(query_number(request, "table", 0, 0, kMaxRouteNumber));
  ColorTables::AtDesk at = tables_.open(path_camera_id(request));
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(request.body.data()), request.body.size());
  const std::vector<ImportedTable> tables = import_tables(bytes, file_name, at.labels());
  Json out{{"tables", imported_json(tables, at.labels())}};
  if (!only_try) {
    const ImportedTable& chosen = choose_table(tables, table, {}, file_name);
    tables_.take_over(at, std::make_shared<const Lut>(chosen.table), "imported " + file_name,
                      request.address);
  }
  out["state"] = state_json(at);
  Response response = json_response(out);
  response.only_tried = only_try;
  return response;
}

Response ColorService::export_table(const Request& request) {
  const CameraNow camera = cameras_.get(path_camera_id(request));
  const auto& table = camera.context().accepted_lut->color_table();
  if (query_choice(request, "format", {"lut", "json"}) == 1) {
    return file_response({200, "application/json", table_json_text(table, *camera.context().labels)},
                         camera.id, ".json");
  }
  return file_response(bytes_response(encode_lut(table, *camera.context().labels)), camera.id, ".lut");
}

Response ColorService::revert_light(const Request& request) {
  ColorTables::AtDesk at = tables_.open(path_camera_id(request));
  if (!at.is_adapted())
    throw HttpError(409, fmt::format("camera {}'s accepted table is in use", at.camera.id));
  follow_light_.take_back(at.camera.id);
  const auto& accepted = at.camera.context().accepted_lut;
  cameras_.change_light(at.camera.id, accepted, accepted);
  log::info("camera {}: back to its accepted colour table, by {}", at.camera.id, request.address);
  return json_response(state_json(at));
}

Response ColorService::keep_light(const Request& request) {
  ColorTables::AtDesk at = tables_.open(path_camera_id(request));
  if (!at.is_adapted()) {
    throw HttpError(
        409, fmt::format("camera {}'s accepted table is in use: the light has not changed", at.camera.id));
  }
  tables_.take_over(at, at.camera.context().adapted_lut, "accepted as adapted to the light", request.address);
  return json_response(state_json(at));
}

ColorService::TableFaults ColorService::faults_of(const std::shared_ptr<const Lut>& lut,
                                                  const LabelSet& labels) {
  TableFaults out{lut, {}, {}};
  const ColorTable table = lut->color_table();
  std::array<bool, label::kMaxCount> has{};
  for (const Label label : table.labels) has[label] = true;
  for (const Label label : {label::kOrange, label::kYellow, label::kBlue, label::kPink, label::kGreen}) {
    if (!has[label]) out.missing.push_back(labels.name(label));
  }
  for (const SwappedLabel& one : swapped_labels(table))
    out.swapped.push_back(fmt::format("{} for {}", labels.name(one.looks_like), labels.name(one.label)));
  return out;
}

void ColorService::each_second() {
  const auto known = faults_.load();
  std::map<int, TableFaults> now;
  for (const CameraNow& camera : cameras_.all()) {
    const auto& lut = camera.context().accepted_lut;
    const auto before = known->find(camera.id);
    now[camera.id] = before != known->end() && before->second.lut == lut
                         ? before->second
                         : faults_of(lut, *camera.context().labels);
  }
  faults_.store(std::move(now));
}

void ColorService::report(HealthReport& report) const {
  std::vector<ColorFacts> facts;
  const auto faults = faults_.load();
  std::vector<std::string> lost;
  for (const CameraNow& camera : cameras_.all()) {
    ColorFacts one{camera.id};
    if (const auto margins = margins_.newest_margins(camera.id)) {
      const auto least = min_to_carpet(*margins);
      const LabelSet& labels = *camera.context().labels;
      one.min_margin = least ? ColorFacts::Margin{std::abs(least->change),
                                                  margin_text(name_of(SurfaceKind::kCarpet),
                                                              labels.name(least->label), least->change)}
                             : ColorFacts::Margin{ColorFacts::Margin::kMax, ""};
    }
    if (const auto found = faults->find(camera.id); found != faults->end()) {
      one.missing_labels = found->second.missing;
      one.swapped_labels = found->second.swapped;
    }
    const bool is_labelled = std::ranges::find(camera.settings->running.stages, "segment") !=
                             camera.settings->running.stages.end();
    if (is_labelled && camera.health.width > 0 && !has_colors(camera.health.format))
      one.grey_format = name_of(camera.health.format);
    facts.push_back(std::move(one));
    if (auto problem = saved_.lost(camera.settings->colors.table); !problem.empty())
      lost.push_back(std::move(problem));
  }
  report_colors(facts, lost, report);
}

}  // namespace sslv
