// SPDX-License-Identifier: Apache-2.0
#include "services/colors/color_commands.h"

#include "base/error.h"

#include <algorithm>
#include <cstddef>

#include <fmt/format.h>

namespace sslv {

EditRequest read_edit_request(const Json& json) {
  constexpr std::size_t kMaxCommands = 200;
  if (!json.is_object() || !json.contains("commands") || !json["commands"].is_array() ||
      json["commands"].empty() || json["commands"].size() > kMaxCommands) {
    throw SettingsError(fmt::format("/commands: expected a list of 1 to {} commands", kMaxCommands));
  }
  EditRequest out{json["commands"], false};
  for (const auto& [key, value] : json.items()) {
    if (key == "try" && value.is_boolean()) {
      out.only_try = value.get<bool>();
    } else if (key != "commands") {
      throw SettingsError(fmt::format(
          "/{}: {} is not allowed; expected \"commands\" and \"try\": true or false", key, json_text(value)));
    }
  }
  return out;
}

Label find_label(const LabelSet& labels, const std::string& name, const std::string& path) {
  const auto label = labels.find(name);
  if (label) return *label;
  throw SettingsError(
      fmt::format("{}: {} is not allowed; expected one of {}", path, json_text(Json(name)), labels.names()));
}

std::string what_they_did(const std::vector<TableEdit>& edits, const LabelSet& labels) {
  const std::string first = what_it_did(edits.front(), labels);
  const bool all_alike = std::all_of(
      edits.begin(), edits.end(), [&](const TableEdit& edit) { return what_it_did(edit, labels) == first; });
  return all_alike ? first : fmt::format("{} and {} more", first, edits.size() - 1);
}

std::vector<Yuv> thinned(std::vector<Yuv> pixels) {
  constexpr std::size_t kMaxPicked = 20'000;
  const std::size_t step = pixels.size() / kMaxPicked + 1;
  if (step == 1) return pixels;
  std::vector<Yuv> out;
  for (std::size_t i = 0; i < pixels.size(); i += step) out.push_back(pixels[i]);
  return out;
}

}  // namespace sslv
