// SPDX-License-Identifier: Apache-2.0
#include "services/settings/settings_service.h"

#include "base/clock.h"
#include "base/log.h"
#include "base/params_json.h"
#include "base/plain_text.h"
#include "config/missing_stages.h"
#include "health/metrics_text.h"
#include "services/settings/settings_events.h"
#include "services/settings/settings_report.h"
#include "services/settings/settings_routes.h"
#include "settings/named_files.h"

#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

CheckedSettings check_tree(const Json& settings) {
  auto config = std::make_shared<const Config>(read_config(settings));
  return {params_to_json(*config), std::move(config)};
}

/// Shortens a change for the log; the settings' history contains the whole change.
std::string in_short(const Json& patch) {
  constexpr std::size_t kMaxBytes = 300;
  std::string text = escaped_text(json_text(patch));
  if (text.size() <= kMaxBytes) return text;
  std::size_t end = kMaxBytes;
  while ((static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;  // do not split a UTF-8 character
  return text.substr(0, end) + " ...";
}

Json answer_of(const SettingsStore::Version& version) {
  return {{"revision", version.revision},
          {"version", newest_version(settings_migrations())},
          {"settings", version.settings}};
}

std::string indented(const Json& json) {
  return json_text(json, 2) + "\n";
}

/// Answers an edit of an older revision with HttpError 409 and the changes since.
template <class Act>
SettingsStore::Version answering_stale(Act act) {
  try {
    return act();
  } catch (const StaleRevision& error) {
    throw HttpError(409, error.what(),
                    {{"revision", error.revision}, {"changed_since", error.changed_since}});
  }
}

}  // namespace

SettingsService::SettingsService(const std::filesystem::path& settings_file, StateFolder& folder,
                                 std::vector<std::filesystem::path> file_folders)
    : folder_(folder),
      file_folders_(std::move(file_folders)),
      store_(settings_file, folder, check_tree, settings_migrations()),
      config_(store_.current().config),
      told_revision_(store_.revision()),
      folder_problem_(folder.find_problem()) {}

void SettingsService::start(std::vector<Service*> services) {
  services_ = std::move(services);
  const SettingsStore::Version version = store_.current();
  const CheckedSettings settings{version.settings, version.config};
  get_ready(settings, SettingsChange::Origin::kStart, std::make_shared<std::vector<Plan>>())();
}

std::vector<Plan> SettingsService::plan_all(const CheckedSettings& next,
                                            SettingsChange::Origin origin) const {
  const auto now = config_.load();
  if (origin == SettingsChange::Origin::kNetwork) {
    static const Json kSchema = settings_schema();
    check_named_files(kSchema, next.tree, {store_.current().settings}, file_folders_);
    refuse_new_missing(*now, *next.config);
  }
  std::vector<Plan> plans;
  for (const Service* service : services_) plans.push_back(service->plan({*now, *next.config, origin}));
  return plans;
}

Apply SettingsService::get_ready(const CheckedSettings& next, SettingsChange::Origin origin,
                                 const std::shared_ptr<std::vector<Plan>>& plans) {
  *plans = plan_all(next, origin);
  for (const Plan& plan : *plans) plan.get_ready();
  return [this, config = next.config, plans]() noexcept {
    config_.store(config);
    for (const Plan& plan : *plans) plan.apply();
    since_s_ = unix_time_s();
  };
}

SettingsStore::Version SettingsService::change(
    SettingsChange::Origin origin, SavedWith* with,
    const std::function<SettingsStore::Version(const SettingsStore::GetReady&)>& act) {
  const auto plans = std::make_shared<std::vector<Plan>>();
  bool is_saved = false;
  SettingsStore::Version version;
  try {
    version = answering_stale([&] {
      return act([&](const CheckedSettings& next) {
        const Apply apply = get_ready(next, origin, plans);
        if (with) with->save();
        is_saved = with != nullptr;
        return apply;
      });
    });
  } catch (...) {
    if (is_saved) with->take_back();
    throw;
  }
  // Waits for devices here, where it blocks no other change of settings.
  for (const Plan& plan : *plans) {
    for (std::string& refusal : plan.outcome()) {
      log::warning("settings revision {}: {}", version.revision, refusal);
      version.refused.push_back(std::move(refusal));
    }
  }
  return version;
}

void SettingsService::reload() {
  const std::uint64_t before = store_.revision();
  try {
    const auto version = change(SettingsChange::Origin::kAdminFile, nullptr,
                                [this](const auto& get_ready) { return store_.reload(get_ready); });
    if (version.revision == before) {
      since_s_ = unix_time_s();
      log::info("settings file reloaded: nothing has changed");
    } else {
      log::info("settings revision {} saved: settings file reloaded", version.revision);
    }
  } catch (const std::exception& error) {
    log::error("settings file not reloaded, the previous settings stay in effect: {}", error.what());
  }
}

SettingsStore::Version SettingsService::patch(const Json& patch, const SettingsEdit& edit, SavedWith* with) {
  return change(SettingsChange::Origin::kNetwork, with,
                [&](const auto& get_ready) { return store_.patch(patch, edit, get_ready); });
}

Json SettingsService::check(const Json& patch) {
  return store_.check(patch, [this](const CheckedSettings& next) {
    plan_all(next, SettingsChange::Origin::kNetwork);  // a dry run ends here
  });
}

SettingsStore::Version SettingsService::restore(const KeptSettings& kept, const SettingsEdit& edit,
                                                SavedWith* with) {
  return change(SettingsChange::Origin::kNetwork, with, [&](const auto& get_ready) {
    return store_.restore(kept.tree, kept.revision, kept.history, edit, get_ready);
  });
}

std::vector<Route> SettingsService::routes() {
  return {
      {"GET", "/api/settings", [this](const Request&) { return json_response(answer_of(store_.current())); }},
      {"PATCH", "/api/settings", [this](const Request& request) { return patch_settings(request); }},
      {"POST", "/api/settings/check", [this](const Request& request) { return check_settings(request); },
       Needs::kChange},
      {"GET", "/api/settings/history", [this](const Request&) { return json_response(store_.history()); }},
      {"POST", "/api/settings/undo", [this](const Request& request) { return undo_settings(request); }},
      {"GET", "/api/schema", [](const Request&) { return json_response(settings_schema()); }},
      {"GET", "/api/field/presets", [](const Request&) { return json_response(field_presets_json()); }},
  };
}

Response SettingsService::patch_settings(const Request& request) {
  const Json json = parse_json(request.body);
  const bool joins = query_flag(request, "joins");
  const std::uint64_t before = store_.revision();
  const auto version =
      patch(json, {.who = request.address, .if_revision = if_match_of(request), .joins = joins});
  if (version.revision == before) return json_response(saved_json(version));  // nothing has changed
  log::info("settings revision {} saved, changed by {}: {}", version.revision, request.address,
            in_short(json));
  return json_response(saved_json(version));
}

Response SettingsService::check_settings(const Request& request) {
  Response response = json_response({{"changes", check(parse_json(request.body))}});
  response.only_tried = true;
  return response;
}

Response SettingsService::undo_settings(const Request& request) {
  const Json body = parse_json(request.body);
  if (!body.is_object() || !body.contains("revision") || !body["revision"].is_number_unsigned())
    throw HttpError(400, "revision: expected the number of a step of the history");
  const auto revision = body["revision"].get<std::uint64_t>();
  const auto version = change(SettingsChange::Origin::kNetwork, nullptr, [&](const auto& get_ready) {
    return store_.undo(revision, {request.address}, get_ready);
  });
  log::info("settings revision {} saved, revision {} undone by {}", version.revision, revision,
            request.address);
  return json_response(saved_json(version));
}

void SettingsService::report(HealthReport& report) const {
  report_settings({.start_problem = store_.problem(),
                   .save_problem = folder_.write_problem(),
                   .folder_problem = *folder_problem_.load(),
                   .reload_problem = store_.reload_problem()},
                  report);
  if (!report.status) return;
  const auto config = config_.load();
  report.status->update(Json{{"site", config->site},
                             {"field", params_to_json<FieldSize>(config->field)},
                             {"settings_revision", store_.revision()}});
}

void SettingsService::write_metrics(MetricsText& out) const {
  out.begin("sslv_config_last_reload_success_timestamp_seconds", "gauge",
            "Unix time when the newest settings took effect.");
  out.add({}, since_s_);
}

std::vector<SupportFile> SettingsService::support_files() const {
  return {{"settings.json", "all settings in effect, with defaults",
           [this] { return indented(answer_of(store_.current())); }},
          {"settings_history.json", "who changed which setting, with the clients' addresses",
           [this] { return indented(store_.history()); }}};
}

void SettingsService::each_second() {
  folder_problem_.store(folder_.find_problem());
}

std::vector<Event> SettingsService::take_events() {
  if (store_.revision() == told_revision_) return {};
  const Json steps = store_.history();
  std::vector<Event> out;
  for (const Json& step : steps) {  // the newest first
    if (step.at("revision") <= told_revision_) break;
    out.insert(out.begin(), event_of(step));
  }
  if (!steps.empty()) told_revision_ = steps.front().at("revision").get<std::uint64_t>();
  return out;
}

}  // namespace sslv
