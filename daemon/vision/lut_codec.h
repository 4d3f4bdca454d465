// SPDX-License-Identifier: Apache-2.0
#pragma once

// The `.lut` file.
//
// Version 2: 8 bytes "SSLVLUT2"; a byte: bits per channel; a byte: number of labels that occur; for each of
// these labels a byte with its value, a byte with the length of its name, and the name (empty: the value
// identifies the label). Then runs until the table is full, each a byte with the label and the run's length
// as LEB128 (seven bits per byte, lowest first, the highest bit set if more bytes follow).
//
// Version 3, written for tables with prints: "SSLVLUT3", and between labels and runs: a byte with the number
// of prints, then for each print a byte with its label, and its shares of red, green and blue and their
// spread (PrintColor) with two bytes each, lowest first.
//
// Version 1, still read: 8 bytes "SSLVLUT1", then one label for each of 128^3 cells.

#include "vision/label.h"
#include "vision/lut.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace sslv {

std::vector<std::uint8_t> encode_lut(const ColorTable& table, const LabelSet& labels = LabelSet::built_in());

/// Finds labels by name. Throws SettingsError, its message starting with `path`, for invalid bytes and
/// unknown labels.
ColorTable decode_lut(std::span<const std::uint8_t> bytes, const std::string& path,
                      const LabelSet& labels = LabelSet::built_in());
/// Whether the bytes begin like a .lut file.
bool is_lut(std::span<const std::uint8_t> bytes);

/// Whether the shares add up to 1 and the spread is at most 1.
bool is_print(const PrintColor& print);

/// Encodes only the runs.
std::vector<std::uint8_t> encode_runs(const ColorTable& table);
/// Throws SettingsError if the bits are not allowed, the runs do not fill a table of `bits` exactly, or a
/// label is not below label::kMaxCount.
ColorTable decode_runs(std::span<const std::uint8_t> runs, int bits, const std::string& path);

}  // namespace sslv
