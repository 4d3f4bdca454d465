// SPDX-License-Identifier: Apache-2.0
#include "kit/load_stages.h"

#include "kit/read_stamp.h"
#include "support/patience.h"
#include "support/temporary_folder.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

namespace sslv::load_stages_test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using testing::StartsWith;

std::filesystem::path library(const std::string& name) {
  return std::filesystem::path(SSLV_KIT_LIBRARIES) / name / (name + ".so");
}

LoadedStages load(const std::vector<std::filesystem::path>& folders) {
  return load_stages(folders, test::kPatience);
}

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A folder to which tests add libraries.
class LibraryFolder : public testing::Test {
 protected:
  void put(const std::string& name, const std::string& bytes) {
    std::ofstream(folder_.path() / name, std::ios::binary) << bytes;
  }
  /// Why the folder's only library is skipped; loading itself must not fail.
  std::string why() {
    const LoadedStages loaded = load({folder_.path()});
    EXPECT_THAT(loaded.libraries, IsEmpty());
    return loaded.left_out.size() == 1 ? loaded.left_out.front().why
                                       : std::to_string(loaded.left_out.size()) + " left out";
  }
  /// The same for a library that was built for these tests.
  static std::string why_not(const std::string& name) {
    const LoadedStages loaded = load({library(name).parent_path()});
    EXPECT_THAT(loaded.libraries, IsEmpty());
    EXPECT_THAT(loaded.left_out, SizeIs(1));
    return loaded.left_out.empty() ? "" : loaded.left_out.front().why;
  }
  /// The correct library with `changed` written at `offset` in its stamp.
  std::string with_stamp(std::size_t offset, const std::string& changed) {
    std::string bytes = bytes_of(library("counting"));
    const std::size_t at = bytes.find(std::string(kStampMagic) + '\0');
    EXPECT_NE(at, std::string::npos);
    return bytes.replace(at + offset, changed.size(), changed);
  }

  test::TemporaryFolder folder_;
};

TEST_F(LibraryFolder, LoadsValidLibraries) {
  put("counting.so", bytes_of(library("counting")));
  put("README.txt", "no library");
  const LoadedStages loaded = load({folder_.path()});
  EXPECT_THAT(loaded.left_out, IsEmpty());
  ASSERT_THAT(loaded.libraries, SizeIs(1));
  const StageRows& rows = loaded.libraries[0].rows;
  ASSERT_THAT(rows.camera, SizeIs(2));
  ASSERT_THAT(rows.field, SizeIs(1));
  EXPECT_EQ(rows.camera[0].name, "count_balls");
  EXPECT_EQ(rows.camera[0].library, "counting.so");
  EXPECT_EQ(rows.camera[0].schema().at("properties").at("at_least").at("maximum"), 100);
  EXPECT_THROW(rows.camera[0].parse(Json{{"at_least", 101}}, "/stages/count_balls"), SettingsError)
      << "what a library throws is caught here";
}

TEST_F(LibraryFolder, IsEmptyIfTheFolderIsMissing) {
  const LoadedStages loaded = load({folder_.path() / "nowhere", "/dev/null"});
  EXPECT_THAT(loaded.libraries, IsEmpty());
  EXPECT_THAT(loaded.left_out, IsEmpty());
}

TEST_F(LibraryFolder, ReportsFilesThatAreNotLibraries) {
  put("text.so", "some words");
  EXPECT_EQ(why(), "is not a shared object");
  put("text.so", "");
  EXPECT_EQ(why(), "is truncated or not a shared object");
  put("text.so", bytes_of(library("counting")).substr(0, 1000));
  EXPECT_EQ(why(), "is truncated or not a shared object");
  std::filesystem::remove(folder_.path() / "text.so");
  std::filesystem::create_directory(folder_.path() / "folder.so");
  EXPECT_EQ(why(), "is not a regular file");
}

TEST_F(LibraryFolder, DoesNotBlockOnAPipe) {
  ASSERT_EQ(::mkfifo((folder_.path() / "pipe.so").c_str(), 0600), 0);
  EXPECT_EQ(why(), "is not a regular file");
}

TEST_F(LibraryFolder, TakesEachLibraryOnce) {
  put("counting.so", bytes_of(library("counting")));
  std::filesystem::create_symlink("counting.so", folder_.path() / "link.so");
  std::filesystem::create_directory_symlink(folder_.path(), folder_.path() / "again");
  const LoadedStages loaded = load({folder_.path(), folder_.path() / ".", folder_.path() / "again"});
  EXPECT_THAT(loaded.left_out, IsEmpty());
  EXPECT_THAT(loaded.libraries, SizeIs(1));
}

TEST_F(LibraryFolder, SaysWhichFolderCannotBeRead) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may read all";
  const auto locked = folder_.path() / "locked";
  std::filesystem::create_directory(locked);
  std::filesystem::permissions(locked, std::filesystem::perms::none);
  const LoadedStages loaded = load({locked});
  std::filesystem::permissions(locked, std::filesystem::perms::owner_all);
  ASSERT_THAT(loaded.left_out, SizeIs(1));
  EXPECT_EQ(loaded.left_out[0].why, "cannot be read: Permission denied");
}

TEST_F(LibraryFolder, KeepsTheDeadlineOfAFormerlySandboxedStage) {
  const LoadedStages loaded = load({library("counting").parent_path()});
  ASSERT_THAT(loaded.libraries, SizeIs(1));
  const StageType& counts = loaded.libraries[0].rows.camera[0];
  const Json both{{"at_least", 3}, {"deadline_ms", 20.5}};
  EXPECT_EQ(counts.parse(both, "").complete, both);
  EXPECT_EQ(counts.parse({{"at_least", 3}}, "").complete, Json({{"at_least", 3}}));
  EXPECT_THROW(counts.parse({{"deadline_ms", "soon"}}, ""), SettingsError);
}

TEST_F(LibraryFolder, RefusesStagesWithInvalidParameters) {
  const auto why_of = [](const char* row) {
    ::setenv("SSLV_TEST_ROW", row, 1);
    std::string why = why_not("bad_params");
    ::unsetenv("SSLV_TEST_ROW");
    return why;
  };
  EXPECT_EQ(why_of("nan_default"),
            "cannot make its stage 'nan_default': its parameter 'a' has a default or a range that is not a "
            "finite number");
  EXPECT_EQ(why_of("endless_range"),
            "cannot make its stage 'endless_range': its parameter 'a' has a default or a range that is "
            "not a finite number");
  EXPECT_EQ(
      why_of("default_out_of_range"),
      "cannot make its stage 'default_out_of_range': its parameters: /default_out_of_range/a: 2.0 is not "
      "allowed; expected a number 0.0 .. 1.0");
  EXPECT_EQ(why_of("twice"), "cannot make its stage 'twice': two of its parameters are called 'a'");
  EXPECT_EQ(why_of("long_help"), "cannot make its stage 'long_help': its help has more than 500 bytes");
  EXPECT_THAT(why_of("bad_part"),
              StartsWith("cannot make its stage 'bad_part': its part 'Bad\\u000aName' has an invalid name"));
}

TEST_F(LibraryFolder, DoesNotWaitForALibrarysChildProcesses) {
  const LoadedStages loaded = load({library("leaves_child").parent_path()});
  EXPECT_THAT(loaded.left_out, IsEmpty());
  EXPECT_THAT(loaded.libraries, SizeIs(1));
}

TEST_F(LibraryFolder, SaysWhichProcessorAFileIsFor) {
  std::string bytes = bytes_of(library("counting"));
  bytes[18] = static_cast<char>(bytes[18] == '\xb7' ? 62 : 183);  // e_machine: x86-64 or aarch64
  put("other.so", bytes);
  EXPECT_THAT(why(), testing::MatchesRegex("is made for (aarch64|x86-64); this program runs on .*"));
  bytes[4] = 1;  // 32 bits
  put("other.so", bytes);
  EXPECT_THAT(why(), StartsWith("is made for a 32-bit processor"));
}

TEST_F(LibraryFolder, NeedsAStamp) {
  EXPECT_THAT(why_not("no_stamp"), StartsWith("has no stamp of the stage kit: build it with"));
  put("broken.so", with_stamp(0, "SSL"));
  EXPECT_THAT(why(), StartsWith("has no stamp of the stage kit"));
}

TEST_F(LibraryFolder, NeedsTheKitsVersion) {
  put("old.so", with_stamp(offsetof(StageStamp, kit_version), std::string("\x63\0\0\0", 4)));
  EXPECT_THAT(why(),
              StartsWith("is built for version 99 of the stage kit, but this is version 2: rebuild it"));
}

TEST_F(LibraryFolder, NeedsTheSameCompilersAbi) {
  put("old.so", with_stamp(offsetof(StageStamp, compiler), std::string("PDP-11\0", 7)));
  EXPECT_THAT(why(), StartsWith("is built with PDP-11, but this program with "));
}

TEST_F(LibraryFolder, SaysWhenOnlyTheAlignmentDiffers) {
  put("native.so", with_stamp(offsetof(StageStamp, types) + offsetof(StampedType, alignment),
                              std::string("\x40\0\0\0", 4)));
  EXPECT_THAT(why(),
              StartsWith("has a different alignment of FrameInfo (64 bytes) than this program (8 bytes): "
                         "rebuild it without options for one processor"));
}

TEST_F(LibraryFolder, NeedsTheSameLayoutOfEveryType) {
  const StageStamp ours = this_stamp();
  for (std::size_t i = 0; i < ours.type_count; ++i) {
    const std::size_t type = offsetof(StageStamp, types) + i * sizeof(StampedType);
    put("old.so", with_stamp(type + offsetof(StampedType, layout), "otherwis"));
    EXPECT_THAT(why(),
                StartsWith("has a different layout of " + std::string(ours.types[i].name.data()) + " ("));
  }
  // A type that only the library has.
  put("old.so", with_stamp(offsetof(StageStamp, types) + ours.type_count * sizeof(StampedType), "Extra"));
  EXPECT_THAT(why(), StartsWith("has a different layout of Extra (0 bytes)"));
}

TEST_F(LibraryFolder, NamesMissingSymbols) {
  EXPECT_THAT(why_not("missing_symbol"), testing::AllOf(StartsWith("cannot be loaded: undefined symbol: "),
                                                        HasSubstr("nobody_has_this")));
}

TEST_F(LibraryFolder, SurvivesLibrariesThatFailWhileLoading) {
  EXPECT_THAT(why_not("throws_loading"),
              testing::AnyOf(HasSubstr("no licence"), HasSubstr("crashes while it is loaded (Aborted)")));
  EXPECT_EQ(why_not("crashes_loading"), "crashes while it is loaded (Aborted)");
  EXPECT_EQ(why_not("exits_loading"), "ends the process that loads it");
  EXPECT_EQ(why_not("throws_making"), "cannot make its stage 'throws_making': no camera for it");
  EXPECT_EQ(why_not("bad_name"),
            "has a stage with the invalid name 'Bad Name'; expected 1 to 40 characters of a-z, 0-9 and _");
}

TEST_F(LibraryFolder, StopsLibrariesThatHangWhileLoading) {
  // The hanging libraries share one time limit, and a correct library still loads.
  for (const char* name : {"a.so", "b.so", "c.so"}) put(name, bytes_of(library("hangs_loading")));
  put("good.so", bytes_of(library("counting")));
  const LoadedStages loaded = load_stages({folder_.path()}, std::chrono::seconds(30));
  ASSERT_THAT(loaded.left_out, SizeIs(3));
  for (const LeftOutLibrary& one : loaded.left_out) EXPECT_EQ(one.why, "did not load within 30 seconds");
  EXPECT_THAT(loaded.libraries, SizeIs(1));
}

}  // namespace
}  // namespace sslv::load_stages_test
