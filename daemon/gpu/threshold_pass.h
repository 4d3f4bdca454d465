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

/// An image and its labels as they lie in the GPU's memory: row after row, each of whole groups.
struct GroupedImage {
  PixelFormat format;
  int groups_a_row, rows;  // of labels

  int image_rows() const { return rows * rows_a_cell(format); }
  std::size_t image_row_bytes() const {
    return static_cast<std::size_t>(groups_a_row * texels_a_group(format) * kTexelBytes);
  }
  std::size_t image_bytes() const { return image_row_bytes() * static_cast<std::size_t>(image_rows()); }
  std::size_t label_row_bytes() const { return static_cast<std::size_t>(groups_a_row * kCellsAGroup); }
  std::size_t label_bytes() const { return label_row_bytes() * static_cast<std::size_t>(rows); }
};

/// A program for each format and number of bits, made when it is first needed.
class ThresholdPrograms {
 public:
  /// Null, and a problem, when it cannot be made. `make` is called with the problem.
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

// Both have the same functions. All need a current context; what went wrong in GL, GpuContext::take_problem()
// says.

/// By a compute shader over buffers (OpenGL ES 3.1).
class ComputeThreshold {
 public:
  ComputeThreshold();
  /// Whether this GPU takes so large an image.
  bool takes(const GroupedImage& image) const;
  bool prepare(PixelFormat format, int bits, std::string& problem);
  void load(std::span<const Label> table);
  /// The image's bytes, to be written; or null. End it with upload().
  std::uint8_t* image_memory(const GroupedImage& image);
  bool upload(const GroupedImage& image);
  /// With the program of the last prepare().
  void run(const GroupedImage& image);
  /// The labels; or null. End it with release_labels().
  const std::uint8_t* labels(const GroupedImage& image);
  bool release_labels();

 private:
  ThresholdPrograms programs_;
  std::size_t most_bytes_;
  GLuint program_ = 0;
  GlBuffer image_{GL_SHADER_STORAGE_BUFFER, GL_STREAM_DRAW};
  GlBuffer table_{GL_SHADER_STORAGE_BUFFER, GL_STATIC_DRAW};
  GlBuffer labels_{GL_SHADER_STORAGE_BUFFER, GL_STREAM_READ};
};

/// By a fragment shader over textures (OpenGL ES 3.0).
class FragmentThreshold {
 public:
  FragmentThreshold();
  bool takes(const GroupedImage& image) const;
  bool prepare(PixelFormat format, int bits, std::string& problem);
  void load(std::span<const Label> table);
  std::uint8_t* image_memory(const GroupedImage& image);
  bool upload(const GroupedImage& image);
  void run(const GroupedImage& image);
  const std::uint8_t* labels(const GroupedImage& image);
  bool release_labels();

 private:
  ThresholdPrograms programs_;
  std::size_t most_texels_;  // a side
  GLuint program_ = 0;
  GlName frame_{[](GLuint name) { glDeleteFramebuffers(1, &name); }};
  GlTexture image_, table_, labels_;
  int table_rows_ = 0;
  GlBuffer unpack_{GL_PIXEL_UNPACK_BUFFER, GL_STREAM_DRAW};
  GlBuffer pack_{GL_PIXEL_PACK_BUFFER, GL_STREAM_READ};
};

}  // namespace sslv
