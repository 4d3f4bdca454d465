// SPDX-License-Identifier: Apache-2.0
#include "services/colors/saved_tables.h"

#include "base/error.h"
#include "base/log.h"
#include "base/sha256.h"
#include "config/config.h"
#include "settings/backup_limits.h"
#include "settings/state_folder.h"
#include "vision/lut_codec.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <optional>
#include <span>
#include <string_view>
#include <system_error>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr std::size_t kNameLength = 16;

constexpr std::string_view kTableFolder = "tables/", kTableExtension = ".lut";

std::string_view chars_of(std::span<const std::uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::span<const std::uint8_t> bytes_in_text(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// The name of a table, from the content of its file.
std::string table_name_of(std::string_view bytes) {
  return sha256_of(bytes).substr(0, kNameLength);
}

/// Whether it is a table's name and thus safe in a path.
bool is_name(std::string_view name) {
  return name.size() == kNameLength && name.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

std::string file_name_of(const std::string& name) {
  return fmt::format("{}{}{}", kTableFolder, name, kTableExtension);
}

/// The name of the table in a backup's file; empty if the file is not a table.
std::string table_name_in(std::string_view file_name) {
  if (!file_name.starts_with(kTableFolder) || !file_name.ends_with(kTableExtension)) return "";
  file_name.remove_prefix(kTableFolder.size());
  file_name.remove_suffix(kTableExtension.size());
  return is_name(file_name) ? std::string(file_name) : "";
}

/// Throws SettingsError if the table has cells of a label that was removed from the settings.
void check_labels(const Lut& lut, const std::string& path, const LabelSet& labels) {
  std::array<bool, 256> occurs{};
  for (const Label label : lut.yuv().labels) occurs[label] = true;
  for (std::size_t i = 0; i < occurs.size(); ++i) {
    if (!occurs[i] || labels.has(static_cast<Label>(i))) continue;
    throw SettingsError(
        fmt::format("{}: the table has cells of label {}, which /own_labels would no longer have; remove it "
                    "from the table on the Colours page first",
                    path, i));
  }
}

std::vector<std::uint8_t> bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

SavedTables::SavedTables(StateFolder& folder) : state_(folder), folder_(folder.path() / "tables") {
  std::error_code error;
  std::vector<std::filesystem::path> leftovers;
  for (const auto& entry : std::filesystem::directory_iterator(folder_, error)) {
    const std::filesystem::path file = entry.path().parent_path() / entry.path().stem();
    if (file.extension() == ".lut") leftovers.push_back(file);
  }
  for (const auto& file : leftovers) remove_leftover(file);
}

std::string SavedTables::save(const std::shared_ptr<const Lut>& lut, const LabelSet& labels) {
  const std::vector<std::uint8_t> bytes = encode_lut(lut->color_table(), labels);
  std::string name = table_name_of(chars_of(bytes));
  const std::lock_guard lock(mutex_);
  if (std::error_code error; bytes_of(file_of(name)) == bytes) {
    // Update the file's time, because tidy() removes the oldest files.
    std::filesystem::last_write_time(file_of(name), std::filesystem::file_time_type::clock::now(), error);
  } else {
    state_.write(file_of(name), std::string(bytes.begin(), bytes.end()));
  }
  in_memory_[name] = lut;
  lost_.erase(name);
  return name;
}

std::shared_ptr<const Lut> SavedTables::load(const std::string& name, const std::string& path,
                                             const LabelSet& labels) const {
  const std::lock_guard lock(mutex_);
  try {
    return load_now(name, path, labels);
  } catch (const SettingsError& error) {
    if (!is_start_) throw;
    log::error("{}", error.what());
    lost_[name] = error.what();
    return nullptr;
  }
}

std::string SavedTables::lost(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  const auto found = lost_.find(name);
  return found == lost_.end() ? "" : found->second;
}

/// The mutex must be held.
std::shared_ptr<const Lut> SavedTables::load_now(const std::string& name, const std::string& path,
                                                 const LabelSet& labels) const {
  if (offered_ != nullptr) {
    const auto found = offered_->find(file_name_of(name));
    if (found != offered_->end())
      return std::make_shared<const Lut>(
          decode_lut(bytes_in_text(found->second), fmt::format("{}: {}", path, found->first), labels));
  }
  if (const auto found = in_memory_.find(name); found != in_memory_.end()) {
    if (auto lut = found->second.lock()) {
      check_labels(*lut, path, labels);
      return lut;
    }
  }
  std::error_code error;
  if (!is_name(name) || !std::filesystem::exists(file_of(name), error)) {
    throw SettingsError(fmt::format(
        "{}: \"{}\" is not allowed; expected a table that this service has saved, or \"\" for the "
        "one of lut_file or classes. A backup brings another computer's settings with their tables: the "
        "Settings page, or ssl-visionctl backup and restore",
        path, name));
  }
  auto lut = std::make_shared<const Lut>(
      decode_lut(bytes_of(file_of(name)), fmt::format("{}: {}", path, file_of(name).string()), labels));
  in_memory_[name] = lut;
  return lut;
}

void SavedTables::tidy(const std::set<std::string>& used) {
  const std::lock_guard lock(mutex_);
  std::erase_if(in_memory_, [](const auto& entry) { return entry.second.expired(); });
  std::error_code error;
  std::vector<std::pair<std::filesystem::file_time_type, std::filesystem::path>> unused;
  for (const auto& entry : std::filesystem::directory_iterator(folder_, error)) {
    if (entry.path().extension() != ".lut" || used.contains(entry.path().stem().string())) continue;
    unused.emplace_back(entry.last_write_time(error), entry.path());
  }
  if (unused.size() <= kMax) return;
  std::sort(unused.begin(), unused.end());
  unused.resize(unused.size() - kMax);
  for (const auto& [time, file] : unused) std::filesystem::remove(file, error);
}

void SavedTables::put_file(const std::string& name, const std::string& bytes) {
  const std::lock_guard lock(mutex_);
  state_.write(file_of(name), bytes);
  in_memory_.erase(name);
  lost_.erase(name);
}

BackupFiles SavedTables::files(const Config& config) const {
  std::set<std::string> needed;
  for (const CameraSettings& camera : config.cameras) needed.insert(camera.colors.table);
  const std::lock_guard lock(mutex_);
  std::vector<std::tuple<bool, std::filesystem::file_time_type, std::string>> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder_, error)) {
    const std::string name = entry.path().stem().string();
    if (entry.path().extension() == kTableExtension && is_name(name))
      names.emplace_back(needed.contains(name), entry.last_write_time(error), name);
  }
  std::sort(names.rbegin(), names.rend());  // needed tables first, then the newest
  BackupFiles out;
  std::size_t size = 0;
  for (const auto& [is_needed, time, name] : names) {
    const auto bytes = bytes_of(file_of(name));
    size += bytes.size();
    // Skip damaged files, and tables beyond the size limit that are not needed.
    if (table_name_of(chars_of(bytes)) != name || (size > kMaxTableBytesInBackup && !is_needed)) continue;
    out.emplace(file_name_of(name), chars_of(bytes));
  }
  return out;
}

bool SavedTables::has(const std::string& name) const {
  return !table_name_in(name).empty();
}

/// Tables of a backup. The settings' transaction validates every cell of the tables that the settings use.
class SavedTables::Offered final : public SavedWith {
 public:
  Offered(SavedTables& tables, BackupFiles files) : tables_(tables), files_(std::move(files)) {
    const std::lock_guard lock(tables_.mutex_);
    tables_.offered_ = &files_;
  }
  ~Offered() override {
    const std::lock_guard lock(tables_.mutex_);
    tables_.offered_ = nullptr;
  }

  void save() override {
    try {
      for (const auto& [file_name, bytes] : files_) {
        const std::string name = table_name_in(file_name);
        const std::filesystem::path file = tables_.file_of(name);
        std::error_code error;
        const bool is_there = std::filesystem::exists(file, error);
        const std::vector<std::uint8_t> old = bytes_of(file);
        if (is_there && chars_of(old) == bytes) continue;
        tables_.put_file(name, bytes);
        replaced_.emplace_back(name, is_there ? std::optional<std::string>(chars_of(old)) : std::nullopt);
      }
    } catch (...) {
      take_back();
      throw;
    }
  }

  void take_back() noexcept override {
    for (const auto& [name, old] : replaced_) {
      try {
        if (old) tables_.put_file(name, *old);
      } catch (const std::exception& error) {
        log::error("a colour table of a refused backup was not removed: {}", error.what());
      }
      std::error_code error;
      if (!old) std::filesystem::remove(tables_.file_of(name), error);
    }
    replaced_.clear();
  }

 private:
  SavedTables& tables_;
  const BackupFiles files_;
  std::vector<std::pair<std::string, std::optional<std::string>>> replaced_;  // name, previous content
};

std::unique_ptr<SavedWith> SavedTables::prepare(BackupFiles files) {
  for (const auto& [file_name, bytes] : files) {
    if (table_name_of(bytes) != table_name_in(file_name) || !is_lut(bytes_in_text(bytes))) {
      throw SettingsError(
          fmt::format("{}: its contents do not match its name; expected a .lut file named "
                      "after its SHA-256",
                      file_name));
    }
  }
  return std::make_unique<Offered>(*this, std::move(files));
}

}  // namespace sslv
