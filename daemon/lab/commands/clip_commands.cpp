// SPDX-License-Identifier: Apache-2.0
#include "base/error.h"
#include "base/plain_text.h"
#include "lab/commands/commands.h"
#include "lab/commands/offline_options.h"
#include "lab/replay.h"

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <optional>
#include <string>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Selects frames of a clip.
struct ClipChoice {
  std::filesystem::path clip;
  std::uint32_t camera_id = 0;
  double from_s = 0, to_s = 0;
  CLI::Option *camera = nullptr, *to = nullptr;

  void add_to(CLI::App* command) {
    command->add_option("clip", clip, "the clip")->required();
    camera = command->add_option("--camera", camera_id, "id of a camera; default: all of the clip");
    command->add_option("--from", from_s, "s since the clip's first frame")->check(kFinite);
    to = command->add_option("--to", to_s, "s since the clip's first frame")->check(kFinite);
  }
  std::optional<std::uint32_t> camera_or_all() const {
    return camera->count() > 0 ? std::optional(camera_id) : std::nullopt;
  }
  ClipSpan span() const { return {from_s, to->count() > 0 ? std::optional(to_s) : std::nullopt}; }
};

/// Reads a colour table with the settings' own labels; without settings, with the built-in labels only.
std::shared_ptr<const Lut> table_in(const std::string& file, const Config* settings) {
  const LabelSet labels = settings != nullptr ? LabelSet(settings->own_labels, "/own_labels") : LabelSet();
  return read_lut(file, "--lut", labels);
}

/// Exit code for errors. As with diff, 1 means that there are differences.
constexpr int kTrouble = 2;

/// Returns the result of `act`. Errors get the clip's name, unless they begin with that name or
/// with `settings_file`.
template <class Act>
int with_clip(const std::filesystem::path& file, const std::string& settings_file, const Act& act) {
  const std::string name = file.string();
  const auto named = [&](const std::string& what) {
    const bool has_name =
        what.starts_with(name) || (!settings_file.empty() && what.starts_with(settings_file));
    return has_name ? what : name + ": " + what;
  };
  try {
    ClipReader clip(file);
    return act(clip);
  } catch (const SettingsError& error) {
    throw SettingsError(named(error.what()));
  } catch (const ClipError& error) {
    std::cerr << "ssl-visionlab: " << escaped_lines(named(error.what())) << "\n";
    return kTrouble;
  } catch (const StorageError& error) {
    std::cerr << "ssl-visionlab: " << escaped_lines(error.what()) << "\n";
    return kTrouble;
  }
}

}  // namespace

void add_replay(CommandLine& line) {
  struct Options {
    ClipChoice choice;
    StageFolders stage_folders;
    std::string settings_file, lut_file, output;
    CompareLimits limits;
    bool compares = false, as_json = false;
  };
  const auto o = std::make_shared<Options>();
  auto* command = line.app.add_subcommand(
      "replay",
      "run a clip's frames through the stack again, as the live run did or with other settings. Exit code of "
      "--compare, like diff: 0: the same, 1: differences, 2: trouble");
  o->choice.add_to(command);
  command->add_option("--settings", o->settings_file, "settings to use instead of the clip's");
  command->add_option("--lut", o->lut_file, "colour table (.lut) to use instead of the clip's");
  add_stages_options(command, o->stage_folders);
  command->add_flag("--compare", o->compares,
                    "compare with the packets that were sent live, byte by byte; with --settings or --lut, "
                    "what is found with the clip's own settings and with those");
  command->add_option("--moved", o->limits.moved_mm, "mm; what is less far away has not moved")
      ->check(kFinite)
      ->capture_default_str();
  command->add_option("--turned", o->limits.turned_deg, "deg; likewise for robots' orientations")
      ->check(kFinite)
      ->capture_default_str();
  command->add_option("--output", o->output,
                      "file for what is found, one JSON object a line for each frame; -: standard output");
  add_json_flag(command, o->as_json);
  line.on(command, [o] {
    add_stage_libraries(o->stage_folders, MissingStages::kRefused);
    return with_clip(o->choice.clip, o->settings_file, [&](ClipReader& clip) {
      ReplayCommand replay{
          .camera_id = o->choice.camera_or_all(), .span = o->choice.span(), .limits = o->limits};
      replay.compares = o->compares;
      if (!o->settings_file.empty() || !o->lut_file.empty()) {
        OtherSetup& other = replay.other.emplace();
        other.path = o->settings_file;
        if (!o->settings_file.empty())
          other.settings = std::make_shared<const Config>(settings_in(o->settings_file));
        if (!o->lut_file.empty()) other.table = table_in(o->lut_file, other.settings.get());
      }
      std::optional<Output> found;
      if (!o->output.empty()) replay.found = &found.emplace(o->output).stream();
      const std::vector<ReplayedCamera> cameras = replay_cameras(clip, replay);
      if (found) found->finish();
      (o->output == "-" ? std::cerr : std::cout)
          << (o->as_json ? json_text(replayed_json(cameras), 2) + "\n"
                         : replayed_text(cameras, replay.other.has_value()));
      const bool differs =
          std::any_of(cameras.begin(), cameras.end(), [](const ReplayedCamera& one) { return one.differs; });
      return differs ? EXIT_FAILURE : EXIT_SUCCESS;
    });
  });
}

void add_clip(CommandLine& line) {
  auto* group = line.app.add_subcommand("clip", "look into clips: the last seconds' raw frames");
  group->require_subcommand(1);
  struct Options {
    ClipChoice choice;
    std::filesystem::path clip;
    StageFolders stage_folders;
    ExportOptions to;
    bool as_json = false;
  };
  const auto o = std::make_shared<Options>();
  auto* info = group->add_subcommand("info", "what a clip holds: cameras, frames, what is missing, events");
  info->add_option("clip", o->clip, "the clip")->required();
  add_json_flag(info, o->as_json);
  line.on(info, [o] {
    return with_clip(o->clip, {}, [&](const ClipReader& clip) {
      print_answer(clip_info_json(o->clip, clip), o->as_json, clip_info_text);
      return EXIT_SUCCESS;
    });
  });

  auto* write =
      group->add_subcommand("export", "write a clip's frames as files, with what was found in them");
  o->choice.add_to(write);
  write->add_option("--output", o->to.folder, "new folder to write to")->required();
  const auto set_format = [o](const std::string& name) {
    o->to.format = name == "raw" ? ExportFormat::kRaw : ExportFormat::kPng;
  };
  write->add_option_function<std::string>("--format", set_format, "png: RGB; raw: the camera's bytes")
      ->check(CLI::IsMember({"png", "raw"}))
      ->default_str("png");
  write->add_flag("--coco", o->to.with_coco, "what was found as COCO's JSON, too: boxes of robots and balls");
  write->add_flag(
      "--anonymous", o->to.is_anonymous,
      "all is black but the field up to 300 mm outside its lines, and robots there; who stands on "
      "it or in front of it is still seen");
  add_stages_options(write, o->stage_folders);
  line.on(write, [o] {
    add_stage_libraries(o->stage_folders, MissingStages::kRefused);
    return with_clip(o->choice.clip, {}, [&](ClipReader& clip) {
      o->to.camera_id = o->choice.camera_or_all();
      o->to.span = o->choice.span();
      std::cout << exported_text(export_clip(clip, o->to));
      return EXIT_SUCCESS;
    });
  });
}

}  // namespace sslv
