// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "ctl/client.h"

#include <filesystem>
#include <fstream>
#include <functional>
#include <iosfwd>
#include <memory>
#include <string>
#include <string_view>

#include <CLI/CLI.hpp>

namespace sslv {

/// A program's command line, filled in by its commands. The options of a command live as long as the actions
/// that share them.
struct CommandLine {
  /// With the options that all commands have.
  CommandLine(const std::string& program, const std::string& description);

  CLI::App app;
  std::string daemon = "http://127.0.0.1:8090";
  std::function<int()> act;  // the action of the given command; returns the exit code
  char** words = nullptr;    // all words, from the program's name; set by run()

  std::filesystem::path password_file;
  std::shared_ptr<SignIn> sign_in = std::make_shared<SignIn>(SignIn{[this] { return password(); }});

  Client client() const { return Client(daemon, sign_in); }
  /// The password for the daemon: from the file, the environment or the terminal. Throws ClientError.
  std::string password() const;
  /// Runs `action` for a command once the whole command line is parsed.
  void on(CLI::App* command, std::function<int()> action);
  /// Parses the words and acts. Prints what is wrong, after the program's name. Returns the exit code.
  int run(int argc, char** argv);

 private:
  int parse_and_act(int argc, char** argv);
};

/// The command `completion`, of every program.
void add_completion(CommandLine& line);

void add_json_flag(CLI::App* command, bool& as_json);

/// Reads a line from the terminal without showing it. Throws StorageError without a terminal.
std::string typed_secret(const std::string& prompt);

/// Prints an answer as JSON, or as human-readable text; always plain text, whatever the daemon sent.
void print_answer(const Json& answer, bool as_json, std::string (*text)(const Json&));

/// Writes a daemon's bytes to a file, or to standard output for "-", but not to a terminal, which might
/// interpret them. Throws StorageError.
void write_bytes(const std::string& file, const std::string& bytes);

/// The same for a file that is too large for memory: `send` passes on its chunks. If it throws, the file is
/// removed.
using TakePiece = std::function<void(std::string_view piece)>;
void write_pieces(const std::string& file, const std::function<void(const TakePiece& take)>& send);

/// A file to write, or standard output for "-". Throws StorageError.
class Output {
 public:
  explicit Output(const std::string& file);
  std::ostream& stream();
  /// Throws StorageError if not everything could be written.
  void finish();
  /// Tells a file's name on standard error, for commands that print nothing else.
  void tell() const;

 private:
  std::string name_;
  std::ofstream file_;
};

}  // namespace sslv
