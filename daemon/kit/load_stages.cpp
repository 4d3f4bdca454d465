// SPDX-License-Identifier: Apache-2.0
#include "kit/load_stages.h"

#include "base/log.h"
#include "base/open_file.h"
#include "base/plain_text.h"
#include "kit/child_process.h"
#include "kit/read_stamp.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <climits>
#include <cmath>
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

std::string first_line(std::string_view text) {
  return escaped_text(text.substr(0, text.find('\n')));
}

bool is_name(std::string_view name, std::size_t longest) {
  return !name.empty() && name.size() <= longest && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
}

/// JSON cannot represent NaN or infinity: such a number would be written to the settings but never read back.
bool is_finite(const Json& json) {
  if (json.is_number_float()) return std::isfinite(json.get<double>());
  return !json.is_structured() || std::all_of(json.begin(), json.end(), is_finite);
}

template <class Floor>
void check_params(const BasicStageType<Floor>& row) {
  const Json schema = row.schema();
  if (!is_utf8(schema)) throw std::runtime_error("its parameters: a text is not UTF-8");
  for (const auto& [key, one] : schema.at("properties").items()) {
    if (!is_finite(one))
      throw std::runtime_error(
          fmt::format("its parameter '{}' has a default or a range that is not a finite number", key));
  }
  const std::string path = "its parameters: /" + row.name;
  const Json defaults = row.parse(Json::object(), path).complete;
  // The service must be able to read back what it writes into its settings.
  row.parse(parse_own_json(json_text(defaults)), path);
}

/// Creates each stage once, with its default parameters.
template <class Floor>
void try_out(const std::vector<BasicStageType<Floor>>& rows) {
  for (const auto& row : rows) {
    check_row(row);
    try {
      static_cast<void>(row.create());
    } catch (const std::exception& error) {
      throw StageLibraryError(
          fmt::format("cannot make its stage '{}': {}", row.name, first_line(error.what())));
    } catch (...) {
      throw StageLibraryError(fmt::format("cannot make its stage '{}': it throws", row.name));
    }
  }
}

/// Calls `use` with the library's rows. Returns the problem with the library, or an empty text.
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

/// Runs in the child process, which may crash.
std::string try_library(const std::filesystem::path& file) {
  return with_rows(file, [](const StageRows& rows) {
    try_out(rows.camera);
    try_out(rows.field);
  });
}

/// Loads one library in a child process, which may crash, hang or start more processes.
class Trial {
 public:
  /// Throws StageLibraryError.
  explicit Trial(const std::filesystem::path& library) {
    std::array<int, 2> pipe{};
    if (pipe2(pipe.data(), O_CLOEXEC | O_NONBLOCK) != 0) fail(errno);
    answer_ = OpenFile(pipe[0]);
    const OpenFile theirs(pipe[1]);
    const pid_t parent = getpid();
    const pid_t process = fork();
    if (process == 0) {
      setpgid(0, 0);
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      if (getppid() != parent) _exit(EXIT_FAILURE);
      // The newline marks a complete answer; without it, the process ended before it could answer.
      std::string said = try_library(library);
      said.resize(std::min({said.size(), said.find('\n'), std::size_t{PIPE_BUF} - 1}));
      said += '\n';
      const ssize_t written = write(theirs.fd(), said.data(), said.size());
      _exit(written > 0 ? EXIT_SUCCESS : EXIT_FAILURE);
    }
    if (process < 0) fail(errno);
    try {
      process_ = ChildProcess(process);
    } catch (const std::system_error& error) {
      fail(error.code().value());
    }
  }

  std::array<pollfd, 2> polled() const {
    return {{{is_closed_ ? -1 : answer_.fd(), POLLIN, 0}, {process_.fd(), POLLIN, 0}}};
  }

  /// The remaining time of a test that started at `begin`. The time that the process waited for a processor
  /// extends the limit, at most to twice `within`, so that the service's start is bounded.
  std::chrono::nanoseconds left(Clock::time_point begin, std::chrono::nanoseconds within) const {
    return begin + within + std::chrono::nanoseconds(process_.grace_ns(within.count())) - Clock::now();
  }

  /// True if the result is final: the process has answered or ended.
  bool has_come() {
    const bool has_ended = process_.has_ended();  // checked before reading, so that its whole output is read
    std::array<char, 512> part{};
    for (ssize_t size = 0;
         !is_closed_ && !is_said() && (size = read(answer_.fd(), part.data(), part.size())) >= 0;) {
      is_closed_ = size == 0;
      said_.append(part.data(), static_cast<std::size_t>(size));
    }
    return has_ended || is_said();
  }

  /// The problem with the library, or an empty text. Kills the process and its group.
  std::string result(std::chrono::milliseconds had) {
    const bool is_late = !is_said() && !process_.has_ended();
    const int status = process_.end();
    if (is_said()) return first_line(said_);
    if (is_late) {
      return fmt::format("did not load within {:.3g} seconds", std::chrono::duration<double>(had).count());
    }
    if (WIFSIGNALED(status))
      return fmt::format("crashes while it is loaded ({})", sigdescr_np(WTERMSIG(status)));
    return "ends the process that loads it";
  }

 private:
  bool is_said() const { return said_.find('\n') != std::string::npos; }
  [[noreturn]] static void fail(int why) {
    throw StageLibraryError(fmt::format("cannot be tested: {}", std::generic_category().message(why)));
  }

  OpenFile answer_;
  ChildProcess process_;
  std::string said_;
  bool is_closed_ = false;
};

/// Tests all libraries in parallel, so that a hanging library does not delay the others. Moves faulty
/// libraries to `left_out`.
void try_all(std::vector<std::filesystem::path>& files, std::chrono::milliseconds within,
             std::vector<LeftOutLibrary>& left_out) {
  const auto begin = Clock::now();
  std::vector<std::string> wrong(files.size());
  std::vector<std::unique_ptr<Trial>> trials(files.size());
  for (std::size_t i = 0; i < files.size(); ++i) {
    try {
      check_stamp(read_stamp(files[i]));
      trials[i] = std::make_unique<Trial>(files[i]);
    } catch (const std::exception& error) {
      wrong[i] = error.what();
    }
  }
  for (;;) {
    auto wait = std::chrono::duration_cast<std::chrono::milliseconds>(within);
    std::vector<pollfd> polled;
    for (std::size_t i = 0; i < files.size(); ++i) {
      if (trials[i] == nullptr) continue;
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(trials[i]->left(begin, within));
      if (trials[i]->has_come() || left.count() <= 0) {
        wrong[i] = trials[i]->result(within);
        trials[i].reset();
      } else {
        wait = std::min(wait, left);
        for (const pollfd& one : trials[i]->polled()) polled.push_back(one);
      }
    }
    if (polled.empty()) break;
    constexpr int kLook_ms = 20;  // the deadline may be extended meanwhile
    poll(polled.data(), polled.size(), std::max(kLook_ms, static_cast<int>(wait.count())));
  }
  std::size_t at = 0;
  std::erase_if(files, [&](const std::filesystem::path& file) {
    std::string& why = wrong[at++];
    if (why.empty()) return false;
    left_out.push_back({file, std::move(why)});
    return true;
  });
}

/// Prepares the rows of a library loaded into this process for the stage tables.
template <class Floor>
void settle(std::vector<BasicStageType<Floor>>& rows, const std::string& library) {
  for (auto& row : rows) {
    row.library = library;
    if (row.schema().at("properties").contains(kDeadlineKey)) continue;  // the stage's own parameter
    row.parse = [parse = std::move(row.parse)](const Json& json, const std::string& path) {
      const auto deadline = json.is_object() ? json.find(kDeadlineKey) : json.end();
      if (deadline == json.end() || !deadline->is_number()) return parse(json, path);
      Json others = json;
      others.erase(kDeadlineKey);
      auto parsed = parse(others, path);
      parsed.complete[kDeadlineKey] = *deadline;
      return parsed;
    };
  }
}

}  // namespace

template <class Floor>
void check_row(const BasicStageType<Floor>& row) {
  constexpr std::size_t kLongestName = 40, kLongestPart = 60, kLongestHelp = 500;
  if (!is_name(row.name, kLongestName)) {
    throw StageLibraryError(
        fmt::format("has a stage with the invalid name '{}'; expected 1 to {} characters of a-z, 0-9 and _",
                    escaped_text(row.name.substr(0, kLongestName)), kLongestName));
  }
  try {
    for (const OwnPartUse& use : row.own_parts) {
      if (is_name(use.type.name, kLongestPart)) continue;
      throw std::runtime_error(
          fmt::format("its part '{}' has an invalid name; expected 1 to {} characters of a-z, 0-9 and _",
                      escaped_text(use.type.name.substr(0, kLongestPart)), kLongestPart));
    }
    check_plain_text(row.help, "its help");
    if (row.help.size() > kLongestHelp)
      throw std::runtime_error(fmt::format("its help has more than {} bytes", kLongestHelp));
    check_params(row);
  } catch (const std::exception& error) {
    throw StageLibraryError(
        fmt::format("cannot make its stage '{}': {}", row.name, first_line(error.what())));
  } catch (...) {
    throw StageLibraryError(fmt::format("cannot make its stage '{}': it throws", row.name));
  }
}
template void check_row(const StageType& row);
template void check_row(const FieldStageType& row);

StageRows load_rows(const std::filesystem::path& file) {
  void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (library == nullptr) {
    const char* problem = dlerror();
    std::string why = first_line(problem == nullptr ? "reason unknown" : problem);
    // dlerror() begins with the file's name, which the caller prints before this text.
    if (why.starts_with(file.string() + ": ")) why.erase(0, file.string().size() + 2);
    throw StageLibraryError(fmt::format("cannot be loaded: {}", why));
  }
  // POSIX permits this conversion to a function pointer.
  const auto function = reinterpret_cast<StageRowsFunction>(dlsym(library, kStageRowsFunction));
  if (function == nullptr) throw StageLibraryError("exports no stages: SSLV_STAGES(...) is missing");
  StageRows rows;
  function(rows);
  return rows;
}

std::vector<std::filesystem::path> stage_libraries(const std::vector<std::filesystem::path>& folders,
                                                   std::vector<LeftOutLibrary>& left_out) {
  std::vector<std::filesystem::path> files;
  std::set<std::filesystem::path> known;  // canonical paths
  for (const std::filesystem::path& folder : folders) {
    const auto begin = static_cast<std::ptrdiff_t>(files.size());
    try {
      std::error_code ignored;
      const auto absolute = std::filesystem::absolute(folder);
      if (!known.insert(std::filesystem::weakly_canonical(absolute, ignored)).second) continue;
      for (const auto& entry : std::filesystem::directory_iterator(absolute))
        if (entry.path().extension() == ".so") files.push_back(entry.path());
    } catch (const std::filesystem::filesystem_error& error) {
      // A folder for the user's own libraries is optional.
      if (error.code() == std::errc::no_such_file_or_directory || error.code() == std::errc::not_a_directory)
        log::info("no stages from {}: {}", escaped_text(folder.string()), error.code().message());
      else
        left_out.push_back({folder, fmt::format("cannot be read: {}", error.code().message())});
    }
    std::sort(files.begin() + begin, files.end());
  }
  std::erase_if(files, [&known](const std::filesystem::path& file) {
    std::error_code ignored;
    return !known.insert(std::filesystem::weakly_canonical(file, ignored)).second;
  });
  return files;
}

LoadedStages load_stages(const std::vector<std::filesystem::path>& folders,
                         std::chrono::milliseconds within) {
  LoadedStages out;
  std::vector<std::filesystem::path> files = stage_libraries(folders, out.left_out);
  // Test all libraries before loading the first: loading may start threads, and then forking is not safe.
  try_all(files, within, out.left_out);
  for (const std::filesystem::path& file : files) {
    StageLibrary library{file, {}};
    if (std::string problem = load(file, library.rows); !problem.empty()) {
      out.left_out.push_back({file, std::move(problem)});
      continue;
    }
    const std::string name = escaped_text(file.filename().string());
    settle(library.rows.camera, name);
    settle(library.rows.field, name);
    out.libraries.push_back(std::move(library));
  }
  return out;
}

}  // namespace sslv
