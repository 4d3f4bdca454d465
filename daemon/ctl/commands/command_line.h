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

/// The command line, as its commands fill it in. What a command's options say lives as long as the actions
/// that share it.
struct CommandLine {
  CLI::App app{"Asks a running ssl-visiond, or runs its pipeline over files."};
  std::string daemon = "http://127.0.0.1:8090";
  std::function<int()> act;  // what the command that was given does; its exit code

  std::filesystem::path password_file;
  std::shared_ptr<SignIn> sign_in = std::make_shared<SignIn>(SignIn{[this] { return password(); }});

  Client client() const { return Client(daemon, sign_in); }
  /// The password for the daemon: from the file, the environment or the terminal. Throws ClientError.
  std::string password() const;
  /// Has a command do this once the whole command line is read.
  void on(CLI::App* command, std::function<int()> action);
};

void add_json_flag(CLI::App* command, bool& as_json);

/// A line typed at the terminal, which does not show it. Throws StorageError without a terminal.
std::string typed_secret(const std::string& prompt);

/// Prints an answer as the API gives it, or as a text for people; plain text, whatever the daemon said.
void print_answer(const Json& answer, bool as_json, std::string (*text)(const Json&));

/// Writes what a daemon sent to a file, or to standard output for "-", but not to a terminal, which might
/// obey it. Throws StorageError.
void write_bytes(const std::string& file, const std::string& bytes);

/// Likewise, of a file that is too large for memory: `send` gives its pieces. When it throws, nothing of the
/// file stays.
using TakePiece = std::function<void(std::string_view piece)>;
void write_pieces(const std::string& file, const std::function<void(const TakePiece& take)>& send);

/// A file to write, or standard output for "-". Throws StorageError.
class Output {
 public:
  explicit Output(const std::string& file);
  std::ostream& stream();
  /// Throws StorageError when not all of it could be written.
  void finish();

 private:
  std::string name_;
  std::ofstream file_;
};

}  // namespace sslv
