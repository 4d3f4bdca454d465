// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

namespace sslv {

// How cameras send images that the pipeline does not read, made into those that it does. `pixels` is
// the whole image's number of pixels; rows follow each other without a gap, on both sides.

/// U Y Y V Y Y for four pixels -> U Y V Y for two; `pixels` divisible by 4. Both pairs get the colour of the
/// four.
void yuv411_to_uyvy(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to) noexcept;

/// U Y V for each pixel -> U Y V Y for two, with their mean colour; `pixels` even.
void yuv444_to_uyvy(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to) noexcept;

/// A row of NV12, whose Y lie in one plane and U V for each two by two pixels in another -> U Y V Y for two;
/// `pixels` even. Two rows of Y share a row of colours.
void nv12_row_to_uyvy(const std::uint8_t* luma, const std::uint8_t* colors, std::size_t pixels,
                      std::uint8_t* to) noexcept;

// Deeper pixels than 8 bits are split: the upper 8 bits, which are what cameras send that are set to 8, go to
// `to`; those below to `low`, from the top of the byte down (ImageView::to_low_bits). So black is 0, white is
// 255, and nothing is rounded. What exceeds the depth is white.

/// 16 bits a pixel, the high byte first, of which the lower `depth_bits` (8..16) are used.
void split_big_endian(const std::uint8_t* from, std::size_t pixels, int depth_bits, std::uint8_t* to,
                      std::uint8_t* low) noexcept;

/// The same with the low byte first, as GenICam's unpacked formats are.
void split_little_endian(const std::uint8_t* from, std::size_t pixels, int depth_bits, std::uint8_t* to,
                         std::uint8_t* low) noexcept;

// Source: GenICam Pixel Format Naming Convention 2.4, packing "p" and the older "Packed" of GigE Vision.
// No byte beyond the last pixel's is read.

/// "10p": four pixels in five bytes, the lowest bits first.
void split_packed_10p(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to,
                      std::uint8_t* low) noexcept;
/// "12p": two pixels in three bytes, the lowest bits first.
void split_packed_12p(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to,
                      std::uint8_t* low) noexcept;
/// "10Packed" and "12Packed": two pixels in three bytes, the middle one with the lower bits of both.
void split_gige_packed_10(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to,
                          std::uint8_t* low) noexcept;
void split_gige_packed_12(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to,
                          std::uint8_t* low) noexcept;

}  // namespace sslv
