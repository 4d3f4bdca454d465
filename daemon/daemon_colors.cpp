// SPDX-License-Identifier: Apache-2.0
// How the panel edits, learns and follows colours: docs/colours.md.
#include "base/clock.h"
#include "base/log.h"
#include "base/params_json.h"
#include "capture/source.h"
#include "colors_json.h"
#include "daemon.h"
#include "vision/lut_codec.h"
#include "vision/threshold.h"
#include "web/http.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Beyond it a pick says what a sample of it says.
constexpr std::size_t kMostPicked = 20'000;
constexpr std::size_t kMostCommands = 200;

std::vector<std::uint8_t> labelled(const ImageView& picture, const Lut& lut, const Mask& mask) {
  LabelImage labels;
  Threshold().process({}, lut, mask, Image(picture, nullptr, nullptr, nullptr), labels);
  return label_picture_bytes(labels);
}

std::vector<Yuv> thinned(std::vector<Yuv> pixels) {
  const std::size_t step = pixels.size() / kMostPicked + 1;
  if (step == 1) return pixels;
  std::vector<Yuv> out;
  for (std::size_t i = 0; i < pixels.size(); i += step) out.push_back(pixels[i]);
  return out;
}

struct PickCommand {
  std::string op, label;
  int x = 0, y = 0, width = 1, height = 1;
  std::optional<int> still;
  bool take_away = false;
  static constexpr auto fields() {
    using P = PickCommand;
    return std::tuple{text("op", &P::op, "pick"),
                      text("label", &P::label, "a label's name"),
                      number("x", &P::x, 0, 16383, "px", "left"),
                      number("y", &P::y, 0, 16383, "px", "top"),
                      number("width", &P::width, 1, 16384, "px", ""),
                      number("height", &P::height, 1, 16384, "px", ""),
                      number("still", &P::still, 0, 2'000'000'000, "", "null: the newest picture"),
                      flag("take_away", &P::take_away, "from the label instead of adding to it")};
  }
};

struct WidenCommand {
  std::string op;
  static constexpr auto fields() { return std::tuple{text("op", &WidenCommand::op, "widen_margins")}; }
};

/// Several commands in the words of the first, and how many more.
std::string what_they_did(const std::vector<TableEdit>& edits, const LabelSet& labels) {
  const std::string first = what_it_did(edits.front(), labels);
  const bool all_alike = std::all_of(
      edits.begin(), edits.end(), [&](const TableEdit& edit) { return what_it_did(edit, labels) == first; });
  return all_alike ? first : fmt::format("{} and {} more", first, edits.size() - 1);
}

}  // namespace

Daemon::ColorCamera Daemon::color_camera(int camera_id) {
  const auto running = camera(static_cast<std::uint32_t>(camera_id));
  if (!running) throw HttpError(404, fmt::format("no camera {}", camera_id));
  ColorCamera out{running, running->pipeline().setup()->world, desks_[camera_id]};
  out.desk.take(out.world.accepted_lut);
  return out;
}

ColorDesk::Save Daemon::table_saver(int camera_id, const LabelSet& labels, const std::string& who) {
  return [this, camera_id, &labels, who](const std::shared_ptr<const Lut>& lut, const std::string& what) {
    put_table_into_force(camera_id, saved_tables_.save(lut, labels), what, who);
    tidy_tables();
  };
}

void Daemon::tidy_tables() {
  constexpr int kEvery = 50;
  if (tables_since_tidied_++ % kEvery != 0) return;
  std::set<std::string> used;
  const std::function<void(const Json&)> collect = [&](const Json& json) {
    if (json.is_string()) used.insert(json.get<std::string>());
    if (json.is_structured()) std::for_each(json.begin(), json.end(), collect);
  };
  collect(store_.current().settings);
  collect(store_.history());
  for (const Profile& profile : profiles_.all()) collect(profile.settings);
  saved_tables_.tidy(used);
}

void Daemon::put_table_into_force(int camera_id, const std::string& name, const std::string& what,
                                  const std::string& who) {
  const Json settings = store_.current().settings;
  const Json& cameras = settings.at("cameras");
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    if (cameras[i].at("id") != camera_id) continue;
    const std::string path = fmt::format("/cameras/{}", i);
    // The list may have been changed meanwhile: not another camera's.
    const Json patch{{{"op", "test"}, {"path", path + "/id"}, {"value", camera_id}},
                     {{"op", "replace"}, {"path", path + "/colors/table"}, {"value", name}}};
    SettingsEdit edit{who, {}, "colours"};
    edit.joins = true;
    const auto version = store_.patch(patch, edit, [this](const Json& next) { return prepare(next); });
    log::info("settings revision {} saved: camera {}'s colour table {} by {}", version.revision, camera_id,
              what, who);
    return;
  }
  throw HttpError(404, fmt::format("no camera {}", camera_id));
}

Json Daemon::colors_state(int camera_id) {
  const ColorCamera at = color_camera(camera_id);
  const auto settings = at.camera->settings();
  const ColorSettings& colors = settings->colors;
  const char* origin = !colors.table.empty() ? "table" : !colors.lut_file.empty() ? "file" : "classes";
  return colors_json(camera_id, origin, at.desk, *at.world.labels, light_view(camera_id, at.world),
                     color_margins_.margins(camera_id, *at.world.lut));
}

LightView Daemon::light_view(int camera_id, const World& world) const {
  FollowLight::Status status = follow_light_.status(camera_id);
  return {
      std::move(status.state), {status.steps.begin(), status.steps.end()}, world.lut != world.accepted_lut};
}

FollowLight::Hooks Daemon::light_hooks() {
  FollowLight::Hooks hooks;
  hooks.wait_frame = frame_waiter();
  hooks.cameras = [this] {
    std::vector<FollowLight::Camera> out;
    for (const auto& running : cameras_now()) {
      const auto settings = running->settings();
      const World world = running->pipeline().setup()->world;
      out.push_back({settings->id, settings->follow_light, world.accepted_lut, world.scene, world.patterns});
    }
    return out;
  };
  hooks.game_is_running = [this] { return referee_.game_is_running(); };
  hooks.put_table = [this](int camera_id, const std::shared_ptr<const Lut>& accepted,
                           std::shared_ptr<const Lut> table) {
    const std::lock_guard lock(cameras_mutex_);
    if (const auto running = camera(static_cast<std::uint32_t>(camera_id)))
      running->change_light(accepted, std::move(table));
  };
  return hooks;
}

ColorMargins::Hooks Daemon::margin_hooks() {
  ColorMargins::Hooks hooks;
  hooks.wait_frame = frame_waiter();
  hooks.cameras = [this] {
    std::vector<ColorMargins::Camera> out;
    for (const auto& running : cameras_now()) {
      const World world = running->pipeline().setup()->world;
      out.push_back({running->settings()->id, world.lut, world.scene, world.mask, world.patterns});
    }
    return out;
  };
  return hooks;
}

void Daemon::take_light_back(const ColorCamera& at, int camera_id, const std::string& who) {
  follow_light_.take_back(camera_id);
  const std::lock_guard lock(cameras_mutex_);
  at.camera->change_light(at.world.accepted_lut, at.world.accepted_lut);
  log::info("camera {}: back to its accepted colour table, by {}", camera_id, who);
}

void Daemon::take_over(const ColorCamera& at, int camera_id, std::shared_ptr<const Lut> lut,
                       const std::string& what, const std::string& who) {
  at.desk.replace(with_bits(std::move(lut), at.desk.table()->color_bits()), what, who,
                  table_saver(camera_id, *at.world.labels, who));
}

void Daemon::keep_todays_light(const ColorCamera& at, int camera_id, const std::string& who) {
  if (at.world.lut == at.world.accepted_lut) return;
  take_over(at, camera_id, at.world.lut, "taken over in today's light", who);
}

TableEdit Daemon::read_color_command(int camera_id, const Json& json, const std::string& path,
                                     const World& world) {
  const Json op = json.is_object() ? json.value("op", Json()) : Json();
  if (op == "widen_margins") {
    params_from_json<WidenCommand>(json, path);
    auto surfaces = color_margins_.surfaces(camera_id);
    if (!surfaces) {
      throw SettingsError(
          fmt::format("{}: camera {}'s carpet was not seen yet: its margins are not known", path, camera_id));
    }
    return WidenMarginsEdit{std::move(surfaces)};
  }
  if (op != "pick") return read_table_edit(json, path, *world.labels);
  const auto pick = params_from_json<PickCommand>(json, path);
  const auto label = world.labels->find(pick.label);
  if (!label) {
    throw SettingsError(fmt::format("{}/label: {} is not allowed; expected one of {}", path,
                                    Json(pick.label).dump(), world.labels->names()));
  }
  const Looked looked = look(camera_id, pick.still);
  const PixelBlock block =
      read_pixels(looked.picture.image, {pick.x, pick.y, pick.width, pick.height}, *world.lut);
  if (block.colors.empty()) {
    throw SettingsError(
        fmt::format("{}: the rectangle at ({}, {}) lies outside the picture, which has {} x {} px", path,
                    pick.x, pick.y, looked.picture.image.width, looked.picture.image.height));
  }
  ColorCluster cluster{thinned(block.colors), {}};
  if (pick.take_away) return RemoveClusterEdit{*label, std::move(cluster)};
  AddClusterEdit edit{*label, std::move(cluster), Over::kAny};
  if (const auto surfaces = color_margins_.surfaces(camera_id); surfaces && !is_surface_label(*label)) {
    // Who points at carpet or floor means it.
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

Json Daemon::edit_colors(int camera_id, const Json& request, const std::string& who) {
  if (!request.is_object() || !request.contains("commands") || !request["commands"].is_array() ||
      request["commands"].empty() || request["commands"].size() > kMostCommands) {
    throw SettingsError(fmt::format("/commands: expected a list of 1 to {} commands", kMostCommands));
  }
  bool only_try = false;
  for (const auto& [key, value] : request.items()) {
    if (key == "try" && value.is_boolean()) {
      only_try = value.get<bool>();
    } else if (key != "commands") {
      throw SettingsError(fmt::format(
          "/{}: {} is not allowed; expected \"commands\" and \"try\": true or false", key, value.dump()));
    }
  }
  const std::lock_guard lock(colors_mutex_);
  const ColorCamera at = color_camera(camera_id);
  std::vector<TableEdit> edits;
  for (std::size_t i = 0; i < request["commands"].size(); ++i) {
    edits.push_back(
        read_color_command(camera_id, request["commands"][i], fmt::format("/commands/{}", i), at.world));
  }
  if (!only_try) keep_todays_light(at, camera_id, who);
  const TableChange change = at.desk.tried(edits);
  Json out = table_change_json(change, *at.world.labels);
  if (!only_try) {
    at.desk.change(change, what_they_did(edits, *at.world.labels), who,
                   table_saver(camera_id, *at.world.labels, who));
  }
  out["state"] = colors_state(camera_id);
  return out;
}

Json Daemon::import_colors(int camera_id, const TableFile& file, const std::string& who) {
  const std::lock_guard lock(colors_mutex_);
  const ColorCamera at = color_camera(camera_id);
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(file.bytes.data()), file.bytes.size());
  const std::vector<ImportedTable> tables = import_tables(bytes, file.name, *at.world.labels);
  Json out{{"tables", imported_json(tables, *at.world.labels)}};
  if (!file.only_try) {
    const ImportedTable& chosen = choose_table(tables, file.table, {}, file.name);
    take_over(at, camera_id, std::make_shared<const Lut>(chosen.table), "imported " + file.name, who);
  }
  out["state"] = colors_state(camera_id);
  return out;
}

Daemon::Looked Daemon::look(int camera_id, std::optional<int> still) {
  if (still) {
    auto picture = stills_.find(camera_id, *still);
    if (!picture) {
      throw HttpError(
          404, fmt::format("camera {} has no still {}, or not any more: take a new one", camera_id, *still));
    }
    return {{picture, picture->view}, picture->frame_number, picture->t_capture_s};
  }
  const auto newest = hold_frame(static_cast<std::uint32_t>(camera_id), 0, std::chrono::milliseconds(0));
  if (!newest) throw HttpError(503, fmt::format("camera {} has no picture yet", camera_id));
  const Frame& frame = *newest->hold->frame;
  return {{newest->hold, frame.image.view()}, frame.info.number, frame.info.times.t_capture_s};
}

Json Daemon::pixels(int camera_id, const PixelWish& wish) {
  constexpr int kRegionReach_px = 200;
  const auto running = camera(static_cast<std::uint32_t>(camera_id));
  if (!running) throw HttpError(404, fmt::format("no camera {}", camera_id));
  const World world = running->pipeline().setup()->world;
  const Looked looked = look(camera_id, wish.still);
  PixelBox box{wish.x, wish.y, wish.width, wish.height};
  const int middle_x = wish.x + wish.width / 2, middle_y = wish.y + wish.height / 2;
  if (wish.region)
    box = {middle_x - kRegionReach_px, middle_y - kRegionReach_px, 2 * kRegionReach_px, 2 * kRegionReach_px};
  PixelBlock block = read_pixels(looked.picture.image, box, *world.lut);
  const PixelFigures figures =
      figures_of(block, wish.region ? region_around(block, middle_x, middle_y) : std::vector<bool>{});
  return pixels_json(block, figures, looked.frame_number, *world.labels);
}

Json Daemon::take_still(int camera_id) {
  const Looked looked = look(camera_id, {});
  const ImageView& image = looked.picture.image;
  const int still = stills_.keep(camera_id, StillPicture(image, looked.frame_number, looked.t_capture_s));
  return {{"still", still},
          {"frame", looked.frame_number},
          {"t_capture", looked.t_capture_s},
          {"width", image.width},
          {"height", image.height}};
}

Json Daemon::start_learning(int camera_id, const Json& json, const std::string& who) {
  const LearningRequest request = read_learning_request(json);
  const auto running = camera(static_cast<std::uint32_t>(camera_id));
  if (!running) throw HttpError(404, fmt::format("no camera {}", camera_id));
  LearningOrder order{request.frames, {}, *running->settings(), running->pipeline().setup()->world, who,
                      unix_time_s()};
  for (std::size_t i = 0; i < request.guide.size(); ++i) {
    const LearningClick& click = request.guide[i];
    const auto label = order.world.labels->find(click.label);
    if (!label) {
      throw SettingsError(fmt::format("/guide/{}/label: {} is not allowed; expected one of {}", i,
                                      Json(click.label).dump(), order.world.labels->names()));
    }
    const Looked looked = look(camera_id, click.still);
    const PixelFigures figures =
        figures_of(read_pixels(looked.picture.image, {click.x - 1, click.y - 1, 3, 3}, *order.world.lut));
    if (figures.count == 0) throw SettingsError(fmt::format("/guide/{}: lies outside the picture", i));
    const auto byte = [](double value) { return static_cast<std::uint8_t>(std::lround(value)); };
    order.guide.push_back(
        {*label, to_rgb({byte(figures.mean[0]), byte(figures.mean[1]), byte(figures.mean[2])})});
  }
  if (!color_learning_.start(camera_id, std::move(order)))
    throw HttpError(409,
                    fmt::format("camera {} is learning its colours already; cancel that first", camera_id));
  log::info("camera {}: learning of colours started by {}", camera_id, who);
  return learning_state(camera_id);
}

Json Daemon::learning_state(int camera_id) const {
  const auto running = camera(static_cast<std::uint32_t>(camera_id));
  if (!running) throw HttpError(404, fmt::format("no camera {}", camera_id));
  return learning_json(camera_id, color_learning_.job(camera_id), *running->pipeline().setup()->world.labels);
}

std::shared_ptr<const LearningReport> Daemon::learning_report(int camera_id) const {
  auto report = color_learning_.job(camera_id).report;
  if (!report) throw HttpError(409, fmt::format("camera {} has no finished learning", camera_id));
  return report;
}

const LearningPicture& Daemon::learning_picture(const LearningReport& report, int picture) const {
  if (static_cast<std::size_t>(picture) >= report.pictures.size())
    throw HttpError(404, fmt::format("no picture {}; there are {}", picture, report.pictures.size()));
  return report.pictures[static_cast<std::size_t>(picture)];
}

Json Daemon::accept_learning(int camera_id, const std::string& who) {
  const auto report = learning_report(camera_id);
  if (!report->learnt.lut)
    throw HttpError(409, fmt::format("camera {} has learnt nothing: {}", camera_id, report->learnt.problem));
  const std::lock_guard lock(colors_mutex_);
  const ColorCamera at = color_camera(camera_id);
  take_over(at, camera_id, report->learnt.lut,
            fmt::format("learnt from {} robots", report->learnt.robots.size()), who);
  color_learning_.forget(camera_id, report.get());
  return colors_state(camera_id);
}

void Daemon::add_colors_to(WebHost& web_host) {
  ColorHost& host = web_host.colors;
  const auto number = [](std::uint32_t id) { return static_cast<int>(id); };
  host.state = [this, number](std::uint32_t id) {
    const std::lock_guard lock(colors_mutex_);
    return colors_state(number(id));
  };
  const auto world_of = [this](std::uint32_t id) {
    const auto running = camera(id);
    if (!running) throw HttpError(404, fmt::format("no camera {}", id));
    return running->pipeline().setup()->world;
  };
  host.lut_file = [world_of](std::uint32_t id, bool in_todays_light) {
    const World world = world_of(id);
    return encode_lut((in_todays_light ? world.lut : world.accepted_lut)->color_table(), *world.labels);
  };
  host.json_file = [world_of](std::uint32_t id) {
    const World world = world_of(id);
    return table_json_text(world.accepted_lut->color_table(), *world.labels);
  };
  host.edit = [this, number](std::uint32_t id, const Json& edits, const std::string& who) {
    return edit_colors(number(id), edits, who);
  };
  host.undo = [this, number](std::uint32_t id, const std::string& who) {
    const std::lock_guard lock(colors_mutex_);
    const ColorCamera at = color_camera(number(id));
    if (!at.desk.undo(table_saver(number(id), *at.world.labels, who)))
      throw HttpError(409,
                      fmt::format("nothing was done to camera {}'s table that could be undone here", id));
    return colors_state(number(id));
  };
  host.redo = [this, number](std::uint32_t id, const std::string& who) {
    const std::lock_guard lock(colors_mutex_);
    const ColorCamera at = color_camera(number(id));
    if (!at.desk.redo(table_saver(number(id), *at.world.labels, who)))
      throw HttpError(409, fmt::format("nothing was undone in camera {}'s table", id));
    return colors_state(number(id));
  };
  host.reset = [this, number](std::uint32_t id, const std::string& who) {
    const std::lock_guard lock(colors_mutex_);
    const ColorCamera at = color_camera(number(id));
    ColorSettings colors = at.camera->settings()->colors;
    if (colors.table.empty())
      throw HttpError(409, fmt::format("camera {} has the table of the settings already", id));
    colors.table.clear();
    at.desk.replace(
        make_lut(colors, "the settings' colors", *at.world.labels), "reset to the settings' colours", who,
        [&](const auto&, const std::string& what) { put_table_into_force(number(id), "", what, who); });
    return colors_state(number(id));
  };
  host.copy = [this, number, world_of](std::uint32_t id, int from, const std::string& who) {
    const std::lock_guard lock(colors_mutex_);
    const ColorCamera at = color_camera(number(id));
    if (from == number(id)) throw HttpError(409, "a camera's table cannot be copied onto itself");
    take_over(at, number(id), world_of(static_cast<std::uint32_t>(from)).accepted_lut,
              fmt::format("copied from camera {}", from), who);
    return colors_state(number(id));
  };
  host.import_file = [this, number](std::uint32_t id, const TableFile& file, const std::string& who) {
    return import_colors(number(id), file, who);
  };
  host.revert_light = [this, number](std::uint32_t id, const std::string& who) {
    const std::lock_guard lock(colors_mutex_);
    const ColorCamera at = color_camera(number(id));
    if (at.world.lut == at.world.accepted_lut)
      throw HttpError(409, fmt::format("camera {}'s accepted table is in force", id));
    take_light_back(at, number(id), who);
    return colors_state(number(id));
  };
  host.keep_light = [this, number](std::uint32_t id, const std::string& who) {
    const std::lock_guard lock(colors_mutex_);
    const ColorCamera at = color_camera(number(id));
    if (at.world.lut == at.world.accepted_lut)
      throw HttpError(409,
                      fmt::format("camera {}'s accepted table is in force: the light has not changed", id));
    keep_todays_light(at, number(id), who);
    return colors_state(number(id));
  };
  host.learning = [this, number](std::uint32_t id) { return learning_state(number(id)); };
  host.start_learning = [this, number](std::uint32_t id, const Json& request, const std::string& who) {
    return start_learning(number(id), request, who);
  };
  host.cancel_learning = [this, number](std::uint32_t id) {
    if (!color_learning_.cancel(number(id)))
      throw HttpError(409, fmt::format("camera {} is not learning its colours", id));
    return learning_state(number(id));
  };
  host.reject_learning = [this, number](std::uint32_t id) {
    const auto job = color_learning_.job(number(id));
    if (!job.order || !color_learning_.forget(number(id), job.report.get()))
      throw HttpError(409, fmt::format("camera {} has no finished learning", id));
    return learning_state(number(id));
  };
  host.accept_learning = [this, number](std::uint32_t id, const std::string& who) {
    return accept_learning(number(id), who);
  };
  host.learning_picture = [this, number](std::uint32_t id, int picture) {
    const auto report = learning_report(number(id));
    const auto& still = learning_picture(*report, picture).picture;
    return LentPicture{still, still->view};
  };
  host.learning_labels = [this, number, world_of](std::uint32_t id, int picture, bool after) {
    const auto report = learning_report(number(id));
    const auto& lut = after ? report->learnt.lut : report->before;
    if (!lut) throw HttpError(404, "nothing was learnt");
    const auto& still = *learning_picture(*report, picture).picture;
    return labelled(still.view, *lut, world_of(id).looked_at());
  };
  host.pixels = [this, number](std::uint32_t id, const PixelWish& wish) { return pixels(number(id), wish); };
  host.take_still = [this, number](std::uint32_t id) { return take_still(number(id)); };
  host.still_picture = [this, number](std::uint32_t id, int still) {
    return look(number(id), still).picture;
  };
  host.still_labels = [this, number, world_of](std::uint32_t id, int still) {
    const World world = world_of(id);
    return labelled(look(number(id), still).picture.image, *world.lut, world.looked_at());
  };
}

}  // namespace sslv
