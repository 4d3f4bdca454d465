// SPDX-License-Identifier: Apache-2.0
// Handles only arguments, signals and the exit code.
#include "base/kept_files.h"
#include "base/left_behind.h"
#include "base/log.h"
#include "base/memory.h"
#include "config/backends.h"
#include "config/config.h"
#include "config/found_cameras_text.h"
#include "config/stages.h"
#include "config/version.h"
#include "daemon.h"
#include "kit/sandbox/stage_process.h"
#include "services/recording/last_seconds.h"
#include "settings/store.h"

#include <atomic>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <malloc.h>
#include <sysexits.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

namespace {

using namespace sslv;

/// The folder for the panel's changes: from the service manager, else by the XDG base directory
/// specification.
std::filesystem::path state_folder() {
  const auto variable = [](const char* name) -> std::filesystem::path {
    const char* value = std::getenv(name);
    return value ? value : "";
  };
  if (auto folder = variable("STATE_DIRECTORY"); !folder.empty()) return folder;
  if (const auto folder = variable("XDG_STATE_HOME"); !folder.empty()) return folder / "ssl-visiond";
  return variable("HOME") / ".local/state/ssl-visiond";
}

/// The panel built beside this program, else the installed one.
std::filesystem::path panel_folder() {
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  const auto built = program.parent_path() / "../../../webui/dist";
  return std::filesystem::exists(built / "index.html", error) ? std::filesystem::canonical(built, error)
                                                              : std::filesystem::path(kInstalledPanel);
}

/// Runs `act`; if `act` refuses a setting, the error also names the file.
template <class Act>
auto naming(const std::filesystem::path& file, Act act) {
  try {
    return act();
  } catch (const BusyError& error) {
    throw BusyError(file.string() + ": " + error.what());
  } catch (const SettingsError& error) {
    const std::string what = error.what();
    throw SettingsError(what.starts_with(file.string()) ? what : file.string() + ": " + what);
  }
}

/// Returns the whole tree of a settings file, after also reading the files that it names.
Json checked_settings(const std::filesystem::path& file) {
  return naming(file, [&] {
    Json complete = complete_settings(up_to_date(read_json_file(file), settings_migrations()));
    const Config config = read_config(complete);
    for (std::size_t i = 0; i < config.cameras.size(); ++i) make_context(config, i);
    return complete;
  });
}

sigset_t own_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, signal);
  return signals;
}

/// The service handles its signals in one place. They are blocked from the program's first instruction on,
/// before the libraries initialise and before any thread starts, so that no signal can kill the process.
void block_own_signals() {
  const sigset_t signals = own_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
}
[[gnu::section(".preinit_array"), gnu::used]] void (*const kBeforeAll)() = block_own_signals;

/// If the program does not run as the service, signals end it as usual.
void unblock_own_signals() {
  const sigset_t signals = own_signals();
  pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
}

/// Reloads the settings on its own thread: a stage that is slow to start must not keep the watchdog from
/// being fed.
class Reload {
 public:
  explicit Reload(Daemon& daemon) : daemon_(daemon) {}
  ~Reload() {
    if (thread_.joinable()) thread_.join();
  }
  Reload(const Reload&) = delete;
  Reload& operator=(const Reload&) = delete;

  /// Reloads run one at a time; a request during a reload starts another reload afterwards.
  void ask() { is_wanted_ = true; }
  void each_time() {
    if (!is_wanted_ || is_running_) return;
    if (thread_.joinable()) thread_.join();
    is_wanted_ = false;
    is_running_ = true;
    thread_ = std::thread([this] {
      constexpr std::int64_t kPerSecond = 1'000'000, kNsPerUs = 1000;
      timespec now{};
      clock_gettime(CLOCK_MONOTONIC, &now);
      sd_notifyf(0, "RELOADING=1\nMONOTONIC_USEC=%lld",
                 static_cast<long long>(now.tv_sec * kPerSecond + now.tv_nsec / kNsPerUs));
      daemon_.reload();
      sd_notify(0, "READY=1");
      is_running_ = false;
    });
  }

 private:
  Daemon& daemon_;
  bool is_wanted_ = false;
  std::atomic<bool> is_running_{false};
  std::thread thread_;
};

/// A hanging disk or driver would prevent the service from ending until its manager aborts it, which looks
/// like a crash. So the service exits earlier, except at a terminal.
void end_in_time() {
  constexpr unsigned kLongest_s = 4;  // systemd/ssl-visiond.service: TimeoutStopSec
  if (std::getenv("NOTIFY_SOCKET") == nullptr) return;
  std::signal(SIGALRM, [](int) {
    constexpr std::string_view kText = "ssl-visiond: a disk or driver hangs: exited without waiting\n";
    [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, kText.data(), kText.size());
    std::_Exit(EXIT_SUCCESS);
  });
  ::alarm(kLongest_s);
}

/// Returns memory of images and tables to the system when it is freed. By default, glibc raises its
/// thresholds and keeps freed memory in an arena for each thread; threads start and end with cameras, so the
/// service needed a third more memory after some reopenings. Frames allocate nothing, so they lose no time.
void keep_memory_small() {
  mallopt(M_MMAP_THRESHOLD, 64 * 1024);
  mallopt(M_ARENA_MAX, 2);
}

int run(Daemon::Options options) {
  keep_memory_small();
  const sigset_t signals = own_signals();
  std::signal(SIGPIPE, SIG_IGN);

  const std::filesystem::path settings_file = options.settings_file;
  const auto daemon = naming(settings_file, [&] { return std::make_unique<Daemon>(std::move(options)); });
  log::info("panel on port {}", daemon->panel_port());
  sd_notify(0, "READY=1");
  Reload reload(*daemon);
  bool was_hanging = false;
  for (;;) {
    const timespec second{1, 0};
    const int signal = sigtimedwait(&signals, nullptr, &second);
    if (signal == SIGINT || signal == SIGTERM) break;
    if (signal == SIGHUP) reload.ask();
    reload.each_time();
    give_memory_back();
    const std::string hanging = daemon->hanging();
    if (hanging.empty()) sd_notify(0, "WATCHDOG=1");
    if (hanging.empty() == was_hanging) {
      was_hanging = !was_hanging;
      was_hanging ? log::error("{}: unless it continues, the service manager restarts the service", hanging)
                  : log::info("all cameras continue");
    }
    sd_notifyf(0, "STATUS=%s", (hanging.empty() ? daemon->summary() : hanging).c_str());
  }
  sd_notify(0, "STOPPING=1");
  end_in_time();
  log::info("stopping: {}", daemon->summary());
  daemon->ask_to_stop();
  return EXIT_SUCCESS;
}

int run_program(int argc, char** argv) {
  const EndOfStageProcesses end;
  CLI::App app{"Vision service for robot-soccer fields: cameras in, robots and balls out, with a web panel."};
  app.set_version_flag("--version", std::string("ssl-visiond ") + kVersion);
  std::filesystem::path settings_file, check_file, panel = panel_folder();
  std::vector<std::filesystem::path> file_folders;
  StageFolders stage_folders;
  bool print = false, list = false;
  app.add_option("--config", settings_file, "the settings file to run with");
  app.add_option("--check-config", check_file,
                 "check a settings file and say what is wrong with it: exit 0 or 78");
  app.add_option("--panel", panel, "folder of the built panel")->capture_default_str();
  app.add_option(
      "--files", file_folders,
      "a folder in which the panel may name files, besides the folders of the settings file and of "
      "the service's own state");
  app.add_option("--stages", stage_folders.inside,
                 "a folder of stage libraries (*.so), whose stages a stack may name; their code runs in this "
                 "program");
  app.add_option(
      "--stages-apart", stage_folders.sandboxed,
      "like --stages, but each stage runs in a process of its own, so that it cannot harm the service");
  app.add_flag("--print-config", print,
               "print all settings, including defaults (with --config: of that file)");
  app.add_flag("--list-cameras", list,
               "list the cameras that could be opened, with the settings lines for each");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? EXIT_SUCCESS : EX_USAGE;
  }
  const bool is_service = !list && !print && check_file.empty() && !settings_file.empty();
  if (!is_service) unblock_own_signals();
  std::vector<KeptFile> left;
  if (is_service) left = take_kept_files(LastSeconds::kKeptName);
  try {
    add_stage_libraries(stage_folders, is_service ? MissingStages::kLeftOut : MissingStages::kRefused);
    if (list) {
      Json list_json = Json::array();
      for (const FoundCamera& found : found_cameras()) list_json.push_back(found_camera_json(found));
      std::cout << found_cameras_text(list_json);
      return EXIT_SUCCESS;
    }
    if (!check_file.empty()) {
      checked_settings(check_file);
      std::cout << check_file.string() << ": good\n";
      return EXIT_SUCCESS;
    }
    if (print) {
      Json file{{kVersionKey, newest_version(settings_migrations())}};
      file.update(settings_file.empty() ? complete_settings(Json::object())
                                        : checked_settings(settings_file));
      std::cout << json_text(file, 2) << "\n";
      return EXIT_SUCCESS;
    }
    if (settings_file.empty()) {
      std::cerr << "ssl-visiond: --config FILE is required; see --help\n";
      return EX_USAGE;
    }
    return run({settings_file, state_folder(), panel, file_folders, std::move(left)});
  } catch (const BusyError& error) {
    std::cerr << "ssl-visiond: " << error.what() << "\n";
    return EX_TEMPFAIL;
  } catch (const SettingsError& error) {
    std::cerr << "ssl-visiond: " << error.what() << "\n";
    return EX_CONFIG;
  } catch (const std::exception& error) {
    std::cerr << "ssl-visiond: " << error.what() << "\n";
    return EXIT_FAILURE;
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (const auto code = stage_process_main(argc, argv)) return *code;
  const int code = run_program(argc, argv);
  // A hung driver may continue while exit() runs, and its library would be destroyed by then.
  if (LeftBehind::any()) std::_Exit(code);
  return code;
}
