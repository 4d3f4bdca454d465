// SPDX-License-Identifier: Apache-2.0
#include "lab/annotate.h"
#include "lab/commands/commands.h"
#include "lab/commands/offline_options.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <fmt/format.h>

namespace sslv {
namespace {

struct Arguments {
  CameraChoice choice;
  RawFormat raw;
  AnnotateOptions annotate;
  // Flat lists; each entry consists of kRobotWords, kBallWords or kIdWords values.
  std::vector<std::string> robots;
  std::vector<double> balls;
  std::vector<int> ids;
};
constexpr int kRobotWords = 6, kBallWords = 2, kIdWords = 2;

template <class Number>
Number number_of(const std::string& word) {
  Number out{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), out);
  if (error != std::errc() || end != word.data() + word.size())
    throw SettingsError(fmt::format("--robot: \"{}\" is not allowed; expected a number", word));
  return out;
}

void read_corrections(Arguments& o) {
  Corrections& corrections = o.annotate.corrections;
  for (std::size_t i = 0; i < o.robots.size(); i += kRobotWords) {
    const std::string* words = &o.robots[i];
    if (words[0] != "yellow" && words[0] != "blue")
      throw SettingsError(fmt::format("--robot: \"{}\" is not allowed; expected yellow or blue", words[0]));
    corrections.robots.push_back({words[0] == "blue" ? Team::kBlue : Team::kYellow, number_of<int>(words[1]),
                                  number_of<double>(words[2]), number_of<double>(words[3]),
                                  number_of<double>(words[4]), number_of<double>(words[5])});
  }
  for (std::size_t i = 0; i < o.balls.size(); i += kBallWords)
    corrections.balls.push_back({o.balls[i], o.balls[i + 1]});
  for (std::size_t i = 0; i < o.ids.size(); i += kIdWords)
    corrections.ids.emplace_back(o.ids[i], o.ids[i + 1]);
}

/// Quotes a word that a shell would split.
std::string shell_word(const std::string& word) {
  const bool plain = !word.empty() && std::all_of(word.begin(), word.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 ||
           std::string_view("_./:-").find(static_cast<char>(c)) != std::string_view::npos;
  });
  if (plain) return word;
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

std::string command_of(const Arguments& o) {
  std::string out = "ssl-visionlab annotate --settings " + shell_word(o.choice.settings_file);
  if (o.choice.camera_id != 0) out += fmt::format(" --camera {}", o.choice.camera_id);
  if (!o.choice.lut_file.empty()) out += " --lut " + shell_word(o.choice.lut_file);
  out += " --input " + shell_word(o.annotate.pictures.input);
  if (!o.raw.pixel_format.empty())
    out += " --pixel-format " + shell_word(o.raw.pixel_format) + " --size " + shell_word(o.raw.size);
  out += " --truth " + shell_word(o.annotate.truth_file);
  return out + " --pages " + shell_word(o.annotate.pages_folder);
}

}  // namespace

void add_annotate(CommandLine& line) {
  const auto o = std::make_shared<Arguments>();
  CLI::App* command = line.app.add_subcommand(
      "annotate",
      "make a truth file for `score` of a hall's own images: the detector drafts it, you correct it");
  o->choice.add_to(command);
  o->choice.add_lut_to(command);
  command
      ->add_option("--input", o->annotate.pictures.input,
                   "image, raw frame, video, or a folder of images or raw frames")
      ->required();
  o->raw.add_to(command);
  command->add_option("--truth", o->annotate.truth_file, "truth file to write or continue")->required();
  command->add_option("--pages", o->annotate.pages_folder,
                      "folder for a page of each image with numbered marks, to look at in a browser; "
                      "default: beside the truth file, named after it");
  command->add_option("--frame", o->annotate.frame,
                      "the image that is corrected, by its name without ending");
  command->add_option("--remove", o->annotate.corrections.remove, "marks of things that are not there")
      ->type_name("MARK");
  command
      ->add_option("--doubtful", o->annotate.corrections.doubtful,
                   "marks of things that may or may not be found")
      ->type_name("MARK");
  command->add_option("--id", o->ids, "a robot's mark and its true id")
      ->type_size(kIdWords)
      ->type_name("MARK ID");
  command
      ->add_option(
          "--robot", o->robots,
          "a robot that was missed: team, id, pixel of its middle, pixel of a place it looks towards")
      ->type_size(kRobotWords)
      ->type_name("TEAM ID X Y TOWARDS_X TOWARDS_Y");
  command->add_option("--ball", o->balls, "a ball that was missed: pixel of its middle")
      ->type_size(kBallWords)
      ->type_name("X Y");
  command->add_flag("--checked", o->annotate.corrections.checked,
                    "mark the image as checked, or all images without --frame: what is left is true");
  command->add_flag("--again", o->annotate.again, "draft existing images again: corrections are lost");
  line.on(command, [o] {
    o->raw.parse();
    read_corrections(*o);
    if (o->annotate.pages_folder.empty())
      o->annotate.pages_folder =
          std::filesystem::path(o->annotate.truth_file).replace_extension("").string() + "_pages";
    o->annotate.pictures.pixel_format = o->raw.pixel_format;
    o->annotate.pictures.width = o->raw.width;
    o->annotate.pictures.height = o->raw.height;
    o->annotate.command = command_of(*o);
    const Config config = o->choice.config();
    annotate(config, o->choice.index_in(config), o->annotate, std::cout, std::cerr);
    return EXIT_SUCCESS;
  });
}

}  // namespace sslv
