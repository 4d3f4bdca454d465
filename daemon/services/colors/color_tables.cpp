// SPDX-License-Identifier: Apache-2.0
#include "services/colors/color_tables.h"

#include "base/log.h"
#include "web/route.h"

#include <algorithm>
#include <functional>
#include <set>
#include <utility>

#include <fmt/format.h>

namespace sslv {

ColorTables::AtDesk ColorTables::open(int camera_id) {
  std::unique_lock lock(mutex_);
  CameraNow camera = cameras_.get(camera_id);
  ColorDesk& desk = desks_[camera_id];
  desk.take(camera.context().accepted_lut);
  return {std::move(lock), std::move(camera), desk};
}

ColorDesk::Save ColorTables::saver(const AtDesk& at, const std::string& who) {
  return [this, camera_id = at.camera.id, labels = at.camera.context().labels, who](
             const std::shared_ptr<const Lut>& lut, const std::string& what) {
    name_table(camera_id, saved_.save(lut, *labels), what, who);
    tidy();
  };
}

void ColorTables::take_over(AtDesk& at, std::shared_ptr<const Lut> lut, const std::string& what,
                            const std::string& who) {
  at.desk.replace(with_bits(std::move(lut), at.desk.table()->color_bits()), what, who, saver(at, who));
}

void ColorTables::name_table(int camera_id, const std::string& name, const std::string& what,
                             const std::string& who) {
  const Json settings = settings_.current().settings;
  const Json& cameras = settings.at("cameras");
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    if (cameras[i].at("id") != camera_id) continue;
    const std::string path = fmt::format("/cameras/{}", i);
    // The list of cameras may have changed meanwhile: do not change another camera.
    const Json patch{{{"op", "test"}, {"path", path + "/id"}, {"value", camera_id}},
                     {{"op", "replace"}, {"path", path + "/colors/table"}, {"value", name}}};
    SettingsEdit edit{who, {}, "colours"};
    edit.joins = true;
    const auto version = settings_.patch(patch, edit);
    log::info("settings revision {} saved: camera {}'s colour table {} by {}", version.revision, camera_id,
              what, who);
    return;
  }
  throw HttpError(404, fmt::format("no camera {}", camera_id));
}

void ColorTables::tidy() {
  constexpr int kEvery = 50;
  if (saved_since_tidied_++ % kEvery != 0) return;
  std::set<std::string> used;
  const std::function<void(const Json&)> collect = [&](const Json& json) {
    if (json.is_string()) used.insert(json.get<std::string>());
    if (json.is_structured()) std::for_each(json.begin(), json.end(), collect);
  };
  collect(settings_.current().settings);
  collect(settings_.history());
  for (const Profile& profile : profiles_.all()) collect(profile.settings);
  saved_.tidy(used);
}

}  // namespace sslv
