// SPDX-License-Identifier: Apache-2.0
#include "ctl/colors.h"
#include "ctl/commands/commands.h"

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <string>

#include <fmt/format.h>

namespace sslv {
namespace {

struct ColorOptions {
  int camera_id = 0;
  bool as_json = false;
};

std::string colors_path(int camera_id) {
  return fmt::format("/api/cameras/{}/colors", camera_id);
}

/// Adds a command for a camera's colour table, with the options that all such commands have.
CLI::App* add_action(CLI::App* group, const char* name, const char* help,
                     const std::shared_ptr<ColorOptions>& o) {
  CLI::App* command = group->add_subcommand(name, help);
  command->add_option("--camera", o->camera_id, "id of the camera")->capture_default_str();
  add_json_flag(command, o->as_json);
  return command;
}

std::string file_content(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw ClientError(fmt::format("{}: cannot be read", file));
  return {std::istreambuf_iterator<char>(in), {}};
}

void add_post(CommandLine& line, CLI::App* group, const char* name, const char* path, const char* help) {
  const auto o = std::make_shared<ColorOptions>();
  line.on(add_action(group, name, help, o), [&line, o, path] {
    print_answer(line.client().post(colors_path(o->camera_id) + path, Json::object()), o->as_json,
                 colors_text);
    return EXIT_SUCCESS;
  });
}

void add_color_import(CommandLine& line, CLI::App* group) {
  struct ImportOptions {
    std::string file;
    int table = -1;
    bool only_try = false;
  };
  const auto o = std::make_shared<ColorOptions>();
  const auto import = std::make_shared<ImportOptions>();
  CLI::App* command =
      add_action(group, "import", "take a table from a file: .lut, our JSON, or SSL-Vision's XML", o);
  command->add_option("file", import->file, "the file")->required();
  command->add_option("--table", import->table, "which of several tables in the file, from 0");
  command->add_flag("--try", import->only_try, "show what is in it and change nothing");
  line.on(command, [&line, o, import] {
    std::string path = colors_path(o->camera_id) + "/import?name=" + path_part(import->file);
    if (import->table >= 0) path += fmt::format("&table={}", import->table);
    if (import->only_try) path += "&try=true";
    const Json answer = line.client().post_bytes(path, file_content(import->file));
    if (import->only_try) {
      print_answer(answer, o->as_json, tables_text);
    } else {
      print_answer(answer.at("state"), o->as_json, colors_text);
    }
    return EXIT_SUCCESS;
  });
}

void add_color_export(CommandLine& line, CLI::App* group) {
  const auto o = std::make_shared<ColorOptions>();
  const auto file = std::make_shared<std::string>();
  CLI::App* command = group->add_subcommand("export", "write the table to a file");
  command->add_option("--camera", o->camera_id, "id of the camera")->capture_default_str();
  command->add_option("file", *file, "file to write: .lut, or .json; -: .lut to standard output")->required();
  line.on(command, [&line, o, file] {
    const char* format = file->ends_with(".json") ? "json" : "lut";
    const std::string bytes =
        line.client().get(fmt::format("{}/export?format={}", colors_path(o->camera_id), format));
    write_bytes(*file, bytes);
    return EXIT_SUCCESS;
  });
}

void add_copy(CommandLine& line, CLI::App* group) {
  const auto o = std::make_shared<ColorOptions>();
  const auto from = std::make_shared<int>(0);
  CLI::App* command = add_action(group, "copy", "copy another camera's table", o);
  command->add_option("--from", *from, "id of the other camera")->required();
  line.on(command, [&line, o, from] {
    print_answer(line.client().post(colors_path(o->camera_id) + "/copy", {{"from", *from}}), o->as_json,
                 colors_text);
    return EXIT_SUCCESS;
  });
}

std::string edited_text(const Json& edited) {
  return fmt::format("{} cells are clear now\n", edited.at("cells").get<std::size_t>()) +
         colors_text(edited.at("state"));
}
std::string tried_text(const Json& edited) {
  std::string out = fmt::format("{} cells would become clear\n", edited.at("cells").get<std::size_t>());
  for (const Json& from : edited.at("from"))
    out += fmt::format("  {:<10} {:>8}\n", from.at("label").get<std::string>(),
                       from.at("cells").get<std::size_t>());
  return out;
}

void add_widen_margins(CommandLine& line, CLI::App* group) {
  const auto o = std::make_shared<ColorOptions>();
  const auto only_try = std::make_shared<bool>(false);
  CLI::App* command = add_action(
      group, "widen-margins",
      "widen margins: clear the colours that carpet and floor would have in more or less light", o);
  command->add_flag("--try", *only_try, "show how many cells that is and change nothing");
  line.on(command, [&line, o, only_try] {
    const Json answer = line.client().post(colors_path(o->camera_id) + "/edits",
                                           {{"commands", {{{"op", "widen_margins"}}}}, {"try", *only_try}});
    print_answer(answer, o->as_json, *only_try ? tried_text : edited_text);
    return EXIT_SUCCESS;
  });
}

}  // namespace

void add_colours(CommandLine& line) {
  CLI::App* group = line.app.add_subcommand("colours", "a camera's colour table");
  group->require_subcommand(1);
  const auto o = std::make_shared<ColorOptions>();
  line.on(add_action(group, "show",
                     "labels, where they touch, margins, the last step, how the table follows the light", o),
          [&line, o] {
            print_answer(line.client().get_json(colors_path(o->camera_id)), o->as_json, colors_text);
            return EXIT_SUCCESS;
          });
  add_color_import(line, group);
  add_color_export(line, group);
  add_copy(line, group);
  add_widen_margins(line, group);
  add_post(line, group, "undo", "/undo", "undo the newest step");
  add_post(line, group, "redo", "/redo", "redo the step that was undone last");
  add_post(line, group, "reset", "/reset", "go back to the table of the settings' classes or file");
  add_post(line, group, "keep-light", "/light/keep", "accept the table as it is in the current light");
  add_post(line, group, "revert-light", "/light/revert", "go back to the accepted table");
}

}  // namespace sslv
