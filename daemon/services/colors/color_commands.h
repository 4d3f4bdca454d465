// SPDX-License-Identifier: Apache-2.0
#pragma once

// Clients' commands for a colour table: ColorEdits in docs/openapi.json.

#include "base/json.h"
#include "base/params.h"
#include "colors/table_edit.h"
#include "image/color.h"
#include "vision/label.h"

#include <optional>
#include <string>
#include <tuple>
#include <vector>

namespace sslv {

struct PickCommand {
  std::string op, label;
  int x = 0, y = 0, width = 1, height = 1;
  std::optional<int> still;
  bool take_away = false;
  static constexpr auto fields() {
    using P = PickCommand;
    return std::tuple{text("op", &P::op, "pick"),
                      text("label", &P::label, "a label's name"),
                      number("x", &P::x, 0, 16383, "px", "left"),
                      number("y", &P::y, 0, 16383, "px", "top"),
                      number("width", &P::width, 1, 16384, "px", ""),
                      number("height", &P::height, 1, 16384, "px", ""),
                      number("still", &P::still, 0, 2'000'000'000, "", "null: the newest image"),
                      flag("take_away", &P::take_away, "from the label instead of adding to it")};
  }
};

struct WidenCommand {
  std::string op;
  static constexpr auto fields() { return std::tuple{text("op", &WidenCommand::op, "widen_margins")}; }
};

struct EditRequest {
  Json commands;  // a list, not empty
  bool only_try = false;
};

/// Throws SettingsError.
EditRequest read_edit_request(const Json& json);

/// Throws SettingsError with a message that begins with `path`.
Label find_label(const LabelSet& labels, const std::string& name, const std::string& path);

/// Describes several edits by the first edit and the number of further edits.
std::string what_they_did(const std::vector<TableEdit>& edits, const LabelSet& labels);

/// Returns at most 20 000 evenly chosen pixels of a pick, which represent all of them.
std::vector<Yuv> thinned(std::vector<Yuv> pixels);

}  // namespace sslv
