// SPDX-License-Identifier: Apache-2.0
#include "services/backup/backup_service.h"

#include "base/clock.h"
#include "base/error.h"
#include "base/log.h"
#include "base/memory.h"
#include "config/config.h"
#include "config/version.h"
#include "health/computer.h"
#include "services/backup/kept_settings.h"
#include "services/settings/settings_routes.h"
#include "settings/backup_limits.h"
#include "settings/named_files.h"

#include <algorithm>
#include <ctime>
#include <exception>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/chrono.h>

namespace sslv {
namespace {

/// Backup of the state before the newest restore, including profiles and histories.
constexpr const char* kBeforeName = "before_restore.sslvision";

constexpr const char* kBackupType = "application/gzip";

std::string all_bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

/// A backup that was read and is ready to be saved.
struct BackupService::Read {
  BackupManifest manifest;
  KeptSettings settings;
  Json summary;  // summary of the files
  bool has_passwords = false;
  std::vector<std::unique_ptr<SavedWith>> parts;
};

/// All parts of a backup that is being restored. Backs up the data that they replace first.
class BackupService::Restored final : public SavedWith {
 public:
  Restored(StateFolder& folder, std::string before, std::vector<std::unique_ptr<SavedWith>> parts)
      : folder_(folder), before_(std::move(before)), parts_(std::move(parts)) {}

  void save() override {
    try {
      std::error_code error;
      if (std::filesystem::exists(file(), error)) earlier_ = all_bytes_of(file());
      folder_.write(file(), before_);
      is_written_ = true;
      for (const auto& part : parts_) {
        part->save();
        ++saved_;
      }
    } catch (...) {
      take_back();
      throw;
    }
  }

  void take_back() noexcept override {
    for (; saved_ > 0; --saved_) parts_[saved_ - 1]->take_back();
    if (!std::exchange(is_written_, false)) return;
    try {
      std::error_code error;
      earlier_ ? folder_.write(file(), *earlier_) : (void)std::filesystem::remove(file(), error);
    } catch (const std::exception& error) {
      log::error("the backup from before the previous restore was not put back: {}", error.what());
    }
  }

 private:
  std::filesystem::path file() const { return folder_.path() / kBeforeName; }

  StateFolder& folder_;
  const std::string before_;
  const std::vector<std::unique_ptr<SavedWith>> parts_;
  std::optional<std::string> earlier_;
  bool is_written_ = false;
  std::size_t saved_ = 0;
};

BackupService::BackupService(StateFolder& folder, SettingsEditor& settings, Passwords& passwords,
                             Profiles& profiles, std::vector<BackupPart*> parts)
    : folder_(folder),
      settings_(settings),
      passwords_(passwords),
      passwords_part_(passwords),
      profiles_part_(profiles),
      parts_(std::move(parts)) {
  parts_.push_back(&profiles_part_);
  parts_.push_back(&passwords_part_);
}

std::vector<Route> BackupService::routes() {
  return {
      {"GET", "/api/backup", [this](const Request& request) { return get_backup(request); }, Needs::kChange,
       Speed::kTakesMemory},
      {"POST", "/api/backup/check", [this](const Request& request) { return check(request); }, Needs::kChange,
       Speed::kTakesMemory, false, kMaxBackupBytes},
      {"POST", "/api/backup/restore", [this](const Request& request) { return restore(request); },
       Needs::kByMethod, Speed::kTakesMemory, false, kMaxBackupBytes},
  };
}

Backup BackupService::make(bool with_passwords, bool is_whole) const {
  const auto [settings, config] = kept_settings(settings_);
  Backup backup{{unix_time_s(), kVersion, host_name(), config->site}, {}};
  backup.files[kSettingsName] = to_text(settings);
  for (const BackupPart* part : parts_) {
    if (part != &passwords_part_ || with_passwords) backup.files.merge(part->files(*config));
  }
  if (is_whole) check_has_tables(*config, backup.files);
  return backup;
}

Response BackupService::get_backup(const Request& request) {
  const bool with_passwords = query_flag(request, "passwords");
  Backup backup = make(with_passwords, true);
  const BackupManifest from = backup.manifest;
  Response response{200, kBackupType, write_backup(std::move(backup), request.stop)};
  const std::string site = file_name_part(from.site);
  response.headers.emplace_back(
      "Content-Disposition",
      fmt::format("attachment; filename=\"{}-{:%Y%m%d-%H%M%S}.sslvision\"",
                  site.empty() ? from.computer : site, fmt::gmtime(static_cast<std::time_t>(from.time_s))));
  log::info("backup{} made by {}", with_passwords ? " with hashes of passwords" : "", request.address);
  memory_was_used();
  return response;
}

BackupService::Read BackupService::read(const Request& request) {
  Backup backup = read_backup(request.body, request.stop);
  Read out;
  out.manifest = std::move(backup.manifest);
  const auto settings = backup.files.find(kSettingsName);
  if (settings == backup.files.end())
    throw SettingsError(
        fmt::format("{}: is not in the file; expected a backup of ssl-visiond", kSettingsName));
  out.settings = read_kept_settings(settings->second);
  backup.files.erase(settings);
  out.has_passwords = backup.files.contains(Passwords::kFileName);
  out.summary = files_summary(backup.files);
  std::map<BackupPart*, BackupFiles> files;
  while (!backup.files.empty()) {
    auto file = backup.files.extract(backup.files.begin());
    const auto part = std::find_if(parts_.begin(), parts_.end(),
                                   [&](const BackupPart* one) { return one->has(file.key()); });
    if (part == parts_.end()) {
      throw SettingsError(
          fmt::format("{}: is not allowed in a backup; expected {}, {}, calibrations.json, {} and "
                      "tables/*.lut",
                      shortened(file.key()), kSettingsName, Profiles::kFileName, Passwords::kFileName));
    }
    files[*part].insert(std::move(file));
  }
  for (BackupPart* part : parts_) out.parts.push_back(part->prepare(std::move(files[part])));
  return out;
}

Json BackupService::contents_json(const Read& read) {
  Json changes;
  try {
    changes = settings_.check(Json{{{"op", "replace"}, {"path", ""}, {"value", read.settings.tree}}});
  } catch (const SettingsError& error) {
    throw SettingsError(fmt::format("{}: {}", kSettingsName, error.what()));
  }
  Json out{{"time", read.manifest.time_s},
           {"version", read.manifest.version},
           {"computer", read.manifest.computer},
           {"site", read.manifest.site},
           {"cameras", cameras_of(read.settings.tree)},
           {"steps", read.settings.history.size()},
           {"passwords", read.has_passwords},
           {"keeps_passwords", passwords_.has(Role::kAdmin)},
           {"files_elsewhere", Json::array()},
           {"changes", std::move(changes)},
           {"revision", settings_.current().revision}};
  out.update(read.summary);
  static const Json kSchema = settings_schema();
  for (const NamedFile& one : named_files(kSchema, read.settings.tree))
    out["files_elsewhere"].push_back({{"path", one.path}, {"file", one.file.string()}});
  return out;
}

Response BackupService::check(const Request& request) {
  const std::lock_guard lock(mutex_);
  return json_response(contents_json(read(request)));
}

Response BackupService::restore(const Request& request) {
  const std::lock_guard lock(mutex_);
  const auto if_revision = if_match_of(request);
  const std::string before = write_backup(make(false, false), request.stop);
  Read from = read(request);
  const std::string source = from.manifest.site.empty() ? from.manifest.computer : from.manifest.site;
  Restored parts(folder_, before, std::move(from.parts));
  SettingsStore::Version version;
  try {
    version = settings_.restore(from.settings, {request.address, if_revision, "backup of " + source}, &parts);
  } catch (const SettingsError& error) {
    throw SettingsError(fmt::format("{}: {}", kSettingsName, error.what()));
  }
  log::info("settings revision {} saved: a backup of {} made at {:%Y-%m-%d %H:%M:%S} UTC was restored by {}",
            version.revision, source, fmt::gmtime(static_cast<std::time_t>(from.manifest.time_s)),
            request.address);
  Json answer = saved_json(version);
  answer["passwords"] = !from.has_passwords ? "none" : passwords_part_.has_restored() ? "restored" : "kept";
  return json_response(answer);
}

}  // namespace sslv
