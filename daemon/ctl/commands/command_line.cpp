// SPDX-License-Identifier: Apache-2.0
#include "ctl/commands/command_line.h"

#include "base/error.h"
#include "base/plain_text.h"
#include "config/version.h"
#include "ctl/terminal_text.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <sysexits.h>
#include <termios.h>
#include <unistd.h>

namespace sslv {
namespace {

[[noreturn]] void refuse_to_write(const std::string& file) {
  throw StorageError(fmt::format("cannot write {}: {}", file, std::strerror(errno)));
}

}  // namespace

CommandLine::CommandLine(const std::string& program, const std::string& description)
    : app(description, program) {
  app.set_version_flag("--version", program + " " + kVersion);
  app.require_subcommand(1);
  app.add_option("--daemon", daemon, "address of the daemon's panel")->capture_default_str();
  app.add_option(
      "--password-file", password_file,
      "file with the daemon's password in its first line; else SSL_VISIOND_PASSWORD, else it is asked for");
}

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

int CommandLine::parse_and_act(int argc, char** argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? EXIT_SUCCESS : EX_USAGE;
  }
  return act();
}

int CommandLine::run(int argc, char** argv) {
  words = argv;
  try {
    return parse_and_act(argc, argv);
  } catch (const SettingsError& error) {
    std::cerr << app.get_name() << ": " << escaped_lines(error.what()) << "\n";
    return EX_CONFIG;
  } catch (const std::exception& error) {
    std::cerr << app.get_name() << ": " << escaped_lines(error.what()) << "\n";
    return EXIT_FAILURE;
  }
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
