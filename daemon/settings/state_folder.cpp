// SPDX-License-Identifier: Apache-2.0
#include "settings/state_folder.h"

#include "base/error.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

namespace sslv {
namespace {

namespace fs = std::filesystem;

class FileDescriptor {
 public:
  explicit FileDescriptor(int fd) : fd_(fd) {}
  ~FileDescriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  int get() const { return fd_; }
  /// False if data was not written after all, which network file systems report only here.
  bool close() { return ::close(std::exchange(fd_, -1)) == 0; }

 private:
  int fd_;
};

[[noreturn]] void fail(const char* what, const fs::path& file) {
  throw StorageError(fmt::format("cannot {} {}: {}", what, file.string(), std::strerror(errno)));
}

/// Removes a file on destruction if it still exists.
class Temporary {
 public:
  explicit Temporary(fs::path file) : file_(std::move(file)) {}
  ~Temporary() { ::unlink(file_.c_str()); }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  const fs::path& file() const { return file_; }

 private:
  const fs::path file_;
};

fs::path temporary_of(const fs::path& file) {
  return file.string() + ".new";
}

/// The folder of a file; "." for a file name without a folder.
fs::path folder_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

/// Files that root creates in the service's folder must belong to the service.
void give_to_owner_of(const fs::path& folder, int fd) {
  struct stat about {};
  if (::geteuid() != 0 || ::stat(folder.c_str(), &about) != 0) return;
  if (::fchown(fd, about.st_uid, about.st_gid) != 0) fail("hand a file to the owner of", folder);
}

void write_all(const fs::path& file, std::string_view content, unsigned permissions) {
  FileDescriptor out(
      ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, permissions));
  if (out.get() < 0) fail("write", file);
  give_to_owner_of(folder_of(file), out.get());
  for (std::size_t written = 0; written < content.size();) {
    const ssize_t n = ::write(out.get(), content.data() + written, content.size() - written);
    if (n < 0 && errno == EINTR) continue;
    if (n == 0) errno = ENOSPC;
    if (n <= 0) fail("write", file);
    written += static_cast<std::size_t>(n);
  }
  if (::fsync(out.get()) != 0 || !out.close()) fail("write", file);
}

/// Hard-links the current content: takes no space, and `kept` is always complete. Does nothing if there is no
/// such file or the file system has no hard links.
void keep_as(const fs::path& file, const fs::path& kept) {
  const Temporary link(temporary_of(kept));
  ::unlink(link.file().c_str());
  if (::link(file.c_str(), link.file().c_str()) == 0) ::rename(link.file().c_str(), kept.c_str());
}

/// Syncs the parent, so that the new folder survives a power cut.
void make_folder(const fs::path& path, std::error_code& error) {
  if (!fs::create_directories(path, error)) return;
  const FileDescriptor parent(::open(path.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (parent.get() >= 0) ::fsync(parent.get());
}

/// Names the format of another program's file, and the command that reads it; empty for an unknown format.
std::string other_format(std::string_view text) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF", kSpace = " \t\r\n";
  if (text.starts_with("\x1F\x8B")) return "is compressed (gzip)";
  if (text.starts_with("\x89PNG") || text.starts_with("\xFF\xD8")) return "is an image";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  while (!text.empty()) {
    text.remove_prefix(std::min(text.find_first_not_of(kSpace), text.size()));
    const std::string_view line = text.substr(0, text.find('\n'));
    if (line.starts_with('<')) {
      constexpr std::size_t kBeginning = 1000;
      if (text.find("<VarXML>") == std::string_view::npos) return "is XML";
      if (text.substr(0, kBeginning).find("LUT Data") != std::string_view::npos)
        return "is a colour table of SSL-Vision; ssl-visionctl colours import reads it";
      return "has settings of SSL-Vision, which this version does not read. ssl-visionctl colours import "
             "reads SSL-Vision's colour tables";
    }
    const std::size_t name =
        line.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-");
    if (line.starts_with("---") || (name != 0 && name < line.size() && line[name] == ':'))
      return "is YAML, perhaps the Vision Processor's settings, which this version does not read";
    if (!line.starts_with('#')) return {};
    text.remove_prefix(line.size());
  }
  return {};
}

}  // namespace

Json read_json_file(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in || fs::is_directory(file)) {
    throw SettingsError(
        fmt::format("{}: cannot be read: {}", file.string(), in ? "is a folder" : std::strerror(errno)));
  }
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  try {
    return parse_own_json(text);
  } catch (const Json::parse_error& error) {
    if (const std::string format = other_format(text); !format.empty())
      throw SettingsError(fmt::format("{}: must be JSON, but {}", file.string(), format));
    const auto upto = text.substr(0, error.byte > 0 ? error.byte - 1 : 0);
    const auto line = 1 + std::count(upto.begin(), upto.end(), '\n');
    const auto column = upto.size() - (upto.rfind('\n') == std::string::npos ? 0 : upto.rfind('\n') + 1) + 1;
    const std::string what = reason_of(error);  // "parse error at line 1, column 2: <the reason>"
    const auto reason = what.find(": ");
    throw SettingsError(fmt::format("{}: line {}, column {}: not valid JSON: {}", file.string(), line, column,
                                    reason == std::string::npos ? what : what.substr(reason + 2)));
  }
}

void write_file_durably(const fs::path& file, std::string_view content, unsigned permissions,
                        const fs::path& previous) {
  // The folder is opened first, because nothing can be guaranteed without its fsync.
  const FileDescriptor folder(::open(folder_of(file).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder.get() < 0) fail("write", temporary_of(file));
  const Temporary temporary(temporary_of(file));
  write_all(temporary.file(), content, permissions);

  const Temporary old(file.string() + ".old");
  ::unlink(old.file().c_str());
  const bool has_old = ::link(file.c_str(), old.file().c_str()) == 0;
  if (!previous.empty()) keep_as(file, previous);
  if (::rename(temporary.file().c_str(), file.c_str()) != 0) fail("replace", file);
  if (::fsync(folder.get()) == 0) return;
  // Restores the old content, but a power cut now may leave either version.
  const int error = errno;
  has_old ? ::rename(old.file().c_str(), file.c_str()) : ::unlink(file.c_str());
  errno = error;
  fail("sync the folder of", file);
}

void remove_file(const fs::path& file) {
  if (::unlink(file.c_str()) != 0 && errno != ENOENT) fail("remove", file);
}

void remove_leftover(const fs::path& file) {
  const Temporary temporary(temporary_of(file)), old(file.string() + ".old");
}

fs::path set_aside(const fs::path& file) {
  constexpr int kMax = 100;
  std::error_code error;
  fs::path aside = file.string() + ".rejected";
  for (int i = 2; i <= kMax && fs::exists(aside, error); ++i)
    aside = fmt::format("{}.rejected.{}", file.string(), i);
  fs::rename(file, aside, error);
  return aside;
}

StateFolder::StateFolder(fs::path path) : path_(std::move(path)) {
  std::error_code ignored;  // find_problem() reports it
  make_folder(path_, ignored);
}

void StateFolder::write(const fs::path& file, std::string_view content, const fs::path& previous) {
  try {
    constexpr unsigned kPermissions = 0640;
    std::error_code error;
    make_folder(file.parent_path(), error);
    if (error) {
      throw StorageError(
          fmt::format("cannot write {}: its folder cannot be created: {}", file.string(), error.message()));
    }
    write_file_durably(file, content, kPermissions, previous);
  } catch (const StorageError& problem) {
    write_problem_.store(problem.what());
    throw;
  }
  write_problem_.store("");
}

std::string StateFolder::find_problem() const {
  std::error_code error;
  fs::create_directories(path_, error);
  if (!error && ::access(path_.c_str(), W_OK | X_OK) != 0) error = {errno, std::generic_category()};
  return error ? fmt::format("{}: {}", path_.string(), error.message()) : "";
}

}  // namespace sslv
