// SPDX-License-Identifier: Apache-2.0
#pragma once

// File formats of tables besides `.lut` (vision/lut_codec.h): our JSON; SSL-Vision's XML for import only.

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

/// A table read from a file.
struct ImportedTable {
  std::string name;  // its place in the file: "camera 0", "/Camera 1/LUT 3D/LUT Data"; else the file's name
  std::optional<int> camera;  // camera to which the file assigns the table
  std::string format;         // for the user: "SSL-Vision XML, 4/6/6 bits"
  ColorTable table;
};

/// All tables of a file, at least one. The content determines the format: .lut (1 and 2), our JSON,
/// SSL-Vision's XML (a LUT alone or somewhere in a tree of settings). Labels are matched by name; in
/// SSL-Vision's files and .lut 1 by value. Throws SettingsError, beginning with `file_name`, for files that
/// cannot be used: no table, wrong size, unknown labels, broken base64...
std::vector<ImportedTable> import_tables(std::span<const std::uint8_t> bytes, const std::string& file_name,
                                         const LabelSet& labels = LabelSet::built_in());

/// Selects the table with this index; without an index, the table of this camera; without a camera, the only
/// table. Throws SettingsError naming all tables if this does not select exactly one table.
const ImportedTable& choose_table(const std::vector<ImportedTable>& tables, std::optional<std::size_t> index,
                                  std::optional<int> camera, const std::string& file_name);

}  // namespace sslv
