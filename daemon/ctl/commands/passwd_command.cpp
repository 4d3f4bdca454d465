// SPDX-License-Identifier: Apache-2.0
// Access to the panel: its passwords, on the daemon's own computer; the match lock, through the daemon.
#include "base/error.h"
#include "config/version.h"
#include "ctl/commands/commands.h"
#include "settings/passwords.h"
#include "settings/store.h"

#include <cstdlib>
#include <iostream>
#include <memory>
#include <string>

#include <fmt/format.h>
#include <unistd.h>

namespace sslv {
namespace {

std::filesystem::path default_state_folder() {
  const char* folder = std::getenv("STATE_DIRECTORY");
  return folder != nullptr && *folder != '\0' ? folder : kInstalledState;
}

/// Typed twice at a terminal, else the first line of standard input.
std::string read_new_password(Role role) {
  std::string password;
  if (isatty(STDIN_FILENO) == 0) {
    std::getline(std::cin, password);
    return password;
  }
  password = typed_secret(fmt::format("New password for the panel's {}: ", name_of(role)));
  if (typed_secret("Again: ") != password)
    throw SettingsError("the two passwords differ; nothing was changed");
  return password;
}

std::string lock_text(const Json& lock) {
  if (!lock.at("game_is_running").get<bool>()) return "no match is running: settings may be changed\n";
  return lock.at("opened").get<bool>() ? "a match is running; settings were unlocked for it\n"
                                       : "a match is running; settings are locked\n";
}

}  // namespace

void add_passwd(CommandLine& line) {
  struct Options {
    bool viewer = false, remove = false;
    std::filesystem::path state_folder = default_state_folder();
  };
  const auto options = std::make_shared<Options>();
  auto* command = line.app.add_subcommand(
      "passwd",
      "set the panel's password, on the service's own computer and as root; a running service knows "
      "it at once");
  command->add_flag(
      "--viewer", options->viewer,
      "set the password of viewers, who may look but not change anything; without one everybody may look");
  command->add_flag("--remove", options->remove,
                    "remove the password; takes effect when the service is restarted");
  command->add_option("--state", options->state_folder, "the service's state folder")->capture_default_str();
  line.on(command, [options] {
    const Role role = options->viewer ? Role::kViewer : Role::kAdmin;
    if (!std::filesystem::is_directory(options->state_folder)) {
      throw SettingsError(
          fmt::format("--state: there is no folder {}; the service makes it when it is started",
                      options->state_folder.string()));
    }
    const auto file = options->state_folder / Passwords::kFileName;
    std::error_code ignored;
    // A file that is no longer usable must be replaced.
    std::unique_ptr<Passwords> passwords;
    try {
      passwords = std::make_unique<Passwords>(file);
    } catch (const SettingsError& error) {
      std::cerr << error.what() << "\n";
      std::filesystem::rename(file, file.string() + ".rejected", ignored);
      passwords = std::make_unique<Passwords>(file);
    }
    const auto password = options->remove ? std::nullopt : std::optional(read_new_password(role));
    passwords->set(role, password);
    std::cout << fmt::format("the {}'s password is {}\n", name_of(role), password ? "set" : "removed");
    return EXIT_SUCCESS;
  });
}

void add_match_lock(CommandLine& line) {
  auto* command =
      line.app.add_subcommand("match-lock", "show or set whether settings are locked while a match runs");
  command->require_subcommand(0, 1);
  const auto print = [](const Json& lock) {
    std::cout << lock_text(lock);
    return EXIT_SUCCESS;
  };
  line.on(command, [&line, print] { return print(line.client().get_json("/api/session").at("match_lock")); });
  for (const bool opened : {true, false}) {
    auto* set =
        command->add_subcommand(opened ? "open" : "close", opened ? "unlock the settings until the match ends"
                                                                  : "lock the settings again");
    line.on(set, [&line, print, opened] {
      return print(line.client().post("/api/match_lock", {{"opened", opened}}));
    });
  }
}

}  // namespace sslv
