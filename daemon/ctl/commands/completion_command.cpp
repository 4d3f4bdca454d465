// SPDX-License-Identifier: Apache-2.0
#include "ctl/commands/command_line.h"
#include "ctl/completion.h"

#include <cstdlib>
#include <iostream>
#include <memory>
#include <string>

namespace sslv {

void add_completion(CommandLine& line) {
  const auto shell = std::make_shared<std::string>();
  CLI::App* command = line.app.add_subcommand(
      "completion", "print a script with which a shell completes commands and options");
  command->add_option("shell", *shell, "bash, zsh or fish")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish"}));
  line.on(command, [&line, shell] {
    std::cout << completion_script(line.app, *shell);
    return EXIT_SUCCESS;
  });
}

}  // namespace sslv
