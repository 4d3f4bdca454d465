// SPDX-License-Identifier: Apache-2.0
#include "settings/store.h"

#include "base/clock.h"
#include "base/log.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

namespace sslv {
namespace {

class FileDescriptor {
 public:
  explicit FileDescriptor(int fd) : fd_(fd) {}
  ~FileDescriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

[[noreturn]] void fail(const std::filesystem::path& file, const char* what) {
  throw StorageError(fmt::format("cannot {} {}: {}", what, file.string(), std::strerror(errno)));
}

/// What root makes in the service's folder must be the service's.
void give_to_owner_of(const std::filesystem::path& folder, int fd) {
  struct stat about {};
  if (::geteuid() != 0 || ::stat(folder.c_str(), &about) != 0) return;
  if (::fchown(fd, about.st_uid, about.st_gid) != 0) fail(folder, "hand a file to the owner of");
}

Json patched(const Json& settings, const Json& patch) {
  try {
    return settings.patch(patch);
  } catch (const Json::exception& error) {
    throw SettingsError(fmt::format("not a JSON Patch that fits the settings: {}", error.what()));
  }
}

}  // namespace

Json read_json_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in || std::filesystem::is_directory(file)) {
    throw SettingsError(
        fmt::format("{}: cannot be read: {}", file.string(), in ? "is a folder" : std::strerror(errno)));
  }
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& error) {
    const auto upto = text.substr(0, error.byte > 0 ? error.byte - 1 : 0);
    const auto line = 1 + std::count(upto.begin(), upto.end(), '\n');
    const auto column = upto.size() - (upto.rfind('\n') == std::string::npos ? 0 : upto.rfind('\n') + 1) + 1;
    std::string what = error.what();  // "[json.exception...] parse error at line 1, column 2: <the reason>"
    const auto reason = what.find(": ");
    throw SettingsError(fmt::format("{}: line {}, column {}: no JSON: {}", file.string(), line, column,
                                    reason == std::string::npos ? what : what.substr(reason + 2)));
  }
}

void write_file_durably(const std::filesystem::path& file, const std::string& content, unsigned permissions) {
  const std::filesystem::path temporary = file.string() + ".new";
  {
    const FileDescriptor out(
        ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, permissions));
    if (out.get() < 0) fail(temporary, "write");
    give_to_owner_of(file.parent_path(), out.get());
    std::size_t written = 0;
    while (written < content.size()) {
      const ssize_t n = ::write(out.get(), content.data() + written, content.size() - written);
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) fail(temporary, "write");
      written += static_cast<std::size_t>(n);
    }
    if (::fsync(out.get()) != 0) fail(temporary, "write");
  }
  if (::rename(temporary.c_str(), file.c_str()) != 0) fail(file, "replace");
  const FileDescriptor folder(::open(file.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder.get() < 0 || ::fsync(folder.get()) != 0) fail(file.parent_path(), "sync");
}

SettingsStore::SettingsStore(std::filesystem::path admin_file, std::filesystem::path state_folder,
                             Check check)
    : admin_file_(std::move(admin_file)), state_folder_(std::move(state_folder)), check_(std::move(check)) {
  for (const auto& own : {changes_file(), previous_file()}) {
    std::error_code error;
    if (std::filesystem::equivalent(admin_file_, own, error)) {
      throw SettingsError(
          fmt::format("{}: is where the panel's changes are kept; move your settings to another folder",
                      admin_file_.string()));
    }
  }
  const Json from_file = read_json_file(admin_file_);
  try {
    admin_settings_ = check_(from_file);
  } catch (const SettingsError& error) {
    throw SettingsError(fmt::format("{}: {}", admin_file_.string(), error.what()));
  }
  version_ = {1, admin_settings_};
  for (const auto& file : {changes_file(), previous_file()}) {
    if (const auto loaded = load_changes(file)) {
      version_ = *loaded;
      break;
    }
  }
  revision_ = version_.revision;
}

std::optional<SettingsStore::Version> SettingsStore::load_changes(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return std::nullopt;
  try {
    const Json saved = read_json_file(file);
    if (!saved.is_object() || !saved.contains("revision") || !saved["revision"].is_number_unsigned() ||
        !saved.contains("changes")) {
      throw SettingsError("it holds no saved changes");
    }
    Version version{saved.at("revision").get<std::uint64_t>(),
                    check_(admin_settings_.patch(saved.at("changes")))};
    history_ = SettingsHistory(saved.value("history", Json::array()));
    return version;
  } catch (const std::exception& error) {
    const std::filesystem::path aside = file.string() + ".rejected";
    std::filesystem::rename(file, aside, ignored);
    const std::string text = fmt::format("saved changes in {} do not fit {} and were set aside as {}: {}",
                                         file.string(), admin_file_.string(), aside.string(), error.what());
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
                                            const Prepare& prepare) {
  const std::lock_guard lock(mutex_);
  return apply(patch, edit, prepare);
}

Json SettingsStore::check(const Json& patch, const std::function<void(const Json&)>& try_out) const {
  const Json before = current().settings;
  const Json after = check_(patched(before, patch));
  try_out(after);
  return changes_between(before, after);
}

SettingsStore::Version SettingsStore::undo(std::uint64_t revision, const SettingsEdit& edit,
                                           const Prepare& prepare) {
  const std::lock_guard lock(mutex_);
  const SettingsStep* step = history_.find(revision);
  if (step == nullptr)
    throw SettingsError(fmt::format("revision: {} is not allowed; expected one of the history", revision));
  const Json& changes = step->at("changes");
  // What it changed is as it left it when taking it back and making it again leads here.
  bool is_as_left = false;
  try {
    const Json there_and_back =
        version_.settings.patch(backward_patch(changes)).patch(forward_patch(changes));
    is_as_left = Json::diff(there_and_back, version_.settings).empty();  // whatever the order of keys
  } catch (const Json::exception&) {                                     // a place is no longer there
  }
  if (!is_as_left) {
    throw StaleRevision(fmt::format("what revision {} changed was changed again since", revision),
                        version_.revision, history_.newer_than(revision));
  }
  SettingsEdit named = edit;
  named.what = fmt::format("undo of revision {}", revision);
  return apply(backward_patch(changes), named, prepare);
}

SettingsStore::Version SettingsStore::apply(const Json& patch, const SettingsEdit& edit,
                                            const Prepare& prepare) {
  if (edit.if_revision && *edit.if_revision != version_.revision) {
    throw StaleRevision(fmt::format("the settings are at revision {}, this edit was made on {}",
                                    version_.revision, *edit.if_revision),
                        version_.revision, history_.newer_than(*edit.if_revision));
  }
  Version next{version_.revision + 1, check_(patched(version_.settings, patch))};
  const auto put_into_force = prepare(next.settings);

  SettingsHistory history = history_;
  SettingsStep step{{"revision", next.revision},
                    {"time", unix_time_s()},
                    {"who", edit.who},
                    {"what", edit.what},
                    {"changes", changes_between(version_.settings, next.settings)}};
  edit.joins ? history.join(std::move(step)) : history.add(std::move(step));
  const Json saved{{"revision", next.revision},
                   {"changes", Json::diff(admin_settings_, next.settings)},
                   {"history", history.to_json()}};
  std::error_code error;
  std::filesystem::create_directories(state_folder_, error);
  if (std::filesystem::exists(changes_file(), error)) {
    std::filesystem::copy_file(changes_file(), previous_file(),
                               std::filesystem::copy_options::overwrite_existing, error);
  }
  try {
    write_file_durably(changes_file(), saved.dump(2) + "\n");
  } catch (const StorageError& problem) {
    save_problem_.store(problem.what());
    throw;
  }
  save_problem_.store("");
  put_into_force();
  version_ = next;
  revision_ = next.revision;
  history_ = std::move(history);
  return next;
}

}  // namespace sslv
