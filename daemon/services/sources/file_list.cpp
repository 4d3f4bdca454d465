// SPDX-License-Identifier: Apache-2.0
#include "services/sources/file_list.h"

#include "base/error.h"
#include "base/plain_text.h"
#include "capture/files/file.h"
#include "settings/named_files.h"

#include <algorithm>
#include <string>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sslv {
namespace {

namespace fs = std::filesystem;

/// Limit of the entries read from a folder: enough for an hour of images.
constexpr std::size_t kMaxEntries = 200'000;

bool may_list(const fs::path& path, const std::vector<fs::path>& allowed) {
  return std::any_of(allowed.begin(), allowed.end(),
                     [&](const auto& folder) { return lies_in(path, folder); });
}

Json entry_json(const fs::path& path, const std::string& name, bool is_folder) {
  return {{"name", name}, {"path", path.string()}, {"is_folder", is_folder}};
}

/// Lists the allowed folders that exist.
Json top_json(const std::vector<fs::path>& allowed) {
  Json entries = Json::array();
  for (const fs::path& folder : allowed) {
    std::error_code error;
    if (fs::is_directory(folder, error)) entries.push_back(entry_json(folder, folder.string(), true));
  }
  return {
      {"folder", ""}, {"parent", nullptr}, {"images", 0}, {"entries", std::move(entries)}, {"left_off", 0}};
}

/// The parent folder; "" if that is the list of allowed folders.
std::string parent_of(const fs::path& folder, const std::vector<fs::path>& allowed) {
  const fs::path parent = folder.parent_path();
  return parent != folder && may_list(parent, allowed) ? parent.string() : "";
}

}  // namespace

Json list_files(const fs::path& folder, const std::vector<fs::path>& allowed) {
  if (folder.empty()) return top_json(allowed);
  if (!folder.is_absolute() || !may_list(folder, allowed)) {
    std::vector<std::string> names;
    for (const fs::path& one : allowed) names.push_back(one.string());
    throw SettingsError(fmt::format("folder: \"{}\" is not allowed here; expected a folder in {}",
                                    shortened(folder.string(), 200), fmt::join(names, ", ")));
  }
  std::error_code error;
  const fs::path real = fs::canonical(folder, error);
  fs::directory_iterator i = error ? fs::directory_iterator() : fs::directory_iterator(real, error);
  if (error)
    throw SettingsError(fmt::format("folder: \"{}\": {}", shortened(folder.string(), 200), error.message()));

  struct Entry {
    std::string name;
    bool is_folder;
  };
  std::vector<Entry> entries;
  std::size_t images = 0;
  for (std::size_t n = 0; !error && i != fs::directory_iterator() && n < kMaxEntries;
       i.increment(error), ++n) {
    const std::string name = i->path().filename().string();
    if (name.starts_with('.') || !is_plain_text(name)) continue;
    std::error_code gone;
    const bool is_folder = i->is_directory(gone);
    const RecordingKind kind = recording_kind(i->path());
    if (!is_folder && (kind == RecordingKind::kOther || !i->is_regular_file(gone))) continue;
    // Only a link can lead out of the allowed folders.
    if (i->is_symlink(gone) && !may_list(i->path(), allowed)) continue;
    if (!is_folder && (kind == RecordingKind::kImage || kind == RecordingKind::kRaw)) ++images;
    entries.push_back({name, is_folder});
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.is_folder != b.is_folder ? a.is_folder : a.name < b.name;
  });
  const std::size_t shown = std::min(entries.size(), kMaxListedFiles);
  Json list = Json::array();
  for (std::size_t k = 0; k < shown; ++k)
    list.push_back(entry_json(real / entries[k].name, entries[k].name, entries[k].is_folder));
  return {{"folder", real.string()},
          {"parent", parent_of(real, allowed)},
          {"images", images},
          {"entries", std::move(list)},
          {"left_off", entries.size() - shown}};
}

}  // namespace sslv
