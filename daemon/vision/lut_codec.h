// SPDX-License-Identifier: Apache-2.0
#pragma once

// The `.lut` file. Version 2: 8 bytes "SSLVLUT2", a byte of bits a channel, a byte with the number of labels
// that occur, for each a byte of value, a byte of length and its name (none: its value tells); then runs to
// the end of the table, each a byte of label and its length as LEB128 (seven bits a byte, lowest first, the
// highest bit set when more follow). Version 3, written for tables that tell prints: "SSLVLUT3", and between
// labels and runs a byte with the number of prints, for each a byte of label, then shares of red, green, blue
// and their spread (PrintColor), two bytes each, lowest first. Version 1, still read: 8 bytes "SSLVLUT1",
// then one label for each of 128^3 cells.

#include "vision/label.h"
#include "vision/lut.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace sslv {

std::vector<std::uint8_t> encode_lut(const ColorTable& table, const LabelSet& labels = LabelSet::built_in());

/// Labels are found by name. Throws SettingsError, beginning with `path`.
ColorTable decode_lut(std::span<const std::uint8_t> bytes, const std::string& path,
                      const LabelSet& labels = LabelSet::built_in());
/// Whether they begin as a .lut file does.
bool is_lut(std::span<const std::uint8_t> bytes);

/// Whether the shares add up to 1 and the spread is no larger.
bool is_print(const PrintColor& print);

/// The runs alone.
std::vector<std::uint8_t> encode_runs(const ColorTable& table);
/// Throws SettingsError when the runs do not fill a table of `bits` exactly, or label::kMaxCount is passed.
ColorTable decode_runs(std::span<const std::uint8_t> runs, int bits, const std::string& path);

}  // namespace sslv
