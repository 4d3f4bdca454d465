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

/// Carries out changes of settings: checked and read once, planned by all services, saved, applied.
class SettingsService final : public Service, public SettingsEditor {
 public:
  /// `file_folders`: where settings that come over the network may name files, besides those of the service
  /// itself. `folder` must outlive this. Throws SettingsError.
  SettingsService(const std::filesystem::path& settings_file, StateFolder& folder,
                  std::vector<std::filesystem::path> file_folders);

  /// Those in effect. Lives as long as this.
  const Snapshot<Config>& config() const { return config_; }

  /// These plan and apply every change, in this order; the settings in effect are their first. They must
  /// outlive all requests, which come later. Throws SettingsError.
  void start(std::vector<Service*> services);

  /// Reads the admin's file again and applies it; logs what came of it.
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
  /// See SettingsStore::GetReady. `plans`: what came of plan_all().
  Apply get_ready(const CheckedSettings& next, SettingsChange::Origin origin,
                  const std::shared_ptr<std::vector<Plan>>& plans);
  /// Files that belong to it are saved with it. `act` makes it, given what gets it ready.
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
  std::uint64_t told_revision_;           // of the newest step that was an event
  std::atomic<double> since_s_{0};        // Unix time when the newest settings took effect
  Snapshot<std::string> folder_problem_;  // as it was seen last: looking may take as long as the disk does
};

}  // namespace sslv
