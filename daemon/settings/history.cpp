// SPDX-License-Identifier: Apache-2.0
#include "settings/history.h"

#include "base/error.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

Json step_patch(const char* op, const Json& path, const Json* value) {
  Json out{{"op", op}, {"path", path}};
  if (value != nullptr) out["value"] = *value;
  return out;
}

/// Replaces the "-" of "/list/-" by its current index, so that the change can be reverted.
std::string exact(const std::string& path, const Json& now) {
  if (!path.ends_with("/-")) return path;
  const std::string list = path.substr(0, path.size() - 2);
  const Json& parent = now.at(Json::json_pointer(list));
  return parent.is_array() ? list + "/" + std::to_string(parent.size()) : path;
}

bool is_step(const Json& json) {
  return json.is_object() && json.contains("revision") && json["revision"].is_number_unsigned() &&
         json.contains("time") && json.contains("who") && json.contains("what") && json.contains("changes") &&
         json["changes"].is_array();
}

bool is_change(const Json& json) {
  if (!json.is_object() || !json.contains("op") || !json.contains("path") || !json["path"].is_string())
    return false;
  const bool adds = json["op"] == "add", removes = json["op"] == "remove";
  return (adds || removes || json["op"] == "replace") && json.contains("before") == !adds &&
         json.contains("after") == !removes;
}

/// Adds a replacement for each part of a tree that compares equal but is not identical; each part is as small
/// as possible.
void add_exact(const Json& before, const Json& after, const Json::json_pointer& at, Json& patch) {
  const auto same_keys = [&] {
    return std::equal(before.items().begin(), before.items().end(), after.items().begin(),
                      [](const auto& one, const auto& other) { return one.key() == other.key(); });
  };
  if (before.type() != after.type() || before.size() != after.size() ||
      (before.is_object() && !same_keys()) || (before.is_primitive() && before != after)) {
    patch.push_back({{"op", "replace"}, {"path", at.to_string()}, {"value", after}});
  } else if (before.is_object()) {
    for (const auto& [key, value] : before.items()) add_exact(value, after.at(key), at / key, patch);
  } else if (before.is_array()) {
    for (std::size_t i = 0; i < before.size(); ++i) add_exact(before[i], after[i], at / i, patch);
  }
}

}  // namespace

Json changes_between(const Json& before, const Json& after) {
  Json changes = Json::array();
  Json now = before;
  for (const Json& step : Json::diff(before, after)) {
    const std::string op = step.at("op").get<std::string>();
    const std::string path = exact(step.at("path").get<std::string>(), now);
    Json change{{"op", op}, {"path", path}};
    if (op != "add") change["before"] = now.at(Json::json_pointer(path));
    if (op != "remove") change["after"] = step.at("value");
    now.patch_inplace(Json::array({step}));
    changes.push_back(std::move(change));
  }
  return changes;
}

Json changes_below(const Json& changes, const std::vector<std::string>& paths) {
  Json out = Json::array();
  for (const Json& change : changes) {
    const std::string at = change.at("path").get<std::string>() + "/";
    if (std::any_of(paths.begin(), paths.end(), [&](const auto& path) { return at.starts_with(path + "/"); }))
      out.push_back(change);
  }
  return out;
}

Json forward_patch(const Json& changes) {
  Json out = Json::array();
  for (const Json& change : changes) {
    const Json* after = change.contains("after") ? &change["after"] : nullptr;
    out.push_back(step_patch(change.at("op").get<std::string>().c_str(), change.at("path"), after));
  }
  return out;
}

Json backward_patch(const Json& changes) {
  Json out = Json::array();
  for (auto change = changes.rbegin(); change != changes.rend(); ++change) {
    const std::string op = change->at("op").get<std::string>();
    const char* back = op == "add" ? "remove" : op == "remove" ? "add" : "replace";
    out.push_back(step_patch(back, change->at("path"), op == "add" ? nullptr : &change->at("before")));
  }
  return out;
}

Json exact_patch(const Json& before, const Json& after) {
  Json patch = Json::diff(before, after);
  add_exact(before.patch(patch), after, Json::json_pointer(), patch);
  return patch;
}

void check_steps(const Json& steps, std::uint64_t revision) {
  if (!steps.is_array()) throw SettingsError("/history: is not allowed; expected a list of steps");
  std::uint64_t most = revision;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Json& step = steps[i];
    const bool is_good = is_step(step) && step["time"].is_number() && step["who"].is_string() &&
                         step["what"].is_string() && step["revision"] > 0U && step["revision"] <= most &&
                         std::all_of(step["changes"].begin(), step["changes"].end(), is_change);
    if (!is_good) {
      throw SettingsError(fmt::format(
          "/history/{}: is not a step of the settings; expected a revision of at most {}, with time, who, "
          "what and changes",
          i, most));
    }
    most = step["revision"].get<std::uint64_t>() - 1;
  }
}

SettingsHistory::SettingsHistory(const Json& saved) {
  if (!saved.is_array()) return;
  for (const Json& step : saved) {
    if (is_step(step)) add(step);
  }
}

void SettingsHistory::add(SettingsStep step) {
  sizes_.push_back(json_text(step).size());
  bytes_ += sizes_.back();
  steps_.push_back(std::move(step));
  // Keeps the newest step, however large it is.
  while (steps_.size() > 1 && (steps_.size() > kMaxSteps || bytes_ > kMaxBytes)) {
    bytes_ -= sizes_.front();
    sizes_.erase(sizes_.begin());
    steps_.erase(steps_.begin());
  }
}

void SettingsHistory::join(SettingsStep step) {
  constexpr double kLongest_s = 60;
  const auto same = [&](const char* key) { return steps_.back()[key] == step[key]; };
  const auto replaces_same = [&] {
    const Json &old = steps_.back()["changes"], &now = step["changes"];
    return std::equal(old.begin(), old.end(), now.begin(), now.end(), [](const Json& a, const Json& b) {
      return a["op"] == "replace" && b["op"] == "replace" && a["path"] == b["path"];
    });
  };
  const auto is_soon = [&] {  // abs(): the clock may have been set back
    return std::abs(step["time"].get<double>() - steps_.back()["time"].get<double>()) < kLongest_s;
  };
  const bool joins = !steps_.empty() && same("who") && same("what") && replaces_same() && is_soon();
  if (joins) {
    for (std::size_t i = 0; i < step["changes"].size(); ++i)
      step["changes"][i]["before"] = steps_.back()["changes"][i]["before"];
    bytes_ -= sizes_.back();
    sizes_.pop_back();
    steps_.pop_back();
  }
  add(std::move(step));
}

const SettingsStep* SettingsHistory::find(std::uint64_t revision) const {
  const auto found = std::find_if(steps_.begin(), steps_.end(),
                                  [=](const Json& step) { return step["revision"] == revision; });
  return found == steps_.end() ? nullptr : &*found;
}

Json SettingsHistory::newer_than(std::uint64_t revision) const {
  Json out = Json::array();
  for (auto step = steps_.rbegin(); step != steps_.rend() && (*step)["revision"] > revision; ++step)
    out.push_back(*step);
  return out;
}

}  // namespace sslv
