// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

namespace sslv {

/// Height of a team's pattern above the floor in mm; empty for an unknown team. `name` (UTF-8) may differ
/// from the team's own spelling in case, spaces, punctuation, accents and Unicode form.
std::optional<double> team_height_mm(std::string_view name);

/// Whether two names are equal except for the differences that team_height_mm() ignores.
bool is_same_team(std::string_view name, std::string_view other);

}  // namespace sslv
