// SPDX-License-Identifier: Apache-2.0
#include "ctl/controls.h"

#include <algorithm>

#include <fmt/format.h>

namespace sslv {
namespace {

std::string text_of(const Json& json, const char* key) {
  const Json& value = json.at(key);
  return value.is_null() ? "-" : value.is_string() ? value.get<std::string>() : json_text(value);
}

std::string allowed(const Json& control) {
  if (control.at("kind") == "choice") {
    std::string out;
    for (const Json& choice : control.at("choices"))
      out += (out.empty() ? "" : " | ") + choice.get<std::string>();
    return out;
  }
  if (control.contains("min")) {
    const std::string unit = control.at("unit").get<std::string>();
    return text_of(control, "min") + " .. " + text_of(control, "max") + (unit.empty() ? "" : " " + unit);
  }
  return control.at("kind").get<std::string>();
}

/// Numbers, true and false as JSON; everything else as text.
Json value_of(const std::string& text) {
  const Json value = Json::parse(text, nullptr, false);
  return value.is_number() || value.is_boolean() ? value : Json(text);
}

/// The name as a step of a JSON pointer (RFC 6901).
std::string escaped(const std::string& name) {
  std::string out;
  for (const char c : name) out += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
  return out;
}

std::size_t place_of(const Json& cameras, int camera_id) {
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    if (cameras[i].at("id") == camera_id) return i;
  }
  throw ClientError(fmt::format("no camera {}", camera_id));
}

}  // namespace

std::string controls_text(const Json& controls) {
  std::string out, category;
  for (const Json& control : controls) {
    if (control.at("category") != category) {
      category = control.at("category").get<std::string>();
      out += category + "\n";
    }
    out += fmt::format("  {:<32} {:<20} {}{}\n", control.at("name").get<std::string>(),
                       text_of(control, "value"), allowed(control),
                       control.at("writable") == true ? "" : "  (only shown)");
  }
  return out;
}

Json set_control(const Client& daemon, int camera_id, const std::string& assignment, bool save) {
  const std::size_t equals = assignment.find('=');
  const std::string name = assignment.substr(0, equals);
  const std::string path = fmt::format("/api/cameras/{}/controls", camera_id);
  if (equals == std::string::npos) return daemon.post(path + '/' + name, Json::object());
  const Json value = value_of(assignment.substr(equals + 1));
  const auto control = [&] {
    const Json controls = daemon.get_json(path).at("controls");
    const auto found = std::find_if(controls.begin(), controls.end(),
                                    [&](const Json& one) { return one.at("name") == name; });
    if (found == controls.end())
      throw ClientError(fmt::format("camera {} has no control \"{}\"", camera_id, name));
    return *found;
  };
  control();  // if there is none, nothing is saved
  if (!save) return daemon.post(path + '/' + name, {{"value", value}});
  const Json settings = daemon.get_json("/api/settings").at("settings");
  const std::size_t place = place_of(settings.at("cameras"), camera_id);
  const Json saved = daemon.patch(
      "/api/settings", {{{"op", "add"},
                         {"path", fmt::format("/cameras/{}/source/controls/{}", place, escaped(name))},
                         {"value", value}}});
  for (const Json& refusal : saved.value("refused", Json::array()))
    throw ClientError("saved, but not taken by the camera: " + refusal.get<std::string>());
  return control();
}

}  // namespace sslv
