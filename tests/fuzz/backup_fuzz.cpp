// SPDX-License-Identifier: Apache-2.0
// libFuzzer: any file is either read as a backup of limited total size or refused with a one-line error. The
// backup's contents are parsed as far as possible without a service. The first byte selects how the rest is
// used: a file as it is, a tar that is compressed first, or the JSON of one file in a backup with correct
// checksums. ./run test-long
#include "base/error.h"
#include "base/sha256.h"
#include "fuzz/expect.h"
#include "fuzz/live_bytes.h"
#include "services/backup/backup_file.h"
#include "services/backup/kept_settings.h"
#include "services/calibration/calibration_history.h"
#include "settings/backup_limits.h"
#include "settings/passwords.h"
#include "settings/profiles.h"
#include "web/tar_file.h"

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <zlib.h>

namespace sslv {
namespace {

std::string packed(std::string_view bytes) {
  z_stream zlib{};
  expect(deflateInit2(&zlib, 1, Z_DEFLATED, 16 + MAX_WBITS, 9, Z_DEFAULT_STRATEGY) == Z_OK, "no zlib");
  std::string out(deflateBound(&zlib, bytes.size()), '\0');
  zlib.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(bytes.data()));  // zlib only reads it
  zlib.avail_in = static_cast<uInt>(bytes.size());
  zlib.next_out = reinterpret_cast<Bytef*>(out.data());
  zlib.avail_out = static_cast<uInt>(out.size());
  deflate(&zlib, Z_FINISH);
  out.resize(out.size() - zlib.avail_out);
  deflateEnd(&zlib);
  return out;
}

std::string with_right_sums(const char* name, std::string_view content) {
  static const std::string manifest =
      R"({"format": "ssl-visiond backup", "format_version": 1, "version": "1", "time": 1, "computer": "", "site": ""})";
  std::vector<TarEntry> files{{"manifest.json", manifest}, {name, std::string(content)}};
  std::string sums;
  for (const TarEntry& file : files) sums += sha256_of(file.content) + "  " + file.name + "\n";
  files.push_back({"SHA256SUMS", sums});
  return tar_gz(files, 0);
}

/// Runs `read`, which must succeed or throw SettingsError with a one-line message.
void try_out(const auto& read) {
  try {
    read();
  } catch (const SettingsError& error) {
    const std::string text = error.what();
    expect(!text.empty() && text.find('\n') == std::string::npos, "a refusal is one line");
  }
}

void read_through(std::string_view bytes) {
  try_out([&] {
    const Backup backup = read_backup(bytes);
    std::size_t size = 0;
    for (const auto& [name, content] : backup.files) {
      size += content.size();
      const std::string& text = content;
      if (name == kSettingsName) try_out([&] { read_kept_settings(text); });
      if (name == Profiles::kFileName) try_out([&] { Profiles::from_text(text); });
      if (name == Passwords::kFileName) try_out([&] { Passwords::check_text(text); });
      if (name == CalibrationHistory::kFileName) try_out([&] { CalibrationHistory::from_text(text); });
    }
    expect(size <= kMaxUnpackedBackupBytes, "more than a backup may have");
    try_out([&] { files_summary(backup.files); });
  });
}

}  // namespace
}  // namespace sslv

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace sslv;
  if (size == 0) return 0;
  const LiveBytes live(kMaxLiveBytes);
  const std::string_view rest(reinterpret_cast<const char*>(bytes + 1), size - 1);
  constexpr const char* kNames[] = {kSettingsName, Profiles::kFileName, Passwords::kFileName,
                                    CalibrationHistory::kFileName, "tables/0123456789abcdef.lut"};
  switch (bytes[0] % 8) {
    case 0: read_through(rest); break;
    case 1:
    case 2: read_through(packed(rest)); break;
    default: read_through(with_right_sums(kNames[bytes[0] % 8 - 3], rest));
  }
  return 0;
}
