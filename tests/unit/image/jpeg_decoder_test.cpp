// SPDX-License-Identifier: Apache-2.0
#include "image/jpeg_decoder.h"

#include "image/color.h"

#include <gmock/gmock.h>
#include <turbojpeg.h>

namespace sslv::jpeg_decoder_test {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = 64, kHeight = 48;
constexpr Rgb kLeft{200, 40, 30}, kRight{20, 90, 220};

/// A JPEG image whose left and right halves differ in colour. `subsampling`: of chroma, TJSAMP_*.
std::vector<std::uint8_t> jpeg_of(int subsampling) {
  std::vector<std::uint8_t> pixels;
  for (int i = 0; i < kWidth * kHeight; ++i) {
    const Rgb color = i % kWidth < kWidth / 2 ? kLeft : kRight;
    pixels.insert(pixels.end(), {color.r, color.g, color.b});
  }
  unsigned char* out = nullptr;
  unsigned long size = 0;
  const tjhandle encoder = tjInitCompress();
  EXPECT_EQ(
      tjCompress2(encoder, pixels.data(), kWidth, 0, kHeight, TJPF_RGB, &out, &size, subsampling, 95, 0), 0);
  std::vector<std::uint8_t> jpeg(out, out + size);
  tjFree(out);
  tjDestroy(encoder);
  return jpeg;
}

struct Decoded {
  bool sound = false;
  ImageView view;
  std::vector<std::uint8_t> bytes;
  std::string problem;
};

Decoded decode(std::span<const std::uint8_t> jpeg) {
  JpegDecoder decoder;
  Decoded out;
  out.view = decoder.layout(jpeg, out.problem);
  if (out.view.width == 0) return out;
  out.bytes.resize(static_cast<std::size_t>(out.view.stride_bytes) * out.view.height);
  out.sound = decoder.decode(jpeg, out.bytes.data(), out.problem);
  out.view.data = out.bytes.data();
  return out;
}

Yuv yuv_at(const ImageView& view, int x, int y) {
  const std::uint8_t* pair = view.row(y) + 4 * (x / 2);
  return {pair[1 + 2 * (x % 2)], pair[0], pair[2]};
}

void expect_near(Yuv a, Yuv b) {
  EXPECT_NEAR(a.y, b.y, 4);
  EXPECT_NEAR(a.u, b.u, 4);
  EXPECT_NEAR(a.v, b.v, 4);
}

TEST(JpegDecoder, PicturesOfCamerasComeAsUyvy) {
  for (const int subsampling : {TJSAMP_422, TJSAMP_420}) {
    const Decoded decoded = decode(jpeg_of(subsampling));
    ASSERT_TRUE(decoded.sound) << decoded.problem;
    EXPECT_EQ(decoded.view.format, PixelFormat::kUyvy);
    EXPECT_EQ(decoded.view.width, kWidth);
    EXPECT_EQ(decoded.view.height, kHeight);
    for (const int y : {0, 17, kHeight - 1}) {
      for (const int x : {0, 1, 20}) expect_near(yuv_at(decoded.view, x, y), to_yuv(kLeft));
      for (const int x : {44, kWidth - 2, kWidth - 1})
        expect_near(yuv_at(decoded.view, x, y), to_yuv(kRight));
    }
  }
}

TEST(JpegDecoder, OthersComeAsRgb) {
  const Decoded decoded = decode(jpeg_of(TJSAMP_444));
  ASSERT_TRUE(decoded.sound) << decoded.problem;
  ASSERT_EQ(decoded.view.format, PixelFormat::kRgb24);
  const std::uint8_t* last = decoded.view.row(kHeight - 1) + 3 * (kWidth - 1);
  expect_near(to_yuv({last[0], last[1], last[2]}), to_yuv(kRight));
}

/// Many webcams omit the standard Huffman tables.
TEST(JpegDecoder, TablesMayBeMissing) {
  const std::vector<std::uint8_t> whole = jpeg_of(TJSAMP_422);
  std::vector<std::uint8_t> jpeg(whole.begin(), whole.begin() + 2);
  for (std::size_t at = 2; at + 4 <= whole.size();) {
    const std::size_t bytes = 2 + (whole[at + 2] << 8U | whole[at + 3]);
    constexpr std::uint8_t kHuffmanTable = 0xc4, kScan = 0xda;
    const bool scan = whole[at + 1] == kScan;
    const auto end = scan ? whole.end() : whole.begin() + static_cast<std::ptrdiff_t>(at + bytes);
    if (whole[at + 1] != kHuffmanTable)
      jpeg.insert(jpeg.end(), whole.begin() + static_cast<std::ptrdiff_t>(at), end);
    if (scan) break;
    at += bytes;
  }
  ASSERT_LT(jpeg.size(), whole.size());
  const Decoded decoded = decode(jpeg);
  ASSERT_TRUE(decoded.sound) << decoded.problem;
  EXPECT_EQ(decoded.bytes, decode(whole).bytes);
}

TEST(JpegDecoder, IgnoresExtraBytesBeforeTheEnd) {
  std::vector<std::uint8_t> jpeg = jpeg_of(TJSAMP_422);
  const Decoded plain = decode(jpeg);
  jpeg.insert(jpeg.end() - 2, {0, 0, 0});
  const Decoded decoded = decode(jpeg);
  EXPECT_TRUE(decoded.sound) << decoded.problem;
  EXPECT_EQ(decoded.bytes, plain.bytes);
}

TEST(JpegDecoder, SaysWhatIsWrong) {
  const std::vector<std::uint8_t> jpeg = jpeg_of(TJSAMP_422);
  const Decoded cut = decode(std::span(jpeg).first(jpeg.size() - 20));
  EXPECT_FALSE(cut.sound);
  EXPECT_THAT(cut.problem, HasSubstr("Premature end of JPEG file"));
  const Decoded none = decode(std::span(jpeg).last(10));
  EXPECT_FALSE(none.sound);
  EXPECT_EQ(none.view.width, 0);
  EXPECT_THAT(none.problem, HasSubstr("Not a JPEG file"));
  EXPECT_FALSE(decode({}).sound);
}

TEST(JpegDecoder, ADamagedPictureDoesNotHarmTheNext) {
  const std::vector<std::uint8_t> jpeg = jpeg_of(TJSAMP_422);
  const Decoded sound = decode(jpeg);
  JpegDecoder decoder;
  for (std::size_t bytes = 0; bytes < jpeg.size(); ++bytes) {
    std::string problem;
    std::vector<std::uint8_t> out(sound.bytes.size());
    const auto read = [&](std::span<const std::uint8_t> from) {
      return decoder.layout(from, problem).width > 0 && decoder.decode(from, out.data(), problem);
    };
    EXPECT_FALSE(read(std::span(jpeg).first(bytes))) << bytes;
    EXPECT_NE(problem, "") << bytes;
    ASSERT_TRUE(read(jpeg)) << bytes << ": " << problem;
    ASSERT_EQ(out, sound.bytes) << bytes;
  }
}

}  // namespace
}  // namespace sslv::jpeg_decoder_test
