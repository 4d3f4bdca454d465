// SPDX-License-Identifier: Apache-2.0
#include "ctl/change_text.h"
#include "ctl/commands/commands.h"
#include "ctl/settings_edit.h"
#include "ctl/terminal_text.h"
#include "settings/store.h"

#include <cstdlib>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Options of all commands that change settings.
struct EditOptions {
  bool dry_run = false, as_json = false;

  void add_to(CLI::App* command) {
    command->add_flag("--dry-run", dry_run, "only check it and show what would change");
    command->add_flag("--json", as_json, "changes and revision as JSON");
  }
  int edit(const Client& daemon, const Json& read, const Json& patch) const {
    print_answer(edit_settings(daemon, read, patch, dry_run), as_json, edit_text);
    return EXIT_SUCCESS;
  }
};

constexpr const char* kPointer = "JSON pointer of a place, such as /field or /cameras/0/name";

void add_get(CommandLine& line, CLI::App* parent) {
  struct Options {
    std::string pointer;
    bool as_json = false;
  };
  const auto o = std::make_shared<Options>();
  CLI::App* command = parent->add_subcommand("get", "show the settings, or one place of them");
  command->add_option("pointer", o->pointer, kPointer);
  command->add_flag("--json", o->as_json, "put quotes around a text, too");
  line.on(command, [&line, o] {
    const Json settings = line.client().get_json("/api/settings").at("settings");
    const Json& value = value_at(settings, o->pointer);
    print_answer(value, o->as_json || !value.is_string(),
                 [](const Json& text) { return text.get<std::string>() + "\n"; });
    return EXIT_SUCCESS;
  });
}

void add_set(CommandLine& line, CLI::App* parent) {
  const auto edit = std::make_shared<EditOptions>();
  CLI::App* command = parent->add_subcommand(
      "set",
      "POINTER VALUE [POINTER VALUE ...]: set these places, all of them or none, live and saved; a value is "
      "JSON, or a text when it is none; /list/- appends");
  command->allow_extras();  // CLI11 would split a list among the words of an option
  edit->add_to(command);
  command->callback([&line, edit, command] {
    const std::vector<std::string> words = command->remaining();
    std::vector<std::pair<std::string, std::string>> pairs;
    for (const std::string& word : words) {
      if (word.starts_with("--")) throw CLI::ExtrasError({word});
    }
    if (words.empty() || words.size() % 2 != 0)
      throw CLI::ValidationError("set", "needs a POINTER and a VALUE for every place");
    for (std::size_t i = 0; i < words.size(); i += 2) pairs.emplace_back(words[i], words[i + 1]);
    line.act = [&line, edit, pairs] {
      const Client client = line.client();
      const Json read = client.get_json("/api/settings");
      return edit->edit(client, read, patch_that_sets(read.at("settings"), pairs));
    };
  });
}

void add_remove(CommandLine& line, CLI::App* parent) {
  struct Options {
    std::string pointer;
    EditOptions edit;
  };
  const auto o = std::make_shared<Options>();
  CLI::App* command =
      parent->add_subcommand("remove", "remove a list's entry, or put a setting back to its default");
  command->add_option("pointer", o->pointer, kPointer)->required();
  o->edit.add_to(command);
  line.on(command, [&line, o] {
    const Client client = line.client();
    const Json read = client.get_json("/api/settings");
    value_at(read.at("settings"), o->pointer);
    return o->edit.edit(client, read, Json::array({{{"op", "remove"}, {"path", o->pointer}}}));
  });
}

void add_settings_export(CommandLine& line, CLI::App* parent) {
  const auto file = std::make_shared<std::string>("-");
  CLI::App* command = parent->add_subcommand("export", "write all settings as a settings file");
  command->add_option("file", *file, "file to write; -: standard output")->capture_default_str();
  line.on(command, [&line, file] {
    const Json answer = line.client().get_json("/api/settings");
    Json tree{{kVersionKey, answer.value("version", 1)}};
    tree.update(answer.at("settings"));
    Output output(*file);
    output.stream() << terminal_json(tree) << "\n";
    output.finish();
    output.tell();
    return EXIT_SUCCESS;
  });
}

void add_settings_import(CommandLine& line, CLI::App* parent) {
  struct Options {
    std::string file;
    EditOptions edit;
  };
  const auto o = std::make_shared<Options>();
  CLI::App* command = parent->add_subcommand(
      "import", "replace all settings by a settings file; what the file leaves out gets its default");
  command->add_option("file", o->file, "settings file")->required();
  o->edit.add_to(command);
  line.on(command, [&line, o] {
    const Json settings = read_json_file(o->file);
    const Client client = line.client();
    return o->edit.edit(client, client.get_json("/api/settings"),
                        Json::array({{{"op", "replace"}, {"path", ""}, {"value", settings}}}));
  });
}

void add_schema(CommandLine& line, CLI::App* parent) {
  struct Options {
    std::string pointer;
    bool as_json = false;
  };
  const auto o = std::make_shared<Options>();
  CLI::App* command =
      parent->add_subcommand("schema", "show what can be set: key, type, range, unit and meaning");
  command->add_option("pointer", o->pointer, "only this part, such as /field or /cameras/0/source");
  command->add_flag("--json", o->as_json, "all of it as a JSON Schema")->excludes("pointer");
  line.on(command, [&line, o] {
    const Json schema = line.client().get_json("/api/schema");
    std::cout << (o->as_json ? terminal_json(schema) + "\n" : schema_text(plain_answer(schema), o->pointer));
    return EXIT_SUCCESS;
  });
}

std::string profile_path(const std::string& name) {
  return "/api/profiles/" + path_part(name);
}

void add_profile_apply(CommandLine& line, CLI::App* parent) {
  struct Options {
    std::string name;
    std::vector<std::string> only;
    bool as_json = false;
  };
  const auto o = std::make_shared<Options>();
  CLI::App* command = parent->add_subcommand("apply", "apply a profile, or parts of it: live and saved");
  command->add_option("name", o->name, "the profile")->required();
  command->add_option("--only", o->only, "JSON pointers: apply only these parts");
  command->add_flag("--json", o->as_json, "changes and revision as JSON");
  line.on(command, [&line, o] {
    const Client client = line.client();
    const Json read = client.get_json("/api/settings");
    const Json asked = o->only.empty() ? Json::object() : Json{{"paths", o->only}};
    print_answer(edit_between(read, client.post(profile_path(o->name) + "/apply", asked,
                                                read.at("revision").get<std::uint64_t>())),
                 o->as_json, edit_text);
    return EXIT_SUCCESS;
  });
}

std::string presets_text(const Json& presets) {
  std::string out;
  for (const Json& preset : presets) {
    const Json& field = preset.at("field");
    out += fmt::format("{:<12}  {} x {} mm  {}\n", preset.at("name").get<std::string>(),
                       field.at("field_length").get<int>(), field.at("field_width").get<int>(),
                       preset.at("description").get<std::string>());
  }
  return out;
}

const Json& preset_named(const Json& presets, const std::string& name) {
  std::string known;
  for (const Json& preset : presets) {
    if (preset.at("name") == name) return preset;
    known += (known.empty() ? "" : ", ") + preset.at("name").get<std::string>();
  }
  throw std::runtime_error(fmt::format("no field \"{}\"; known: {}", name, known));
}

}  // namespace

void add_settings(CommandLine& line) {
  CLI::App* settings = line.app.add_subcommand("settings", "show and change the service's settings");
  settings->require_subcommand(1);
  add_get(line, settings);
  add_set(line, settings);
  add_remove(line, settings);
  add_settings_export(line, settings);
  add_settings_import(line, settings);
  add_schema(line, settings);
}

void add_field_presets(CommandLine& line, CLI::App* field) {
  const auto as_json = std::make_shared<bool>(false);
  CLI::App* presets = field->add_subcommand("presets", "list the fields that are known");
  add_json_flag(presets, *as_json);
  line.on(presets, [&line, as_json] {
    print_answer(line.client().get_json("/api/field/presets"), *as_json, presets_text);
    return EXIT_SUCCESS;
  });

  struct Options {
    std::string name;
    EditOptions edit;
  };
  const auto o = std::make_shared<Options>();
  CLI::App* set = field->add_subcommand("set", "use one of them as the field of the settings");
  set->add_option("preset", o->name, "its name, such as division-b")->required();
  o->edit.add_to(set);
  line.on(set, [&line, o] {
    const Client client = line.client();
    const Json presets_now = client.get_json("/api/field/presets");
    Json field_now = preset_named(presets_now, o->name).at("field");
    const Json settings = client.get_json("/api/settings");
    // The processing of the cameras' detections is not part of a preset.
    for (const char* kept : {"stack", "stages", "other_computers"})
      field_now[kept] = settings.at("settings").at("field").at(kept);
    return o->edit.edit(client, settings,
                        Json::array({{{"op", "replace"}, {"path", "/field"}, {"value", field_now}}}));
  });
}

void add_profiles(CommandLine& line) {
  CLI::App* profiles = line.app.add_subcommand("profiles", "settings that are saved under a name");
  profiles->require_subcommand(0, 1);
  struct Options {
    std::string name;
    bool as_json = false;
  };
  const auto o = std::make_shared<Options>();
  add_json_flag(profiles, o->as_json);
  profiles->callback([&line, o, profiles] {
    if (!profiles->get_subcommands().empty()) return;
    line.act = [&line, o] {
      print_answer(line.client().get_json("/api/profiles").at("profiles"), o->as_json, profiles_text);
      return EXIT_SUCCESS;
    };
  });
  const auto add = [&](const char* name, const char* help) {
    CLI::App* command = profiles->add_subcommand(name, help);
    command->add_option("name", o->name, "the profile")->required();
    add_json_flag(command, o->as_json);
    return command;
  };
  line.on(add("save", "save the current settings under a name"), [&line, o] {
    print_answer(line.client().put(profile_path(o->name), Json::object()), o->as_json,
                 [](const Json& saved) { return "saved as " + saved.at("name").get<std::string>() + "\n"; });
    return EXIT_SUCCESS;
  });
  line.on(add("show", "show what applying a profile would change now"), [&line, o] {
    print_answer(line.client().get_json(profile_path(o->name)), o->as_json, profile_text);
    return EXIT_SUCCESS;
  });
  add_profile_apply(line, profiles);
  line.on(add("delete", "delete a profile"), [&line, o] {
    print_answer(line.client().remove(profile_path(o->name)).at("profiles"), o->as_json, profiles_text);
    return EXIT_SUCCESS;
  });
}

void add_history(CommandLine& line) {
  const auto as_json = std::make_shared<bool>(false);
  CLI::App* command =
      line.app.add_subcommand("history", "show what was changed in the service's settings, newest first");
  add_json_flag(command, *as_json);
  line.on(command, [&line, as_json] {
    print_answer(line.client().get_json("/api/settings/history"), *as_json, history_text);
    return EXIT_SUCCESS;
  });
}

void add_undo(CommandLine& line) {
  struct Options {
    std::uint64_t revision = 0;
    bool as_json = false;
  };
  const auto o = std::make_shared<Options>();
  CLI::App* command = line.app.add_subcommand("undo", "undo one step of the history; later steps stay");
  command->add_option("revision", o->revision, "number of the step, as `history` shows it")->required();
  add_json_flag(command, o->as_json);
  line.on(command, [&line, o] {
    print_answer(line.client().post("/api/settings/undo", {{"revision", o->revision}}), o->as_json,
                 [](const Json& answer) {
                   return fmt::format("Undone; the settings are at revision {}.\n",
                                      answer.at("revision").get<std::uint64_t>());
                 });
    return EXIT_SUCCESS;
  });
}

}  // namespace sslv
