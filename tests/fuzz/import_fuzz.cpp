// SPDX-License-Identifier: Apache-2.0
// libFuzzer: any file yields complete tables or one SettingsError, and tables survive a round trip. The first
// "@@" in an input is replaced by a LUT of SSL-Vision, which is longer than inputs are; only in one of eight
// inputs, as that takes long. ./run test-long
#include "base/base64.h"
#include "base/error.h"
#include "colors/lut_file.h"
#include "fuzz/expect.h"
#include "vision/lut_codec.h"

#include <algorithm>
#include <string>

namespace sslv {
namespace {

std::string expanded(const std::string& input) {
  static const std::string lut = [] {
    std::vector<std::uint8_t> bytes(65'536);
    for (std::size_t i = 0; i < bytes.size(); ++i)
      bytes[i] = static_cast<std::uint8_t>(i / 100 % label::kCount);
    return to_base64(bytes);
  }();
  const std::size_t at = input.find("@@");
  if (at == std::string::npos || input.size() % 8 != 0) return input;
  return input.substr(0, at) + lut + input.substr(at + 2);
}

void check(const std::string& file) {
  static const LabelSet labels({{10, "purple"}}, "");
  std::vector<ImportedTable> tables;
  try {
    tables = import_tables({reinterpret_cast<const std::uint8_t*>(file.data()), file.size()}, "file", labels);
  } catch (const SettingsError& error) {
    const std::string text = error.what();
    expect(text.rfind("file: ", 0) == 0, "an error does not name the file");
    return;
  }
  expect(!tables.empty(), "neither tables nor an error");
  for (const ImportedTable& each : tables) {
    const ColorTable& table = each.table;
    expect(table.bits >= 5 && table.bits <= 8, "bits");
    expect(table.labels.size() == std::size_t{1} << (3 * table.bits), "number of labels");
    expect(*std::max_element(table.labels.begin(), table.labels.end()) < label::kMaxCount, "labels");
  }
  const ColorTable& table = tables.back().table;
  if (table.bits > 6) return;  // takes long
  expect(decode_lut(encode_lut(table, labels), "", labels) == table, ".lut");
  const std::string json = table_json_text(table, labels);
  expect(
      import_tables({reinterpret_cast<const std::uint8_t*>(json.data()), json.size()}, "", labels)[0].table ==
          table,
      "JSON");
}

}  // namespace
}  // namespace sslv

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  sslv::check(sslv::expanded({reinterpret_cast<const char*>(bytes), size}));
  return 0;
}
