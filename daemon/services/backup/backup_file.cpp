// SPDX-License-Identifier: Apache-2.0
#include "services/backup/backup_file.h"

#include "base/error.h"
#include "base/params.h"
#include "base/params_json.h"
#include "base/sha256.h"
#include "settings/backup_limits.h"
#include "web/tar_file.h"

#include <algorithm>
#include <ctime>
#include <exception>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr const char* kManifestName = "manifest.json";
constexpr const char* kSumsName = "SHA256SUMS";
constexpr const char* kFormat = "ssl-visiond backup";
constexpr int kFormatVersion = 1;

/// File format of the manifest.
struct ManifestFile {
  std::string format = kFormat;
  int format_version = kFormatVersion;
  double time_s = 0;
  std::string version, computer, site;
  static constexpr auto fields() {
    using M = ManifestFile;
    constexpr double kFarFuture = 1e12;
    return std::tuple{text("format", &M::format, "what this is"),
                      number("format_version", &M::format_version, 1, kFormatVersion, "", "of the backup"),
                      text("version", &M::version, "of the program that made it"),
                      number("time", &M::time_s, 0.0, kFarFuture, "s", "Unix time when it was made"),
                      text("computer", &M::computer, "where it was made"),
                      text("site", &M::site, "of its settings")};
  }
};

[[noreturn]] void refuse_backup(const std::string& text) {
  throw SettingsError(text);
}

/// Checks the format version first: everything else may differ in a newer program's manifest.
BackupManifest manifest_in(const std::string& text) {
  Json json;
  try {
    json = parse_bounded_json(text);
  } catch (const std::exception& error) {
    refuse_backup(fmt::format("{}: {}", kManifestName, error.what()));
  }
  if (!json.is_object() || !json.contains("format") || json["format"] != kFormat) {
    refuse_backup(
        fmt::format("{}: /format: is not the format of a backup; expected \"{}\"", kManifestName, kFormat));
  }
  const Json version = json.value("format_version", Json());
  if (version.is_number_integer() && version > kFormatVersion) {
    refuse_backup(fmt::format(
        "{}: /format_version: {} is newer than this program, which reads backups up to {}; install "
        "the program that made it, {}",
        kManifestName, json_text(version), kFormatVersion,
        shortened(json_text(json.value("version", Json())))));
  }
  try {
    auto file = params_from_json<ManifestFile>(json, "");
    return {file.time_s, std::move(file.version), std::move(file.computer), std::move(file.site)};
  } catch (const SettingsError& error) {
    refuse_backup(fmt::format("{}: {}", kManifestName, error.what()));
  }
}

/// In the format of `sha256sum`.
std::string sums_of(const BackupFiles& files) {
  std::string out;
  for (const auto& [name, content] : files) out += fmt::format("{}  {}\n", sha256_of(content), name);
  return out;
}

BackupFiles unpacked(std::string_view bytes, const std::stop_token& stop) {
  std::vector<TarEntry> entries;
  if (bytes.empty()) refuse_backup("the file is empty; expected a backup");
  try {
    entries = read_tar_gz(bytes, kMaxUnpackedBackupBytes, stop);
  } catch (const std::runtime_error& error) {
    refuse_backup(fmt::format("this is not a complete backup: {}", error.what()));
  }
  BackupFiles files;
  for (TarEntry& entry : entries) {
    const std::string name = entry.name;
    if (!files.emplace(std::move(entry.name), std::move(entry.content)).second)
      refuse_backup(fmt::format("{}: is in the backup twice", shortened(name)));
  }
  return files;
}

/// Throws SettingsError naming the file that is damaged according to the checksums.
void check_sums(const BackupFiles& files, std::string_view sums) {
  std::set<std::string_view> left;
  for (const auto& [name, content] : files) left.insert(name);
  for (std::size_t at = 0; at < sums.size();) {
    const std::size_t end = std::min(sums.find('\n', at), sums.size());
    const std::string_view line = sums.substr(at, end - at);
    at = end + 1;
    const std::size_t gap = line.find("  ");
    const std::string name(gap == std::string_view::npos ? "" : line.substr(gap + 2));
    if (left.erase(name) == 0) {
      refuse_backup(
          fmt::format("{}: names \"{}\", which is not in the backup exactly once; the file is damaged",
                      kSumsName, shortened(name)));
    }
    if (sha256_of(files.at(name)) != line.substr(0, gap)) {
      refuse_backup(fmt::format(
          "{}: its SHA-256 differs from the one in {}; the file is damaged, use another copy of it", name,
          kSumsName));
    }
  }
  if (!left.empty())
    refuse_backup(fmt::format("{}: has no line in {}", shortened(std::string(*left.begin())), kSumsName));
}

}  // namespace

std::string write_backup(Backup backup, const std::stop_token& stop) {
  const BackupManifest& from = backup.manifest;
  const ManifestFile manifest{kFormat, kFormatVersion, from.time_s, from.version, from.computer, from.site};
  BackupFiles& files = backup.files;
  files[kManifestName] = json_text(params_to_json(manifest), 2) + "\n";
  std::string sums = sums_of(files);
  std::size_t size = sums.size();
  std::vector<TarEntry> entries{{kManifestName, ""}};
  for (auto& [name, content] : files) {
    size += content.size();
    TarEntry& entry = name == kManifestName ? entries.front() : entries.emplace_back(TarEntry{name, ""});
    entry.content = std::move(content);
  }
  entries.push_back({kSumsName, std::move(sums)});
  std::string bytes = tar_gz(entries, static_cast<std::time_t>(from.time_s), stop);
  if (size > kMaxUnpackedBackupBytes || bytes.size() > kMaxBackupBytes) {
    throw StorageError(
        fmt::format("the backup would be larger than {} MiB, or {} MiB unpacked; delete profiles, or tables "
                    "that no camera uses",
                    kMaxBackupBytes >> 20U, kMaxUnpackedBackupBytes >> 20U));
  }
  return bytes;
}

Backup read_backup(std::string_view bytes, const std::stop_token& stop) {
  BackupFiles files = unpacked(bytes, stop);
  const auto take = [&](const char* name) {
    const auto found = files.find(name);
    if (found == files.end())
      refuse_backup(fmt::format("{}: is not in the file; expected a backup of ssl-visiond", name));
    return found;
  };
  BackupManifest manifest = manifest_in(take(kManifestName)->second);
  const auto sums = take(kSumsName);
  const std::string text = std::move(sums->second);
  files.erase(sums);
  check_sums(files, text);
  files.erase(kManifestName);
  return {std::move(manifest), std::move(files)};
}

}  // namespace sslv
