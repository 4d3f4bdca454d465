// SPDX-License-Identifier: Apache-2.0
#include "kit/load_stages.h"

#include "base/log.h"
#include "base/plain_text.h"
#include "kit/read_stamp.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <climits>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <set>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

#include <dlfcn.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace sslv {
namespace {

using Clock = std::chrono::steady_clock;

/// A library that takes longer to load keeps the service from its start, for which systemd gives it 30
/// seconds. All of them together have the second time; then a second is left for each.
constexpr std::chrono::seconds kMaxLoading{10}, kMaxLoadingAll{15}, kMinLoading{1};

std::string first_line(std::string_view text) {
  return escaped_text(text.substr(0, text.find('\n')));
}

void check_name(std::string_view name) {
  constexpr std::size_t kMaxName = 40;
  const auto is_allowed = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
  if (!name.empty() && name.size() <= kMaxName && std::ranges::all_of(name, is_allowed)) return;
  throw StageLibraryError(fmt::format("has a stage '{}'; a name has 1 to {} characters of a-z, 0-9 and _",
                                      escaped_text(name.substr(0, kMaxName)), kMaxName));
}

/// Makes each stage once, with its default parameters.
template <class Floor>
void try_out(const std::vector<BasicStageType<Floor>>& rows) {
  for (const auto& row : rows) {
    check_name(row.name);
    try {
      check_plain_text(row.help, "its help");
      row.parse(Json::object(), "/" + row.name);
      static_cast<void>(row.schema().dump());  // throws unless all its texts are UTF-8
      static_cast<void>(row.create());
    } catch (const std::exception& error) {
      throw StageLibraryError(
          fmt::format("cannot make its stage '{}': {}", row.name, first_line(error.what())));
    } catch (...) {
      throw StageLibraryError(fmt::format("cannot make its stage '{}': it throws", row.name));
    }
  }
}

/// What is wrong with the library, or nothing. `use` gets its rows.
template <class Use>
std::string with_rows(const std::filesystem::path& file, const Use& use) {
  try {
    StageRows rows = load_rows(file);
    if (rows.camera.empty() && rows.field.empty()) return "has no stages";
    use(rows);
    return {};
  } catch (const StageLibraryError& error) {
    return error.what();
  } catch (const std::exception& error) {
    return fmt::format("throws while it is loaded: {}", first_line(error.what()));
  } catch (...) {
    return "throws while it is loaded";
  }
}

std::string load(const std::filesystem::path& file, StageRows& out) {
  return with_rows(file, [&out](StageRows& rows) { out = std::move(rows); });
}

/// In the process that may crash.
std::string try_library(const std::filesystem::path& file) {
  return with_rows(file, [](const StageRows& rows) {
    try_out(rows.camera);
    try_out(rows.field);
  });
}

/// All that comes before `end`.
std::string read_until_closed(int from, Clock::time_point end, bool& is_late) {
  std::string text;
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
    pollfd ready{from, POLLIN, 0};
    const int count = left.count() > 0 ? poll(&ready, 1, static_cast<int>(left.count())) : 0;
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      is_late = true;
      return text;
    }
    std::array<char, 512> part{};
    const ssize_t size = read(from, part.data(), part.size());
    if (size <= 0) return text;
    text.append(part.data(), static_cast<std::size_t>(size));
  }
}

/// try_library() in a process of its own. Throws StageLibraryError.
void try_apart(const std::filesystem::path& file, std::chrono::seconds max) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0)
    throw StageLibraryError(fmt::format("cannot be tried: {}", std::generic_category().message(errno)));
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(EXIT_FAILURE);
    // The marker tells "nothing is wrong" from an end before that could be said.
    const std::string said = try_library(file) + '\n';
    const ssize_t written = write(ends[1], said.data(), std::min<std::size_t>(said.size(), PIPE_BUF));
    _exit(written > 0 ? EXIT_SUCCESS : EXIT_FAILURE);
  }
  close(ends[1]);
  bool is_late = false;
  const std::string said =
      child > 0 ? read_until_closed(ends[0], Clock::now() + max, is_late) : std::string();
  close(ends[0]);
  if (child < 0)
    throw StageLibraryError(fmt::format("cannot be tried: {}", std::generic_category().message(errno)));
  if (is_late) kill(child, SIGKILL);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (is_late)
    throw StageLibraryError(
        fmt::format("is not loaded within {} second{}", max.count(), max.count() == 1 ? "" : "s"));
  if (WIFSIGNALED(status)) {
    throw StageLibraryError(fmt::format("crashes while it is loaded ({})", sigdescr_np(WTERMSIG(status))));
  }
  if (said.empty()) throw StageLibraryError("ends the process that loads it");
  if (said != "\n") throw StageLibraryError(first_line(said));
}

}  // namespace

StageRows load_rows(const std::filesystem::path& file) {
  void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (library == nullptr) {
    const char* problem = dlerror();
    std::string why = first_line(problem == nullptr ? "nobody says why" : problem);
    // The loader begins with the file's name, which stands before this text anyway.
    if (why.starts_with(file.string() + ": ")) why.erase(0, file.string().size() + 2);
    throw StageLibraryError(fmt::format("cannot be loaded: {}", why));
  }
  // A function's address as POSIX has it.
  const auto function = reinterpret_cast<StageRowsFunction>(dlsym(library, kStageRowsFunction));
  if (function == nullptr) throw StageLibraryError("names no stages: SSLV_STAGES(...) is missing");
  StageRows rows;
  function(rows);
  return rows;
}

std::vector<std::filesystem::path> stage_libraries(const std::vector<std::filesystem::path>& folders,
                                                   std::vector<LeftOutLibrary>& left_out) {
  std::vector<std::filesystem::path> files;
  for (const std::filesystem::path& folder : folders) {
    const auto begin = static_cast<std::ptrdiff_t>(files.size());
    try {
      for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::absolute(folder)))
        if (entry.path().extension() == ".so") files.push_back(entry.path());
    } catch (const std::filesystem::filesystem_error& error) {
      // A folder for libraries of one's own need not be there.
      if (error.code() == std::errc::no_such_file_or_directory || error.code() == std::errc::not_a_directory)
        log::info("no stages from {}: {}", escaped_text(folder.string()), error.code().message());
      else
        left_out.push_back({folder, fmt::format("cannot be read: {}", error.code().message())});
    }
    std::sort(files.begin() + begin, files.end());
  }
  return files;
}

LoadedStages load_stages(const std::vector<std::filesystem::path>& folders) {
  LoadedStages out;
  std::vector<std::filesystem::path> files = stage_libraries(folders, out.left_out);
  // All are tried before the first one is loaded: it may start threads, and then no process is forked.
  const auto end = Clock::now() + kMaxLoadingAll;
  std::erase_if(files, [&](const std::filesystem::path& file) {
    const auto left = std::chrono::duration_cast<std::chrono::seconds>(end - Clock::now());
    try {
      check_stamp(read_stamp(file));
      try_apart(file, std::clamp(left, kMinLoading, kMaxLoading));
      return false;
    } catch (const std::exception& error) {
      out.left_out.push_back({file, error.what()});
      return true;
    }
  });
  for (const std::filesystem::path& file : files) {
    StageLibrary library{file, {}};
    if (std::string problem = load(file, library.rows); !problem.empty()) {
      out.left_out.push_back({file, std::move(problem)});
      continue;
    }
    const std::string name = escaped_text(file.filename().string());
    for (StageType& row : library.rows.camera) row.library = name;
    for (FieldStageType& row : library.rows.field) row.library = name;
    out.libraries.push_back(std::move(library));
  }
  return out;
}

}  // namespace sslv
