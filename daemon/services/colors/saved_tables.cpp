// SPDX-License-Identifier: Apache-2.0
#include "services/colors/saved_tables.h"

#include "base/error.h"
#include "base/log.h"
#include "settings/state_folder.h"
#include "vision/lut_codec.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <glib.h>

namespace sslv {
namespace {

constexpr std::size_t kNameLength = 16;

/// SHA-256, 64 hexadecimal digits.
std::string hash_of(std::span<const std::uint8_t> bytes) {
  const std::unique_ptr<gchar, decltype(&g_free)> hash(
      g_compute_checksum_for_data(G_CHECKSUM_SHA256, bytes.data(), bytes.size()), &g_free);
  return hash.get();
}

/// Nothing else may become a part of a path.
bool is_name(std::string_view name) {
  return name.size() == kNameLength && name.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

/// A label may have been taken out of the settings since. Throws SettingsError.
void check_labels(const Lut& lut, const std::string& path, const LabelSet& labels) {
  std::array<bool, 256> occurs{};
  for (const Label label : lut.yuv().labels) occurs[label] = true;
  for (std::size_t i = 0; i < occurs.size(); ++i) {
    if (!occurs[i] || labels.has(static_cast<Label>(i))) continue;
    throw SettingsError(
        fmt::format("{}: the table has cells of label {}, which /own_labels would not have any more; remove "
                    "it from the table "
                    "on the Colours page first",
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
  std::string name = hash_of(bytes).substr(0, kNameLength);
  const std::lock_guard lock(mutex_);
  if (std::error_code error; bytes_of(file_of(name)) == bytes) {
    // As if it were new: it is not to be tidied away soon.
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

/// With the lock held.
std::shared_ptr<const Lut> SavedTables::load_now(const std::string& name, const std::string& path,
                                                 const LabelSet& labels) const {
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
        "one of lut_file or classes. A table of another computer is imported on the Colours page",
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

}  // namespace sslv
