// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

namespace sslv {

// How cameras send pictures that the pipeline does not read, made into those that it does. `pixels` is
// the whole picture's number of pixels; rows follow each other without a gap, on both sides.

/// U Y Y V Y Y for four pixels -> U Y V Y for two; `pixels` divisible by 4. Both pairs get the colour of the
/// four.
void yuv411_to_uyvy(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to) noexcept;

/// U Y V for each pixel -> U Y V Y for two, with their mean colour; `pixels` even.
void yuv444_to_uyvy(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to) noexcept;

/// 16 bits a pixel, the high byte first, of which the lower `depth_bits` (8..16) are used -> the upper 8 of
/// those. What exceeds the depth is white.
void big_endian_to_8_bit(const std::uint8_t* from, std::size_t pixels, int depth_bits,
                         std::uint8_t* to) noexcept;

/// The same with the low byte first, as GenICam's unpacked formats are.
void little_endian_to_8_bit(const std::uint8_t* from, std::size_t pixels, int depth_bits,
                            std::uint8_t* to) noexcept;

// Of packed pixels, the upper 8 bits. Source: GenICam Pixel Format Naming Convention 2.4, packing "p" and the
// older "Packed" of GigE Vision; pixels that do not fill their last group are read from a whole one.

/// "10p": four pixels in five bytes, the lowest bits first.
void packed_10p_to_8_bit(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to) noexcept;
/// "12p": two pixels in three bytes, the lowest bits first.
void packed_12p_to_8_bit(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to) noexcept;
/// "10Packed" and "12Packed": two pixels in three bytes, the middle one with the lower bits of both.
void gige_packed_to_8_bit(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to) noexcept;

}  // namespace sslv
