// SPDX-License-Identifier: Apache-2.0
#include "ctl/commands/command_line.h"

#include "settings/store.h"

#include <cerrno>
#include <cstring>
#include <iostream>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

[[noreturn]] void refuse_to_write(const std::string& file) {
  throw StorageError(fmt::format("cannot write {}: {}", file, std::strerror(errno)));
}

}  // namespace

void CommandLine::on(CLI::App* command, std::function<int()> action) {
  command->callback([this, action = std::move(action)] { act = action; });
}

void add_json_flag(CLI::App* command, bool& as_json) {
  command->add_flag("--json", as_json, "as the API gives it");
}

void print_answer(const Json& answer, bool as_json, std::string (*text)(const Json&)) {
  std::cout << (as_json ? answer.dump(2) + "\n" : text(answer));
}

Output::Output(const std::string& file) : name_(file == "-" ? "standard output" : file) {
  if (file == "-") return;
  file_.open(file, std::ios::binary);
  if (!file_) refuse_to_write(name_);
}

std::ostream& Output::stream() {
  return file_.is_open() ? file_ : std::cout;
}

void Output::finish() {
  if (!stream().flush()) refuse_to_write(name_);
}

}  // namespace sslv
