// SPDX-License-Identifier: Apache-2.0
#include "services/backup/backup_file.h"

#include "base/error.h"
#include "base/sha256.h"
#include "settings/backup_limits.h"
#include "web/tar_file.h"

#include <cstdint>

#include <gmock/gmock.h>

namespace sslv::backup_file_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

const Backup kBackup{{1'790'000'000.5, "1.2.3", "field-pc", "Hall"},
                     {{"settings.json", "{}\n"}, {"tables/0123456789abcdef.lut", std::string("\0\1\2", 3)}}};

std::string refusal(const std::string& bytes) {
  try {
    read_backup(bytes);
  } catch (const SettingsError& error) {
    return error.what();
  }
  return "none";
}

/// A forged backup, with valid checksums.
std::string forged(std::vector<TarEntry> entries) {
  std::string sums;
  for (const TarEntry& entry : entries) sums += sha256_of(entry.content) + "  " + entry.name + "\n";
  entries.push_back({"SHA256SUMS", sums});
  return tar_gz(entries, 0);
}

std::string manifest(const std::string& changes) {
  Json json{{"format", "ssl-visiond backup"},
            {"format_version", 1},
            {"version", "1.2.3"},
            {"time", 1},
            {"computer", "pc"},
            {"site", ""}};
  json.update(Json::parse(changes));
  return json.dump();
}

TEST(BackupFile, IsReadAsItWasWritten) {
  const Backup read = read_backup(write_backup(kBackup));
  EXPECT_EQ(read.files, kBackup.files);
  EXPECT_EQ(read.manifest.time_s, kBackup.manifest.time_s);
  EXPECT_EQ(read.manifest.version, "1.2.3");
  EXPECT_EQ(read.manifest.computer, "field-pc");
  EXPECT_EQ(read.manifest.site, "Hall");
}

TEST(BackupFile, AnyDamageIsFoundOrHarmless) {
  const std::string bytes = write_backup(kBackup);
  int refused = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(static_cast<std::uint8_t>(damaged[i]) ^ 0x04U);
    try {
      EXPECT_EQ(read_backup(damaged).files, kBackup.files) << i;
    } catch (const SettingsError& error) {
      EXPECT_THAT(error.what(), Not(HasSubstr("\n"))) << i;
      ++refused;
    }
  }
  EXPECT_GT(refused, static_cast<int>(bytes.size() / 2));
}

TEST(BackupFile, SaysWhichFileIsDamaged) {
  const std::string good = manifest("{}");
  const std::string sum = sha256_of(good);
  const auto with_sums = [&](const std::string& sums) {
    return refusal(tar_gz({{"manifest.json", good}, {"settings.json", "{}"}, {"SHA256SUMS", sums}}, 0));
  };
  EXPECT_THAT(with_sums(sum + "  manifest.json\n" + sum + "  settings.json\n"),
              StartsWith("settings.json: its SHA-256 differs from the one in SHA256SUMS"));
  EXPECT_THAT(with_sums(sum + "  manifest.json\n"), StartsWith("settings.json: has no line in SHA256SUMS"));
  EXPECT_THAT(with_sums(sum + "  manifest.json\n" + sum + "  gone.json\n"), AllOf(HasSubstr("gone.json")));
  EXPECT_THAT(with_sums(sum + "  manifest.json\n" + sum + "  manifest.json\n"), HasSubstr("manifest.json"));
  EXPECT_THAT(with_sums("nonsense"), StartsWith("SHA256SUMS: "));
  EXPECT_THAT(refusal(tar_gz({{"manifest.json", good}}, 0)), StartsWith("SHA256SUMS: is not in the file"));
  EXPECT_THAT(refusal(forged({{"settings.json", "{}"}})), StartsWith("manifest.json: is not in the file"));
  EXPECT_THAT(refusal(forged({{"manifest.json", good}, {"a", ""}, {"a", ""}})),
              StartsWith("a: is in the backup twice"));
  EXPECT_EQ(refusal(""), "the file is empty; expected a backup");
}

TEST(BackupFile, TheManifestSaysWhatIsAllowed) {
  const auto of = [](const std::string& changes) {
    return refusal(forged({{"manifest.json", manifest(changes)}}));
  };
  EXPECT_EQ(of("{}"), "none");
  EXPECT_EQ(of(R"({"format": "other"})"),
            R"(manifest.json: /format: is not the format of a backup; expected "ssl-visiond backup")");
  EXPECT_EQ(of(R"({"format_version": 7, "version": "9.0"})"),
            "manifest.json: /format_version: 7 is newer than this program, which reads backups up to 1; "
            "install the "
            "program that made it, \"9.0\"");
  EXPECT_THAT(of(R"({"format_version": 0})"),
              StartsWith("manifest.json: /format_version: 0 is not allowed; expected"));
  EXPECT_THAT(of(R"({"time": "now"})"), StartsWith("manifest.json: /time: "));
  EXPECT_THAT(of(R"({"computer": "a\u0000b"})"), StartsWith("manifest.json: /computer: "));
  EXPECT_THAT(of(R"({"more": 1})"), StartsWith("manifest.json: /more: "));
  EXPECT_THAT(refusal(forged({{"manifest.json", "[]"}})), StartsWith("manifest.json: /format: "));
  EXPECT_THAT(refusal(forged({{"manifest.json", "{"}})), StartsWith("manifest.json: "));
}

TEST(BackupFile, AFewBytesTakeLittleMemory) {
  // The unpacked size is limited for all files together; tests/unit/web/tar_file_test.cpp tests ways around
  // that limit.
  std::vector<TarEntry> many{{"manifest.json", manifest("{}")}};
  for (int i = 0; i < 10; ++i)
    many.push_back({std::to_string(i), std::string(kMaxUnpackedBackupBytes / 8, ' ')});
  EXPECT_EQ(refusal(forged(many)), "this is not a complete backup: unpacked, it is larger than 16 MiB");
  std::string zeros = "[0";
  while (zeros.size() < 2'000'000) zeros += ",0";
  EXPECT_EQ(refusal(forged({{"manifest.json", zeros + "]"}})),
            "manifest.json: JSON that takes more than 16 MiB of memory");
}

TEST(BackupFile, OneThatWouldBeTooLargeIsNotWritten) {
  Backup large = kBackup;
  large.files["profiles.json"] = std::string(kMaxUnpackedBackupBytes, ' ');
  EXPECT_THROW(write_backup(large), StorageError);
}

}  // namespace
}  // namespace sslv::backup_file_test
