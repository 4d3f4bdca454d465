// SPDX-License-Identifier: Apache-2.0
#include "ctl/commands/command_line.h"

#include "base/error.h"
#include "base/plain_text.h"
#include "config/version.h"
#include "ctl/terminal_text.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <numeric>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <sysexits.h>
#include <termios.h>
#include <unistd.h>

namespace sslv {
namespace {

[[noreturn]] void refuse_to_write(const std::string& file) {
  throw StorageError(fmt::format("cannot write {}: {}", file, std::strerror(errno)));
}

/// The innermost command that was given.
const CLI::App& deepest_command(const CLI::App& app) {
  const auto given = app.get_subcommands();
  return given.empty() ? app : deepest_command(*given.front());
}

/// As the user types it.
std::string full_name(const CLI::App& command) {
  const CLI::App* group = command.get_parent();
  return (group != nullptr ? full_name(*group) + " " : "") + command.get_name();
}

/// Levenshtein distance.
std::size_t edits_between(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j)
      diagonal = std::exchange(row[j + 1],
                               std::min({row[j + 1] + 1, row[j] + 1, diagonal + (a[i] == b[j] ? 0 : 1)}));
  }
  return row.back();
}

std::string unknown_command(const CLI::App& group, const std::string& word) {
  constexpr std::size_t kMaxEdits = 2;
  std::string alike;
  std::size_t fewest = kMaxEdits + 1;
  for (const CLI::App* command : group.get_subcommands([](const CLI::App*) { return true; })) {
    const std::size_t edits = edits_between(word, command->get_name());
    if (edits >= fewest) continue;
    fewest = edits;
    alike = command->get_name();
  }
  return fmt::format("{}: no command \"{}\"{} (--help lists all)\n", full_name(group), escaped_text(word),
                     alike.empty() ? "" : fmt::format("; did you mean \"{}\"?", alike));
}

}  // namespace

CommandLine::CommandLine(const std::string& program, const std::string& description)
    : app(description, program) {
  app.set_version_flag("--version", program + " " + kVersion);
  app.require_subcommand(1);
  app.add_option("--daemon", daemon, "address of the service's panel")->capture_default_str();
  app.add_option(
      "--password-file", password_file,
      "file with the service's password in its first line; else SSL_VISIOND_PASSWORD, else it is asked for");
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
  } catch (const CLI::RequiredError& error) {
    const CLI::App& group = deepest_command(app);
    const auto words_left = group.remaining();
    const bool has_commands = group.get_require_subcommand_min() > 0;
    if (!has_commands || words_left.empty() || words_left.front().starts_with('-'))
      return app.exit(error) == 0 ? EXIT_SUCCESS : EX_USAGE;
    std::cerr << unknown_command(group, words_left.front());
    return EX_USAGE;
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
  } catch (const Json::exception& error) {
    std::cerr << app.get_name() << ": " << escaped_lines(reason_of(error)) << "\n";
    return EXIT_FAILURE;
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
    if (output) output->tell();
  } catch (...) {
    std::error_code ignored;
    if (output && std::filesystem::is_regular_file(file, ignored)) std::filesystem::remove(file, ignored);
    throw;
  }
}

std::ostream& Output::stream() {
  return file_.is_open() ? file_ : std::cout;
}

void Output::tell() const {
  if (file_.is_open()) std::cerr << "written to " << name_ << "\n";
}

void Output::finish() {
  if (!stream().flush()) refuse_to_write(name_);
}

}  // namespace sslv
