// SPDX-License-Identifier: Apache-2.0
#include "ctl/commands/command_line.h"

#include "ctl/terminal_text.h"
#include "settings/store.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <termios.h>
#include <unistd.h>

namespace sslv {
namespace {

[[noreturn]] void refuse_to_write(const std::string& file) {
  throw StorageError(fmt::format("cannot write {}: {}", file, std::strerror(errno)));
}

}  // namespace

std::string CommandLine::password() const {
  if (!password_file.empty()) {
    std::ifstream in(password_file);
    std::string line;
    if (!std::getline(in, line))
      throw ClientError(fmt::format("--password-file: cannot read a line of {}", password_file.string()));
    return line;
  }
  if (const char* value = std::getenv("SSL_VISIOND_PASSWORD")) return value;
  if (isatty(STDIN_FILENO) != 0) return typed_secret(fmt::format("Password for {}: ", daemon));
  throw ClientError(
      fmt::format("{} wants a password: use --password-file, or set SSL_VISIOND_PASSWORD", daemon));
}

std::string typed_secret(const std::string& prompt) {
  termios before{};
  if (tcgetattr(STDIN_FILENO, &before) != 0) throw StorageError("a password can only be typed at a terminal");
  termios hidden = before;
  hidden.c_lflag &= ~static_cast<tcflag_t>(ECHO);
  std::cerr << prompt << std::flush;
  tcsetattr(STDIN_FILENO, TCSAFLUSH, &hidden);
  std::string line;
  std::getline(std::cin, line);
  tcsetattr(STDIN_FILENO, TCSAFLUSH, &before);
  std::cerr << "\n";
  return line;
}

void CommandLine::on(CLI::App* command, std::function<int()> action) {
  command->callback([this, action = std::move(action)] { act = action; });
}

void add_json_flag(CLI::App* command, bool& as_json) {
  command->add_flag("--json", as_json, "as the API gives it");
}

void print_answer(const Json& answer, bool as_json, std::string (*text)(const Json&)) {
  std::cout << answer_text(answer, as_json, text);
}

Output::Output(const std::string& file) : name_(file == "-" ? "standard output" : file) {
  if (file == "-") return;
  file_.open(file, std::ios::binary);
  if (!file_) refuse_to_write(name_);
}

void write_bytes(const std::string& file, const std::string& bytes) {
  write_pieces(file, [&](const TakePiece& take) { take(bytes); });
}

void write_pieces(const std::string& file, const std::function<void(const TakePiece& take)>& send) {
  if (file == "-" && isatty(STDOUT_FILENO) != 0)
    throw StorageError("a terminal cannot show this: name a file, or send standard output to one");
  std::optional<Output> output;  // opened with the first chunk: a refusal keeps an existing file
  try {
    send([&](std::string_view piece) {
      if (!output) output.emplace(file);
      if (!output->stream().write(piece.data(), static_cast<std::streamsize>(piece.size()))) output->finish();
    });
    if (output) output->finish();
  } catch (...) {
    std::error_code ignored;
    if (output && std::filesystem::is_regular_file(file, ignored)) std::filesystem::remove(file, ignored);
    throw;
  }
}

std::ostream& Output::stream() {
  return file_.is_open() ? file_ : std::cout;
}

void Output::finish() {
  if (!stream().flush()) refuse_to_write(name_);
}

}  // namespace sslv
