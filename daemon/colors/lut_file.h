// SPDX-License-Identifier: Apache-2.0
#pragma once

// Formats in which tables come and go besides our `.lut` (vision/lut_codec.h): our JSON, SSL-Vision's XML.

#include "vision/label.h"
#include "vision/lut.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sslv {

/// {"format": "ssl-visiond colour table", "version": 1, "bits", "labels": [{value, name, color}], "runs":
/// base64 of the runs of a .lut file}.
std::string table_json_text(const ColorTable& table, const LabelSet& labels = LabelSet::built_in());

/// A table out of a file.
struct ImportedTable {
  std::string name;           // where in the file: "camera 0", "/Camera 1/LUT 3D/LUT Data"; else the file's
  std::optional<int> camera;  // that the file has it for
  std::string format;         // for people: "SSL-Vision XML, 4/6/6 bits"
  ColorTable table;
};

/// All tables of a file, whose format is told by its content: .lut (1 and 2), our JSON, SSL-Vision's XML (a
/// LUT alone or somewhere in a tree of settings). At least one. Labels are found by name; in SSL-Vision's
/// files and .lut 1 by value. Throws SettingsError, beginning with `file_name`, for what cannot be used: no
/// table in it, wrong size, unknown labels, broken base64...
std::vector<ImportedTable> import_tables(std::span<const std::uint8_t> bytes, const std::string& file_name,
                                         const LabelSet& labels = LabelSet::built_in());

/// The one that is meant: by its place in the list, else by camera, else the only one. Throws SettingsError
/// naming all when that does not tell.
const ImportedTable& choose_table(const std::vector<ImportedTable>& tables, std::optional<std::size_t> index,
                                  std::optional<int> camera, const std::string& file_name);

}  // namespace sslv
