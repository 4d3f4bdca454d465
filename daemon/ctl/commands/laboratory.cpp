// SPDX-License-Identifier: Apache-2.0
#include "ctl/commands/laboratory.h"

#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <string>

#include <sysexits.h>
#include <unistd.h>

namespace sslv {
namespace {

[[noreturn]] void become_laboratory(const std::string& command, char** words) {
  const auto program = std::filesystem::read_symlink("/proc/self/exe").replace_filename("ssl-visionlab");
  execv(program.c_str(), words);
  std::cerr << "ssl-visionctl: " << command
            << " is a command of ssl-visionlab, which does not run: " << program.string() << ": "
            << std::strerror(errno) << "\n";
  std::exit(EX_UNAVAILABLE);
}

}  // namespace

void add_laboratory_commands(CommandLine& line, CLI::App* parent, std::initializer_list<const char*> names) {
  const std::string before = parent == &line.app ? "" : parent->get_name() + " ";
  for (const char* name : names) {
    parent->add_subcommand(name)->group("")->preparse_callback(
        [&line, command = before + name](std::size_t) { become_laboratory(command, line.words); });
  }
  if (parent != &line.app) parent->footer("Files: ssl-visionlab " + before + "--help");
}

void add_laboratory_input(CommandLine& line, CLI::App* command) {
  const std::string name = command->get_name();
  const auto take_over = [&line, name](const std::string&) {
    become_laboratory(name + " --input", line.words);
  };
  command
      ->add_option_function<std::string>("--input", take_over,
                                         "files instead: ssl-visionlab " + name + " --help")
      ->trigger_on_parse();
}

}  // namespace sslv
