// SPDX-License-Identifier: Apache-2.0
#include "vision/lut_codec.h"

#include "base/error.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr std::string_view kMagic1 = "SSLVLUT1", kMagic2 = "SSLVLUT2", kMagic3 = "SSLVLUT3";
constexpr int kBits1 = 7;
/// Highest shift in a run's length: 8 bits per channel make up to 2^24 cells.
constexpr int kHighestShift = 21;

bool begins_with(std::span<const std::uint8_t> bytes, std::string_view text) {
  return bytes.size() >= text.size() && std::equal(text.begin(), text.end(), bytes.begin());
}

template <class... Args>
[[noreturn]] void refuse_table(const std::string& path, fmt::format_string<Args...> format, Args&&... args) {
  throw SettingsError(path + ": " + fmt::format(format, std::forward<Args>(args)...));
}

/// Reads a file from its beginning to its end.
class Reader {
 public:
  Reader(std::span<const std::uint8_t> bytes, const std::string& path) : left_(bytes), path_(path) {}

  std::uint8_t byte(std::string_view what) { return take(1, what)[0]; }
  std::span<const std::uint8_t> take(std::size_t count, std::string_view what) {
    if (left_.size() < count) refuse_table(path_, "the file ends within {}: it is cut off", what);
    const auto out = left_.first(count);
    left_ = left_.subspan(count);
    return out;
  }
  std::span<const std::uint8_t> left() const { return left_; }

 private:
  std::span<const std::uint8_t> left_;
  const std::string& path_;
};

ColorTable decode_version_1(std::span<const std::uint8_t> bytes, const std::string& path,
                            const LabelSet& labels) {
  ColorTable table(kBits1);
  const std::size_t expected = kMagic1.size() + table.labels.size();
  if (bytes.size() != expected) {
    refuse_table(
        path,
        "has {} bytes; a .lut file that begins with \"{}\" has {} (and then one label for each of 128 x "
        "128 x 128 colours)",
        bytes.size(), kMagic1, expected);
  }
  std::copy(bytes.begin() + kMagic1.size(), bytes.end(), table.labels.begin());
  std::array<bool, 256> occurs{};
  for (const Label label : table.labels) occurs[label] = true;
  for (std::size_t value = 0; value < occurs.size(); ++value) {
    if (occurs[value] && !labels.has(static_cast<Label>(value))) {
      refuse_table(path, "has an unknown label {}; expected one of {}", value, labels.names());
    }
  }
  return table;
}

using OurLabels = std::array<std::optional<Label>, label::kMaxCount>;

Prints read_prints(Reader& reader, const OurLabels& ours, const std::string& path) {
  Prints out;
  for (int left = reader.byte("its prints"); left > 0; --left) {
    const std::uint8_t value = reader.byte("its prints");
    if (value >= ours.size() || !ours[value])
      refuse_table(path, "has a print of label {} without a name", value);
    const auto number = [&] {
      const auto bytes = reader.take(2, "its prints");
      return static_cast<std::uint16_t>(bytes[0] | bytes[1] << 8);
    };
    PrintColor print{};
    for (std::uint16_t& share : print.chromaticity) share = number();
    print.spread = number();
    if (!is_print(print))
      refuse_table(path, "has a print of label {} whose shares do not add up to 1", value);
    out[*ours[value]] = print;
  }
  return out;
}

/// Decodes version 2 or 3.
ColorTable decode_runs_file(std::span<const std::uint8_t> bytes, const std::string& path,
                            const LabelSet& labels) {
  Reader reader(bytes.subspan(kMagic2.size()), path);
  const int bits = reader.byte("its header");
  OurLabels ours;
  for (int left = reader.byte("its header"); left > 0; --left) {
    const std::uint8_t value = reader.byte("its labels");
    const auto bytes_of_name = reader.take(reader.byte("its labels"), "its labels");
    const std::string name(bytes_of_name.begin(), bytes_of_name.end());
    if (value >= ours.size()) {
      refuse_table(path, "has a label {}; labels are 0 .. {}", value, label::kMaxCount - 1);
    }
    const auto found = name.empty() ? std::optional(value) : labels.find(name);
    if (!found) {
      refuse_table(path, "has an unknown label \"{}\"; expected one of {}, or add it to own_labels first",
                   name, labels.names());
    }
    ours[value] = found;
  }
  Prints prints;
  if (begins_with(bytes, kMagic3)) prints = read_prints(reader, ours, path);
  ColorTable table = decode_runs(reader.left(), bits, path);
  for (Label& label : table.labels) {
    if (!ours[label]) refuse_table(path, "has label {} without a name", label);
    label = *ours[label];
  }
  table.prints = prints;
  return table;
}

}  // namespace

bool is_print(const PrintColor& print) {
  constexpr int kRounding = 2;
  const int sum = print.chromaticity[0] + print.chromaticity[1] + print.chromaticity[2];
  return std::abs(sum - static_cast<int>(PrintColor::kUnit)) <= kRounding &&
         print.spread <= PrintColor::kUnit;
}

std::vector<std::uint8_t> encode_runs(const ColorTable& table) {
  std::vector<std::uint8_t> out;
  for (std::size_t i = 0; i < table.labels.size();) {
    std::size_t end = i + 1;
    while (end < table.labels.size() && table.labels[end] == table.labels[i]) ++end;
    out.push_back(table.labels[i]);
    std::size_t length = end - i;
    for (; length > 0x7F; length >>= 7) out.push_back(static_cast<std::uint8_t>(0x80 | (length & 0x7F)));
    out.push_back(static_cast<std::uint8_t>(length));
    i = end;
  }
  return out;
}

ColorTable decode_runs(std::span<const std::uint8_t> runs, int bits, const std::string& path) {
  if (bits < ColorTable::kMinBits || bits > ColorTable::kMaxBits) {
    refuse_table(path, "has {} bits a channel; expected {} .. {}", bits, ColorTable::kMinBits,
                 ColorTable::kMaxBits);
  }
  ColorTable table(bits);
  Reader reader(runs, path);
  for (std::size_t at = 0; at < table.labels.size();) {
    const Label label = reader.byte("its runs");
    if (label >= label::kMaxCount)
      refuse_table(path, "has a label {}; labels are 0 .. {}", label, label::kMaxCount - 1);
    std::size_t length = 0;
    std::size_t byte = 0x80;
    for (int shift = 0; (byte & 0x80) != 0; shift += 7) {
      byte = reader.byte("its runs");
      if (shift <= kHighestShift) length |= (byte & 0x7F) << shift;
      if (shift > kHighestShift || length > table.labels.size() - at) {
        refuse_table(path, "has a run at cell {} that is longer than the table of {}", at,
                     table.labels.size());
      }
    }
    if (length == 0) refuse_table(path, "has an empty run at cell {}", at);
    std::fill_n(table.labels.begin() + static_cast<std::ptrdiff_t>(at), length, label);
    at += length;
  }
  if (!reader.left().empty()) {
    refuse_table(path, "goes on after its last cell (bytes: {})", reader.left().size());
  }
  return table;
}

std::vector<std::uint8_t> encode_lut(const ColorTable& table, const LabelSet& labels) {
  std::array<bool, label::kMaxCount> occurs{};
  for (const Label label : table.labels) occurs[label] = true;
  const auto has_print = [&](std::size_t value) { return occurs[value] && table.prints[value]; };
  std::size_t prints = 0;
  for (std::size_t value = 0; value < occurs.size(); ++value) prints += has_print(value) ? 1 : 0;
  const std::string_view magic = prints > 0 ? kMagic3 : kMagic2;
  std::vector<std::uint8_t> out(magic.begin(), magic.end());
  out.push_back(static_cast<std::uint8_t>(table.bits));
  out.push_back(static_cast<std::uint8_t>(std::count(occurs.begin(), occurs.end(), true)));
  for (std::size_t value = 0; value < occurs.size(); ++value) {
    if (!occurs[value]) continue;
    const auto label = static_cast<Label>(value);
    const std::string name = labels.has(label) ? labels.name(label) : "";
    out.push_back(static_cast<std::uint8_t>(value));
    out.push_back(static_cast<std::uint8_t>(name.size()));
    out.insert(out.end(), name.begin(), name.end());
  }
  if (prints > 0) out.push_back(static_cast<std::uint8_t>(prints));
  for (std::size_t value = 0; prints > 0 && value < occurs.size(); ++value) {
    if (!has_print(value)) continue;
    const PrintColor& print = *table.prints[value];
    out.push_back(static_cast<std::uint8_t>(value));
    for (const std::uint16_t number :
         {print.chromaticity[0], print.chromaticity[1], print.chromaticity[2], print.spread}) {
      out.push_back(static_cast<std::uint8_t>(number & 0xFF));
      out.push_back(static_cast<std::uint8_t>(number >> 8));
    }
  }
  const std::vector<std::uint8_t> runs = encode_runs(table);
  out.insert(out.end(), runs.begin(), runs.end());
  return out;
}

bool is_lut(std::span<const std::uint8_t> bytes) {
  return begins_with(bytes, kMagic1) || begins_with(bytes, kMagic2) || begins_with(bytes, kMagic3);
}

ColorTable decode_lut(std::span<const std::uint8_t> bytes, const std::string& path, const LabelSet& labels) {
  if (begins_with(bytes, kMagic2) || begins_with(bytes, kMagic3))
    return decode_runs_file(bytes, path, labels);
  if (begins_with(bytes, kMagic1)) return decode_version_1(bytes, path, labels);
  refuse_table(path, "does not begin with \"{}\", \"{}\" or \"{}\", so it is not a .lut file", kMagic3,
               kMagic2, kMagic1);
}

}  // namespace sslv
