// SPDX-License-Identifier: Apache-2.0
#include "capture/files/jpeg_file.h"

#include "image/jpeg.h"
#include "support/temporary_folder.h"

#include <fstream>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::jpeg_file_test {
namespace {

using test::TemporaryFolder;
using ::testing::HasSubstr;

class JpegFile : public testing::Test {
 protected:
  std::string file(const std::string& bytes) const {
    const std::string name = (folder_.path() / "picture.jpg").string();
    std::ofstream(name, std::ios::binary) << bytes;
    return name;
  }
  std::string refusal_of(const std::string& path) {
    try {
      read_jpeg_file(path, pool_);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "no error";
  }
  static std::string jpeg_of(int width, int height) {
    const std::vector<std::uint8_t> gray(static_cast<std::size_t>(width * height), 90);
    JpegEncoder encoder;
    const auto jpeg = encoder.encode(ImageView{gray.data(), width, height, width, PixelFormat::kMono8}, width,
                                     90, Chroma::kFull);
    return {jpeg.begin(), jpeg.end()};
  }

  TemporaryFolder folder_;
  PicturePool pool_;
};

TEST_F(JpegFile, IsRead) {
  const Image image = read_jpeg_file(file(jpeg_of(40, 30)), pool_);
  EXPECT_EQ(image.view().width, 40);
  EXPECT_EQ(image.view().height, 30);
  EXPECT_NEAR(image.view().row(15)[0], 90, 4);
}

TEST_F(JpegFile, RefusesOtherFiles) {
  EXPECT_NE(refusal_of(file("")), "no error");
  EXPECT_NE(refusal_of(file("P6\n8 8\n255\n")), "no error");
  EXPECT_NE(refusal_of(file(jpeg_of(40, 30).substr(0, 300))), "no error");
  EXPECT_THAT(refusal_of((folder_.path() / "none.jpg").string()), HasSubstr("No such file"));
  EXPECT_NE(refusal_of(folder_.path().string()), "no error") << "a folder";
}

}  // namespace
}  // namespace sslv::jpeg_file_test
