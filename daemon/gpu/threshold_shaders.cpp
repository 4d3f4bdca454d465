// SPDX-License-Identifier: Apache-2.0
#include "gpu/threshold_shaders.h"

#include <string_view>

#include <fmt/format.h>

namespace sslv {
namespace {

/// `a`, `b` and `c` as in LutTable.
constexpr std::string_view kLookUp = R"(
uint look(uint a, uint b, uint c) {
  uint cell = ((a >> SHIFT) << (2u * BITS)) | ((b >> SHIFT) << BITS) | (c >> SHIFT);
  return (table_word(cell >> 2) >> ((cell & 3u) << 3)) & 255u;
}
)";

constexpr std::string_view kYuv422 = R"(
uint pair(uint w) {
  uint u = (w >> U_AT) & 255u, v = (w >> (U_AT + 16u)) & 255u;
  return look(u, v, (w >> Y_AT) & 255u) | (look(u, v, (w >> (Y_AT + 16u)) & 255u) << 8);
}
uvec2 eight(uvec4 t) {
  return uvec2(pair(t.x) | (pair(t.y) << 16), pair(t.z) | (pair(t.w) << 16));
}
uvec4 group_labels() {
  return uvec4(eight(texel(0)), eight(texel(1)));
}
)";

constexpr std::string_view kRgb = R"(
uint pixel(uint first, uint green, uint last) {
  return look((RED) & 255u, (BLUE) & 255u, green & 255u);
}
uint four(uint w0, uint w1, uint w2) {
  return pixel(w0, w0 >> 8, w0 >> 16) | (pixel(w0 >> 24, w1, w1 >> 8) << 8) |
         (pixel(w1 >> 16, w1 >> 24, w2) << 16) | (pixel(w2 >> 8, w2 >> 16, w2 >> 24) << 24);
}
uvec4 group_labels() {
  uvec4 a = texel(0), b = texel(1), c = texel(2);
  return uvec4(four(a.x, a.y, a.z), four(a.w, b.x, b.y), four(b.z, b.w, c.x), four(c.y, c.z, c.w));
}
)";

constexpr std::string_view kMono = R"(
uint four(uint w) {
  return look(128u, 128u, w & 255u) | (look(128u, 128u, (w >> 8) & 255u) << 8) |
         (look(128u, 128u, (w >> 16) & 255u) << 16) | (look(128u, 128u, w >> 24) << 24);
}
uvec4 group_labels() {
  uvec4 t = texel(0);
  return uvec4(four(t.x), four(t.y), four(t.z), four(t.w));
}
)";

constexpr std::string_view kBayer = R"(
uint quad(uint upper, uint lower) {
  uint q0 = upper & 255u, q1 = (upper >> 8) & 255u, q2 = lower & 255u, q3 = (lower >> 8) & 255u;
  return look(RED, BLUE, (GREEN_1 + GREEN_2 + 1u) >> 1);
}
uint pair(uint upper, uint lower) {
  return quad(upper, lower) | (quad(upper >> 16, lower >> 16) << 8);
}
uvec2 eight(uvec4 u, uvec4 l) {
  return uvec2(pair(u.x, l.x) | (pair(u.y, l.y) << 16), pair(u.z, l.z) | (pair(u.w, l.w) << 16));
}
uvec4 group_labels() {
  return uvec4(eight(texel(0), lower_texel(0)), eight(texel(1), lower_texel(1)));
}
)";

/// The GLSL that computes a group's labels from its texels.
std::string group_labels(PixelFormat format) {
  const auto bayer = [](int red) {
    const int green_1 = red == 0 || red == 3 ? 1 : 0;
    return fmt::format("#define RED q{}\n#define BLUE q{}\n#define GREEN_1 q{}\n#define GREEN_2 q{}\n{}", red,
                       3 - red, green_1, 3 - green_1, kBayer);
  };
  switch (format) {
    case PixelFormat::kUyvy: return fmt::format("#define U_AT 0u\n#define Y_AT 8u\n{}", kYuv422);
    case PixelFormat::kYuyv: return fmt::format("#define U_AT 8u\n#define Y_AT 0u\n{}", kYuv422);
    case PixelFormat::kRgb24: return fmt::format("#define RED first\n#define BLUE last\n{}", kRgb);
    case PixelFormat::kBgr24: return fmt::format("#define RED last\n#define BLUE first\n{}", kRgb);
    case PixelFormat::kMono8: return std::string(kMono);
    case PixelFormat::kBayerRg8: return bayer(0);
    case PixelFormat::kBayerGr8: return bayer(1);
    case PixelFormat::kBayerGb8: return bayer(2);
    case PixelFormat::kBayerBg8: return bayer(3);
  }
  return {};
}

std::string constants(PixelFormat format, int bits) {
  return fmt::format("#define BITS {}u\n#define SHIFT {}u\n#define TEXELS {}\n#define ROWS {}\n", bits,
                     8 - bits, texels_a_group(format), rows_a_cell(format));
}

}  // namespace

std::string threshold_shader(PixelFormat format, int bits) {
  return fmt::format("#version 310 es\nprecision highp int;\n{}#define WORK_GROUP {}\n",
                     constants(format, bits), kWorkGroup) +
         fmt::format("#define IMAGE {}\n#define TABLE {}\n#define LABELS {}\n", kImageBuffer, kTableBuffer,
                     kLabelBuffer) +
         R"(
layout(local_size_x = WORK_GROUP) in;
layout(std430, binding = IMAGE) readonly buffer Image { uvec4 image[]; };
layout(std430, binding = TABLE) readonly buffer Table { uint table[]; };
layout(std430, binding = LABELS) writeonly buffer Labels { uvec4 labels[]; };
uniform uint group_count, groups_a_row;
uint here;  // first texel of the group
uvec4 texel(int i) { return image[here + uint(i)]; }
uvec4 lower_texel(int i) { return image[here + uint(TEXELS) * groups_a_row + uint(i)]; }
uint table_word(uint i) { return table[i]; }
)" + std::string(kLookUp) +
         group_labels(format) + R"(
void main() {
  uint group = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * uint(WORK_GROUP) +
               gl_LocalInvocationID.x;
  if (group >= group_count) return;
#if ROWS == 2
  here = uint(TEXELS) * (group + (group / groups_a_row) * groups_a_row);
#else
  here = uint(TEXELS) * group;
#endif
  labels[group] = group_labels();
}
)";
}

}  // namespace sslv
