// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

namespace sslv {

// Conversions from the cameras' pixel formats to the pipeline's formats. `pixels` is the number of pixels in
// the whole image; rows have no padding, in the input and the output.

/// U Y Y V Y Y for four pixels -> U Y V Y for two; `pixels` divisible by 4. Both pairs get the colour of the
/// four pixels.
void yuv411_to_uyvy(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to) noexcept;

/// U Y V for each pixel -> U Y V Y for two, with their mean colour; `pixels` even.
void yuv444_to_uyvy(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to) noexcept;

/// A row of NV12, which has Y in one plane and U V for each 2x2 pixels in another -> U Y V Y for two;
/// `pixels` even. Two rows of Y share a row of colours.
void nv12_row_to_uyvy(const std::uint8_t* luma, const std::uint8_t* colors, std::size_t pixels,
                      std::uint8_t* to) noexcept;

// Pixels deeper than 8 bits are split. `to` gets the upper 8 bits, the same values that cameras send in their
// 8-bit formats; `low` gets the bits below, left-aligned in a byte (ImageView::to_low_bits). So black is 0,
// white is 255, and nothing is rounded. Values above the depth's maximum become white.

/// Big-endian pixels of 16 bits; only the lower `depth_bits` (8..16) are used.
void split_big_endian(const std::uint8_t* from, std::size_t pixels, int depth_bits, std::uint8_t* to,
                      std::uint8_t* low) noexcept;

/// The same for little-endian pixels, as in GenICam's unpacked formats.
void split_little_endian(const std::uint8_t* from, std::size_t pixels, int depth_bits, std::uint8_t* to,
                         std::uint8_t* low) noexcept;

// Source: GenICam Pixel Format Naming Convention 2.4, packing "p" and the older "Packed" of GigE Vision. The
// functions read no byte after the last pixel.

/// "10p": four pixels in five bytes, lowest bits first.
void split_packed_10p(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to,
                      std::uint8_t* low) noexcept;
/// "12p": two pixels in three bytes, lowest bits first.
void split_packed_12p(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to,
                      std::uint8_t* low) noexcept;
/// "10Packed" and "12Packed": two pixels in three bytes; the middle byte has the low bits of both.
void split_gige_packed_10(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to,
                          std::uint8_t* low) noexcept;
void split_gige_packed_12(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to,
                          std::uint8_t* low) noexcept;

}  // namespace sslv
