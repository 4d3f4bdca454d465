// SPDX-License-Identifier: Apache-2.0
#include "settings/named_files.h"

#include "base/error.h"
#include "support/temporary_folder.h"

#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sslv::named_files_test {
namespace {

namespace fs = std::filesystem;

const Json kSchema = Json::parse(R"({
  "properties": {
    "name": {"type": "string"},
    "patterns": {"type": "string", "format": "file"},
    "cameras": {"items": {"properties": {
      "lut": {"type": "string", "format": "file"},
      "source": {"oneOf": [
        {"properties": {"backend": {"const": "files"}, "path": {"type": "string", "format": "file"}}},
        {"properties": {"backend": {"const": "gige"}, "path": {"type": "string"}}}
      ]}
    }}}
  }
})");

TEST(NamedFiles, AreThoseThatTheSchemaSays) {
  const Json settings = Json::parse(R"({"name": "/a", "patterns": "/b", "cameras": [
    {"lut": "", "source": {"backend": "gige", "path": "/c"}},
    {"lut": "d", "source": {"backend": "files", "path": "/e"}}, 7], "more": "/f"})");
  std::vector<std::string> found;
  for (const NamedFile& one : named_files(kSchema, settings))
    found.push_back(one.path + " " + one.file.string());
  EXPECT_THAT(found, testing::ElementsAre("/patterns /b", "/cameras/1/lut d", "/cameras/1/source/path /e"));
}

class CheckNamedFiles : public testing::Test {
 protected:
  std::string refusal(const std::string& file, const std::vector<Json>& known = {}) const {
    try {
      check_named_files(kSchema, {{"patterns", file}}, known,
                        {folder_.path() / "mine", folder_.path() / "shared"});
    } catch (const SettingsError& error) {
      return error.what();
    }
    return "";
  }
  std::string in(const std::string& name) const { return (folder_.path() / name).string(); }

  const test::TemporaryFolder folder_;
};

TEST_F(CheckNamedFiles, AllowsThoseInItsFolders) {
  fs::create_directories(folder_.path() / "mine/deep");
  for (const char* name :
       {"mine/a.json", "mine/deep/a.json", "mine/not/there", "mine", "shared/x", "mine/deep/../b"})
    EXPECT_EQ(refusal(in(name)), "") << name;
}

TEST_F(CheckNamedFiles, RefusesAllOthers) {
  fs::create_directories(folder_.path() / "mine");
  fs::create_directories(folder_.path() / "mine.not");
  fs::create_symlink("/etc", folder_.path() / "mine/link");
  for (const std::string& name :
       {std::string("/etc/passwd"), in("mine/../secret"), in("mine.not/a"), in("mine/link/passwd"), in(""),
        std::string("etc/passwd"), std::string("../../etc/passwd"), std::string("/")}) {
    EXPECT_THAT(refusal(name), testing::StartsWith("/patterns: \"" + name + "\" is not allowed")) << name;
  }
}

TEST_F(CheckNamedFiles, AllowsFilesThatAreAlreadyNamed) {
  EXPECT_EQ(refusal("/etc/patterns.json", {{{"patterns", "/etc/patterns.json"}}}), "");
  EXPECT_NE(refusal("/etc/passwd", {{{"patterns", "/etc/patterns.json"}, {"name", "/etc/passwd"}}}), "");
}

}  // namespace
}  // namespace sslv::named_files_test
