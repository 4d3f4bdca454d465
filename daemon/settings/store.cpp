// SPDX-License-Identifier: Apache-2.0
#include "settings/store.h"

#include "base/clock.h"
#include "base/log.h"
#include "base/memory.h"
#include "settings/bounded_patch.h"

#include <algorithm>
#include <functional>
#include <system_error>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Changes refer to elements of a list by index. Throws SettingsError if a change refers to an element with
/// an "id" and the index now has another id: the admin has reordered the list.
void check_same_ids(const Json& changes, const Json& made_on, const Json& put_on) {
  for (const Json& change : changes) {
    const std::string path = change.at("path").get<std::string>();
    for (std::size_t end = path.find('/', 1); end != std::string::npos; end = path.find('/', end + 1)) {
      const Json::json_pointer id(path.substr(0, end) + "/id");
      if (!made_on.contains(id) || !put_on.contains(id) || made_on.at(id) == put_on.at(id)) continue;
      throw SettingsError(fmt::format("{}: the saved change was made when {} was {}, but it is now {}", path,
                                      id.to_string(), json_text(made_on.at(id)), json_text(put_on.at(id))));
    }
  }
}

/// Copies from `made_on` the values that the changes refer to and that `put_on` lacks: parameters of a stage
/// whose library is missing at present or has another version. Validation of the whole tree refuses anything
/// unknown.
void add_absent(const Json& changes, const Json& made_on, Json& put_on) {
  for (const Json& change : changes) {
    const std::string path = change.at("path").get<std::string>();
    for (std::size_t end = 0; end < path.size();) {
      end = std::min(path.find('/', end + 1), path.size());
      const Json::json_pointer place(path.substr(0, end));
      if (put_on.contains(place)) continue;
      const Json::json_pointer above = place.parent_pointer();
      if (made_on.contains(place) && put_on.contains(above) && put_on.at(above).is_object())
        put_on[place] = made_on.at(place);
      break;
    }
  }
}

}  // namespace

SettingsStore::SettingsStore(std::filesystem::path admin_file, StateFolder& folder, Check check,
                             Migrations migrations)
    : admin_file_(std::move(admin_file)),
      folder_(folder),
      check_(std::move(check)),
      migrations_(std::move(migrations)) {
  for (const auto& own : {changes_file(), previous_file()}) {
    std::error_code error;
    if (std::filesystem::equivalent(admin_file_, own, error)) {
      throw SettingsError(fmt::format(
          "{}: the service saves the panel's changes in this file; move your settings to another folder",
          admin_file_.string()));
    }
  }
  Json as_written;
  CheckedSettings admin = read_admin_file(&as_written);
  admin_settings_ = admin.tree;
  version_ = {1, std::move(admin.tree), std::move(admin.config)};
  for (const auto& file : {changes_file(), previous_file()}) remove_leftover(file);
  for (const auto& file : {changes_file(), previous_file()}) {
    if (const auto loaded = load_changes(file, as_written)) {
      version_ = *loaded;
      break;
    }
  }
  revision_ = version_.revision;
}

CheckedSettings SettingsStore::checked(Json tree) const {
  return check_any_version(std::move(tree), migrations_, check_);
}

CheckedSettings SettingsStore::read_admin_file(Json* as_written) const {
  Json file = read_json_file(admin_file_);
  if (as_written != nullptr) *as_written = file;
  try {
    return check_(up_to_date(std::move(file), migrations_));
  } catch (const SettingsError& error) {
    throw SettingsError(fmt::format("{}: {}", admin_file_.string(), error.what()));
  }
}

std::optional<SettingsStore::Version> SettingsStore::load_changes(const std::filesystem::path& file,
                                                                  const Json& admin_as_written) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return std::nullopt;
  try {
    const Json saved = read_json_file(file);
    if (!saved.is_object() || !saved.contains("revision") || !saved["revision"].is_number_unsigned() ||
        !saved.contains("changes")) {
      throw SettingsError("it contains no saved changes");
    }
    const int version = version_of(saved, migrations_);
    Json changes = saved.at("changes");
    // Files that were written before there were versions lack the tree; the admin's tree is used for them.
    Json made_on = saved.value("made_on", Json());
    if (version < newest_version(migrations_)) {
      // A patch fits only the version it was made for.
      if (made_on.is_null()) {
        made_on = admin_as_written;
        made_on.erase(kVersionKey);
      }
      const Json changed = check_(migrated(apply_patch(made_on, changes), version, migrations_)).tree;
      made_on = check_(migrated(made_on, version, migrations_)).tree;
      changes = Json::diff(made_on, changed);
    }
    Json put_on = admin_settings_;
    if (!made_on.is_null()) {
      check_same_ids(changes, made_on, admin_settings_);
      add_absent(changes, made_on, put_on);
    }
    CheckedSettings result = check_(apply_patch(std::move(put_on), changes));
    Version loaded{saved.at("revision").get<std::uint64_t>(), std::move(result.tree),
                   std::move(result.config)};
    history_ = SettingsHistory(saved.value("history", Json::array()));
    return loaded;
  } catch (const std::exception& error) {
    const std::string text =
        fmt::format("saved changes in {} do not fit {} and were set aside as {}: {}", file.string(),
                    admin_file_.string(), set_aside(file).string(), error.what());
    log::error("{}", text);
    problem_ += (problem_.empty() ? "" : "; ") + text;
    return std::nullopt;
  }
}

SettingsStore::Version SettingsStore::current() const {
  const std::lock_guard lock(mutex_);
  return version_;
}

Json SettingsStore::history() const {
  const std::lock_guard lock(mutex_);
  return history_.newer_than(0);
}

SettingsStore::Version SettingsStore::patch(const Json& patch, const SettingsEdit& edit,
                                            const GetReady& get_ready) {
  // The patch is applied before locking, since this may take long, and again only if another edit intervenes.
  const Version before = current();
  std::optional<Json> patched;
  if (!edit.if_revision || *edit.if_revision == before.revision)
    patched = apply_patch(before.settings, patch);
  const std::lock_guard lock(edits_);
  check_revision(edit);
  if (version_.revision != before.revision || !patched) patched = apply_patch(version_.settings, patch);
  return change(std::move(*patched), edit, get_ready);
}

Json SettingsStore::check(const Json& patch, const std::function<void(const CheckedSettings&)>& plan) const {
  const Json before = current().settings;
  const CheckedSettings after = checked(apply_patch(before, patch));
  plan(after);
  return changes_between(before, after.tree);
}

bool SettingsStore::are_same_cameras(const SettingsStep& step) const {
  if (changes_below(step.at("changes"), {"/cameras"}).empty()) return true;
  try {
    Json then = version_.settings;  // becomes the settings right after the step
    for (const SettingsStep& newer : history_.newer_than(step.at("revision").get<std::uint64_t>()))
      then.patch_inplace(backward_patch(newer.at("changes")));
    const auto id_at = [](const Json& tree, std::size_t i) {
      return tree.value(Json::json_pointer(fmt::format("/cameras/{}/id", i)), Json());
    };
    const std::size_t count = then.value("cameras", Json::array()).size();
    for (std::size_t i = 0; i < count; ++i) {
      const bool is_touched = !changes_below(step.at("changes"), {fmt::format("/cameras/{}", i)}).empty();
      if (is_touched && id_at(then, i) != id_at(version_.settings, i)) return false;
    }
    return true;
  } catch (const Json::exception&) {  // the changes do not fit the tree
    return false;
  }
}

SettingsStore::Version SettingsStore::undo(std::uint64_t revision, const SettingsEdit& edit,
                                           const GetReady& get_ready) {
  const std::lock_guard lock(edits_);
  const SettingsStep* step = history_.find(revision);
  if (step == nullptr)
    throw SettingsError(fmt::format("revision: {} is not allowed; expected one of the history", revision));
  const Json& changes = step->at("changes");
  // Nobody changed the step's values again if reverting and repeating the step yields the current tree.
  const auto is_as_left = [&] {
    try {
      const Json there_and_back =
          checked(version_.settings.patch(backward_patch(changes)).patch(forward_patch(changes))).tree;
      return Json::diff(there_and_back, version_.settings).empty();  // ignores the order of keys
    } catch (const Json::exception&) {                               // a place no longer exists
    } catch (const SettingsError&) {                                 // or the result is invalid
    }
    return false;
  };
  if (!are_same_cameras(*step) || !is_as_left()) {
    throw StaleRevision(fmt::format("the values of revision {} have changed since", revision),
                        version_.revision, history_.newer_than(revision));
  }
  SettingsEdit named = edit;
  named.what = fmt::format("undo of revision {}", revision);
  check_revision(named);
  return change(apply_patch(version_.settings, backward_patch(changes)), named, get_ready);
}

void SettingsStore::check_revision(const SettingsEdit& edit) const {
  if (edit.if_revision && *edit.if_revision != version_.revision) {
    throw StaleRevision(fmt::format("the settings are at revision {}, but this edit was made on {}",
                                    version_.revision, *edit.if_revision),
                        version_.revision, history_.newer_than(*edit.if_revision));
  }
}

SettingsStore::Version SettingsStore::change(Json tree, const SettingsEdit& edit, const GetReady& get_ready) {
  return change(std::move(tree), history_, version_.revision, edit, get_ready);
}

SettingsStore::Version SettingsStore::change(Json tree, SettingsHistory history, std::uint64_t revision,
                                             const SettingsEdit& edit, const GetReady& get_ready) {
  const CheckedSettings result = checked(std::move(tree));
  Json changes = changes_between(version_.settings, result.tree);
  if (edit.what.empty() && changes.empty()) return version_;  // operations are kept: they change files, too
  Version next{revision + 1, result.tree, result.config};
  const Apply apply = get_ready(result);

  SettingsStep step{{"revision", next.revision},
                    {"time", unix_time_s()},
                    {"who", edit.who},
                    {"what", edit.what},
                    {"changes", std::move(changes)}};
  edit.joins ? history.join(std::move(step)) : history.add(std::move(step));
  save(next, admin_settings_, history);
  Version answer = next;
  apply();  // from here on nothing fails
  take(std::move(next), std::move(history));
  return answer;
}

SettingsStore::Version SettingsStore::restore(const Json& tree, std::uint64_t revision, const Json& history,
                                              const SettingsEdit& edit, const GetReady& get_ready) {
  check_steps(history, revision);
  Json steps = Json::array();  // oldest first
  for (auto step = history.rbegin(); step != history.rend(); ++step) steps.push_back(*step);
  const Json patch{{{"op", "replace"}, {"path", ""}, {"value", tree}}};
  const std::lock_guard lock(edits_);
  check_revision(edit);
  return change(apply_patch(version_.settings, patch), SettingsHistory(steps),
                std::max(revision, version_.revision), edit, get_ready);
}

void SettingsStore::take(Version version, SettingsHistory history) noexcept {
  memory_was_used();  // for old and new trees, patches, pipelines and masks
  const std::lock_guard lock(mutex_);
  std::swap(version_, version);
  revision_ = version_.revision;
  std::swap(history_, history);
}

SettingsStore::Version SettingsStore::reload(const GetReady& get_ready) {
  const std::lock_guard lock(edits_);
  try {
    Version version = reload_now(get_ready);
    reload_problem_.store("");
    return version;
  } catch (const std::exception& error) {
    reload_problem_.store(error.what());
    throw;
  }
}

SettingsStore::Version SettingsStore::reload_now(const GetReady& get_ready) {
  Json admin = read_admin_file().tree;
  if (Json::diff(admin, admin_settings_).empty()) return version_;
  const Json changes = Json::diff(admin_settings_, version_.settings);
  Version next = version_;
  SettingsHistory history = history_;
  Apply apply;
  try {
    check_same_ids(changes, admin_settings_, admin);
    const CheckedSettings result = check_(apply_patch(admin, changes));
    next.settings = result.tree;
    if (!Json::diff(next.settings, version_.settings).empty()) {
      ++next.revision;
      next.config = result.config;
      apply = get_ready(result);
      history.add({{"revision", next.revision},
                   {"time", unix_time_s()},
                   {"who", ""},
                   {"what", "reload of " + admin_file_.string()},
                   {"changes", changes_between(version_.settings, next.settings)}});
    }
  } catch (const SettingsError& error) {
    throw SettingsError(
        fmt::format("{}: {}{}", admin_file_.string(),
                    changes.empty() ? "" : "together with the panel's changes: ", error.what()));
  }
  save(next, admin, history);
  Version answer = next;
  apply();  // from here on nothing fails
  admin_settings_ = std::move(admin);
  take(std::move(next), std::move(history));
  return answer;
}

void SettingsStore::save(const Version& version, const Json& admin_settings, const SettingsHistory& history) {
  const Json saved{{kVersionKey, newest_version(migrations_)},
                   {"revision", version.revision},
                   {"changes", exact_patch(admin_settings, version.settings)},
                   {"made_on", admin_settings},
                   {"history", history.to_json()}};
  folder_.write(changes_file(), json_text(saved, 2) + "\n", previous_file());
}

}  // namespace sslv
