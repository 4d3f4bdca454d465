// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "gpu/gl_objects.h"
#include "gpu/threshold_shaders.h"
#include "image/image.h"
#include "vision/lut.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace sslv {

/// Layout of an image and its labels in the GPU's memory: row after row, each padded to whole groups.
struct GroupedImage {
  PixelFormat format;
  int groups_a_row, rows;  // label groups per row; label rows

  int image_rows() const { return rows * rows_a_cell(format); }
  std::size_t image_row_bytes() const {
    return static_cast<std::size_t>(groups_a_row * texels_a_group(format) * kTexelBytes);
  }
  std::size_t image_bytes() const { return image_row_bytes() * static_cast<std::size_t>(image_rows()); }
  std::size_t label_row_bytes() const { return static_cast<std::size_t>(groups_a_row * kCellsAGroup); }
  std::size_t label_bytes() const { return label_row_bytes() * static_cast<std::size_t>(rows); }
};

/// One program per format and number of bits, built when first needed.
class ThresholdPrograms {
 public:
  /// Calls `make` with `problem` to build a missing program. Null, with `problem` set, if that fails.
  template <class Make>
  const GlName* get(PixelFormat format, int bits, std::string& problem, const Make& make) {
    GlName& program = programs_[static_cast<std::size_t>(format)][bits == LutTable::kBits ? 0 : 1];
    if (!program) program = make(problem);
    return program ? &program : nullptr;
  }

 private:
  struct Program : GlName {
    Program() : GlName([](GLuint name) { glDeleteProgram(name); }) {}
    using GlName::operator=;
  };
  std::array<std::array<Program, 2>, static_cast<std::size_t>(PixelFormat::kBayerBg8) + 1> programs_;
};

/// A compute shader over buffers. Every function needs a current context; GpuContext::take_problem() reports
/// GL errors.
class ThresholdPass {
 public:
  ThresholdPass();
  /// Whether this GPU supports an image of this size.
  bool takes(const GroupedImage& image) const;
  bool prepare(PixelFormat format, int bits, std::string& problem);
  void load(std::span<const Label> table);
  /// Memory to write the image's bytes into, or null. Finish with upload().
  std::uint8_t* image_memory(const GroupedImage& image);
  bool upload(const GroupedImage& image);
  /// Runs the program of the last prepare().
  void run(const GroupedImage& image);
  /// The labels, or null. Finish with release_labels().
  const std::uint8_t* labels(const GroupedImage& image);
  bool release_labels();

 private:
  ThresholdPrograms programs_;
  std::size_t max_bytes_;
  GLuint program_ = 0;
  GlBuffer image_{GL_SHADER_STORAGE_BUFFER, GL_STREAM_DRAW};
  GlBuffer table_{GL_SHADER_STORAGE_BUFFER, GL_STATIC_DRAW};
  GlBuffer labels_{GL_SHADER_STORAGE_BUFFER, GL_STREAM_READ};
};

}  // namespace sslv
