// SPDX-License-Identifier: Apache-2.0
// In a header alone: ssl-visionctl shows found cameras too, and links no engine.
#pragma once

#include "base/json.h"

#include <string>

#include <fmt/format.h>

namespace sslv {

/// Text about the found cameras for a terminal, with the settings lines to paste.
inline std::string found_cameras_text(const Json& found) {
  std::string out;
  for (const Json& source : found) {
    out += fmt::format("{}\n  \"source\": {}\n", source.at("name").get<std::string>(),
                       json_text(source.at("source")));
    std::string formats;
    for (const Json& format : source.at("formats"))
      formats += (formats.empty() ? "" : ", ") + format.get<std::string>();
    if (!formats.empty()) out += "  pixel formats: " + formats + "\n";
  }
  return out.empty()
             ? "No camera found. Check power, cable and network; GigE cameras must have an address of "
               "your network.\n"
             : out;
}

}  // namespace sslv
