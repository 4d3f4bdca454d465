// SPDX-License-Identifier: Apache-2.0
#include "ctl/colors.h"

#include "colors/margin_text.h"

#include <chrono>
#include <thread>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

std::string step_text(const Json& step) {
  if (!step.is_object()) return "nothing";
  return fmt::format("{}, {} cells, by {}", step.at("what").get<std::string>(),
                     step.at("cells").get<std::size_t>(), step.at("who").get<std::string>());
}

std::string light_text(const Json& light) {
  const std::string state = light.at("state").get<std::string>();
  if (state == "off") return "not followed\n";
  const Json& gain = light.at("gain");
  std::string out =
      fmt::format("{}; red x {:.2f}, green x {:.2f}, blue x {:.2f} since the table was accepted",
                  state == "at_bound" ? "at its limit" : state, gain.at(0).get<double>(),
                  gain.at(1).get<double>(), gain.at(2).get<double>());
  const std::string reason = light.at("reason").get<std::string>();
  return out + (reason.empty() ? "\n" : "; " + reason + "\n");
}

std::size_t found(const Json& pictures, const char* when, const char* what) {
  std::size_t sum = 0;
  for (const Json& picture : pictures) sum += picture.at(when).at(what).size();
  return sum;
}

}  // namespace

std::string colors_text(const Json& state) {
  std::string out = fmt::format("camera {}: {}, {} bits a channel\n", state.at("camera").get<int>(),
                                state.at("origin") == "table"  ? "a table of its own"
                                : state.at("origin") == "file" ? "the settings' lut_file"
                                                               : "the settings' colour classes",
                                state.at("bits").get<int>());
  for (const Json& label : state.at("labels")) {
    if (label.at("name") == "clear" || label.at("cells") == 0) continue;
    out += fmt::format("  {:<10} {:>8} cells\n", label.at("name").get<std::string>(),
                       label.at("cells").get<std::size_t>());
  }
  for (const Json& conflict : state.at("conflicts")) {
    out +=
        fmt::format("  {} and {} touch in {} cells\n", conflict.at("labels").at(0).get<std::string>(),
                    conflict.at("labels").at(1).get<std::string>(), conflict.at("cells").get<std::size_t>());
  }
  out += margins_text(state.at("margins"));
  out += "  to undo: " + step_text(state.at("undo")) + "\n  light: " + light_text(state.at("light"));
  return out;
}

std::string margins_text(const Json& margins) {
  if (margins.is_null()) return "  margins: carpet and floor were not seen yet\n";
  if (margins.empty()) return "";
  std::string out =
      fmt::format("  margins, to the carpet at least {:.0f} % are wanted:\n", 100 * kWantedMargin);
  for (const Json& margin : margins) {
    const std::string label = margin.at("label").get<std::string>(),
                      surface = margin.at("surface").get<std::string>();
    std::string text;
    bool is_thin = false;
    for (const auto& [key, sign] : {std::pair{"brighter", 1}, std::pair{"darker", -1}}) {
      if (!margin.at(key).is_number()) continue;
      const double share = margin.at(key).get<double>();
      is_thin = is_thin || (share < kWantedMargin && surface == "carpet");
      text += (text.empty() ? "" : ", ") + margin_text(surface, label, sign * share);
    }
    if (text.empty()) text = surface + " never does";
    out += fmt::format("    {:<10} {}{}\n", label, text, is_thin ? "  THIN" : "");
  }
  return out;
}

std::string tables_text(const Json& import) {
  std::string out;
  int number = 0;
  for (const Json& table : import.at("tables")) {
    std::string labels;
    for (const Json& label : table.at("labels"))
      labels += (labels.empty() ? "" : ", ") + label.get<std::string>();
    out += fmt::format("{}: {} ({}), {} cells: {}\n", number++, table.at("name").get<std::string>(),
                       table.at("format").get<std::string>(), table.at("cells").get<std::size_t>(), labels);
  }
  return out;
}

Json learn_running(const Client& daemon, int camera_id, int frames) {
  const std::string path = fmt::format("/api/cameras/{}/colors/learning", camera_id);
  Json state = daemon.post(path, {{"frames", frames}});
  while (state.at("state") == "collecting" || state.at("state") == "solving") {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    state = daemon.get_json(path);
  }
  if (!state.at("report").is_object()) {
    const std::string problem = state.at("problem").get<std::string>();
    throw ClientError(problem.empty() ? fmt::format("learning did not finish: it is {}",
                                                    state.at("state").get<std::string>())
                                      : problem);
  }
  return state.at("report");
}

std::string learning_text(const Json& report) {
  if (report.at("learnt") != true) return "NOT learnt: " + report.at("problem").get<std::string>() + "\n";
  const Json& pictures = report.at("pictures");
  std::string out = fmt::format(
      "Learnt in {:.1f} s from {} yellow and {} blue robots and {} balls of {} images.\n"
      "  found before: {} robots, {} balls; with the learnt table: {} robots, {} balls\n",
      report.at("seconds").get<double>(), report.at("robots").at("yellow").get<int>(),
      report.at("robots").at("blue").get<int>(), report.at("balls").get<int>(), pictures.size(),
      found(pictures, "before", "robots"), found(pictures, "before", "balls"),
      found(pictures, "after", "robots"), found(pictures, "after", "balls"));
  for (const Json& color : report.at("colors")) {
    const Json& mean = color.at("mean");
    out +=
        fmt::format("  {:<8} {:>4} samples, red {:.0f}, green {:.0f}, blue {:.0f}; {} cells, {} before\n",
                    color.at("label").get<std::string>(), color.at("samples").get<int>(),
                    mean.at(0).get<double>(), mean.at(1).get<double>(), mean.at(2).get<double>(),
                    color.at("after_cells").get<std::size_t>(), color.at("before_cells").get<std::size_t>());
  }
  for (const Json& note : report.at("notes")) out += "note: " + note.get<std::string>() + "\n";
  return out;
}

}  // namespace sslv
