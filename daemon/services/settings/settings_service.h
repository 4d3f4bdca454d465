// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/snapshot.h"
#include "config/config.h"
#include "services/service.h"
#include "services/settings/settings_editor.h"
#include "settings/state_folder.h"

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace sslv {

/// Changes settings: validates and reads them once, plans with all services, saves, applies.
class SettingsService final : public Service, public SettingsEditor {
 public:
  /// `file_folders`: folders in which settings from the network may name files, besides the service's own
  /// folders. `folder` must outlive this. Throws SettingsError.
  SettingsService(const std::filesystem::path& settings_file, StateFolder& folder,
                  std::vector<std::filesystem::path> file_folders);

  /// The settings in effect. Valid as long as this object.
  const Snapshot<Config>& config() const { return config_; }

  /// From now on, `services` plan and apply every change, in this order, beginning with the settings in
  /// effect. Call it before the first request; `services` must outlive all requests. Throws SettingsError.
  void start(std::vector<Service*> services);

  /// Reloads the admin's file and applies it; logs the result.
  void reload();

  // SettingsEditor
  SettingsStore::Version current() const override { return store_.current(); }
  Json history() const override { return store_.history(); }
  SettingsStore::Version patch(const Json& patch, const SettingsEdit& edit,
                               SavedWith* with = nullptr) override;
  Json check(const Json& patch) override;
  SettingsStore::Version restore(const KeptSettings& kept, const SettingsEdit& edit,
                                 SavedWith* with) override;

  // Service
  std::vector<Route> routes() override;
  void report(HealthReport& report) const override;
  void write_metrics(MetricsText& out) const override;
  std::vector<SupportFile> support_files() const override;
  void each_second() override;
  std::vector<Event> take_events() override;

 private:
  std::vector<Plan> plan_all(const CheckedSettings& next, SettingsChange::Origin origin) const;
  /// See SettingsStore::GetReady. `plans` receives the result of plan_all().
  Apply get_ready(const CheckedSettings& next, SettingsChange::Origin origin,
                  const std::shared_ptr<std::vector<Plan>>& plans);
  /// `act` makes the change, given the function that prepares it. The files of `with` are saved together with
  /// the change.
  SettingsStore::Version change(
      SettingsChange::Origin origin, SavedWith* with,
      const std::function<SettingsStore::Version(const SettingsStore::GetReady&)>& act);
  Response patch_settings(const Request& request);
  Response check_settings(const Request& request);
  Response undo_settings(const Request& request);

  StateFolder& folder_;
  const std::vector<std::filesystem::path> file_folders_;
  SettingsStore store_;
  Snapshot<Config> config_;
  std::vector<Service*> services_;
  std::uint64_t told_revision_;           // revision of the newest step reported as an event
  std::atomic<double> since_s_{0};        // Unix time when the newest settings took effect
  Snapshot<std::string> folder_problem_;  // updated once a second: a check may wait for the disk
};

}  // namespace sslv
