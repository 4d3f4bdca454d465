// SPDX-License-Identifier: Apache-2.0
#include "base/error.h"
#include "ctl/backup_text.h"
#include "ctl/commands/commands.h"
#include "ctl/terminal_text.h"
#include "settings/backup_limits.h"

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <system_error>

#include <fmt/format.h>
#include <sys/stat.h>

namespace sslv {
namespace {

/// Throws StorageError.
std::string bytes_of_backup(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in || std::filesystem::is_directory(file)) {
    throw StorageError(
        fmt::format("{}: cannot be read: {}", file, in ? "is a folder" : std::strerror(errno)));
  }
  std::string bytes{std::istreambuf_iterator<char>(in), {}};
  if (bytes.size() > kMaxBackupBytes) {
    throw StorageError(fmt::format("{}: has {} bytes; expected a backup, of {} MiB at most", file,
                                   bytes.size(), kMaxBackupBytes >> 20U));
  }
  return bytes;
}

/// Adds the file's name to a refusal.
Json post_backup(const Client& daemon, const char* path, const std::string& file, const std::string& bytes) {
  try {
    return daemon.post_bytes(path, bytes);
  } catch (const ClientError& error) {
    throw std::runtime_error(fmt::format("{}: {}", file, error.what()));
  }
}

}  // namespace

void add_backup(CommandLine& line) {
  struct Options {
    std::string file;
    bool with_passwords = false;
  };
  const auto o = std::make_shared<Options>();
  CLI::App* command = line.app.add_subcommand(
      "backup",
      "everything the service keeps, in one file: settings and their history, colour tables, profiles, "
      "calibrations");
  command->add_option("file", o->file, "file to write; -: standard output")->required();
  command->add_flag("--with-passwords", o->with_passwords,
                    "also the hashes of the panel's passwords: keep the file secret");
  line.on(command, [&line, o] {
    const std::string backup =
        line.client().get(o->with_passwords ? "/api/backup?passwords=true" : "/api/backup");
    ::umask(077);  // no other user may read it
    write_bytes(o->file, backup);
    if (o->with_passwords && o->file != "-") {
      std::error_code ignored;  // the file may be another user's
      using enum std::filesystem::perms;
      std::filesystem::permissions(o->file, owner_read | owner_write, ignored);
    }
    return EXIT_SUCCESS;
  });
}

void add_restore(CommandLine& line) {
  struct Options {
    std::string file;
    bool dry_run = false, as_json = false;
  };
  const auto o = std::make_shared<Options>();
  CLI::App* command = line.app.add_subcommand(
      "restore",
      "restore everything that the service keeps from a backup of this or another computer, live and without "
      "a restart; all of it or nothing");
  command->add_option("file", o->file, "the backup")->required();
  command->add_flag("--dry-run", o->dry_run, "only check it and show what it contains and would change");
  add_json_flag(command, o->as_json);
  line.on(command, [&line, o] {
    const std::string bytes = bytes_of_backup(o->file);
    const Client client = line.client();
    // Signs in if necessary, because a daemon accepts large files only from clients that are signed in.
    client.post("/api/settings/check", Json::array());
    const Json contents = post_backup(client, "/api/backup/check", o->file, bytes);
    if (o->dry_run) {
      print_answer(contents, o->as_json, backup_text);
      return EXIT_SUCCESS;
    }
    const Json restored = post_backup(client, "/api/backup/restore", o->file, bytes);
    Json answer{{"backup", contents}};
    answer["revision"] = restored.at("revision");
    answer["passwords"] = restored.at("passwords");
    print_answer(answer, o->as_json, restored_text);
    return EXIT_SUCCESS;
  });
}

}  // namespace sslv
