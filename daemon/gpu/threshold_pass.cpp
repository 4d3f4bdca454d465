// SPDX-License-Identifier: Apache-2.0
#include "gpu/threshold_pass.h"

#include <algorithm>
#include <bit>

namespace sslv {
namespace {

// The shaders read the first byte of a word as its lowest.
static_assert(std::endian::native == std::endian::little);

constexpr int kImageUnit = 0, kTableUnit = 1, kLabelUnit = 2;

std::size_t limit(GLenum name) {
  GLint64 value = 0;
  glGetInteger64v(name, &value);
  return static_cast<std::size_t>(std::max<GLint64>(0, value));
}

GLint uniform(GLuint program, const char* name) {
  return glGetUniformLocation(program, name);
}

}  // namespace

// ---- compute

ComputeThreshold::ComputeThreshold() : max_bytes_(limit(GL_MAX_SHADER_STORAGE_BLOCK_SIZE)) {}

bool ComputeThreshold::takes(const GroupedImage& image) const {
  return std::max(image.image_bytes(), image.label_bytes()) <= max_bytes_;
}

bool ComputeThreshold::prepare(PixelFormat format, int bits, std::string& problem) {
  const GlName* program = programs_.get(format, bits, problem, [&](std::string& said) {
    return compute_program(threshold_compute_shader(format, bits), said);
  });
  if (program == nullptr) return false;
  program_ = program->get();
  return true;
}

void ComputeThreshold::load(std::span<const Label> table) {
  table_.bind(table.size());
  glBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, static_cast<GLsizeiptr>(table.size()), table.data());
}

std::uint8_t* ComputeThreshold::image_memory(const GroupedImage& image) {
  return static_cast<std::uint8_t*>(image_.map_to_write(image.image_bytes()));
}

bool ComputeThreshold::upload(const GroupedImage&) {
  return image_.unmap();
}

void ComputeThreshold::run(const GroupedImage& image) {
  labels_.bind(image.label_bytes());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kImageBuffer, image_.name());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kTableBuffer, table_.name());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kLabelBuffer, labels_.name());
  const auto groups = static_cast<GLuint>(image.groups_a_row) * static_cast<GLuint>(image.rows);
  glUseProgram(program_);
  glUniform1ui(uniform(program_, "group_count"), groups);
  // GL ignores this call for programs without the uniform.
  glUniform1ui(uniform(program_, "groups_a_row"), static_cast<GLuint>(image.groups_a_row));
  // GL guarantees only 65,535 work groups per dimension.
  constexpr GLuint kAtMost = 32'768;
  const GLuint work_groups = (groups + kWorkGroup - 1) / kWorkGroup;
  const GLuint columns = std::min(work_groups, kAtMost);
  glDispatchCompute(columns, (work_groups + columns - 1) / columns, 1);
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
}

const std::uint8_t* ComputeThreshold::labels(const GroupedImage& image) {
  return static_cast<const std::uint8_t*>(labels_.map_to_read(image.label_bytes()));
}

bool ComputeThreshold::release_labels() {
  return labels_.unmap();
}

// ---- fragments

FragmentThreshold::FragmentThreshold() : most_texels_(limit(GL_MAX_TEXTURE_SIZE)) {
  GLuint name = 0;
  glGenFramebuffers(1, &name);
  frame_ = GlName(name, [](GLuint old) { glDeleteFramebuffers(1, &old); });
}

bool FragmentThreshold::takes(const GroupedImage& image) const {
  const auto texels = static_cast<std::size_t>(
      std::max(image.groups_a_row * texels_a_group(image.format), image.image_rows()));
  return texels <= most_texels_;
}

bool FragmentThreshold::prepare(PixelFormat format, int bits, std::string& problem) {
  const GlName* program = programs_.get(format, bits, problem, [&](std::string& said) {
    return fragment_program(threshold_vertex_shader(), threshold_fragment_shader(format, bits), said);
  });
  if (program == nullptr) return false;
  program_ = program->get();
  return true;
}

void FragmentThreshold::load(std::span<const Label> table) {
  constexpr std::size_t kRowBytes = sizeof(std::uint32_t) * kTableTextureWidth;
  table_rows_ = static_cast<int>(table.size() / kRowBytes);
  table_.bind(kTableUnit, GL_R32UI, kTableTextureWidth, table_rows_);
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, kTableTextureWidth, table_rows_, GL_RED_INTEGER, GL_UNSIGNED_INT,
                  table.data());
}

std::uint8_t* FragmentThreshold::image_memory(const GroupedImage& image) {
  return static_cast<std::uint8_t*>(unpack_.map_to_write(image.image_bytes()));
}

bool FragmentThreshold::upload(const GroupedImage& image) {
  if (!unpack_.unmap()) return false;
  const int width = image.groups_a_row * texels_a_group(image.format);
  image_.bind(kImageUnit, GL_RGBA32UI, width, image.image_rows());
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, width, image.image_rows(), GL_RGBA_INTEGER, GL_UNSIGNED_INT,
                  nullptr);
  return true;
}

void FragmentThreshold::run(const GroupedImage& image) {
  // The only integer format that every GPU can both render to and read back unchanged.
  labels_.bind(kLabelUnit, GL_RGBA32UI, image.groups_a_row, image.rows);
  glBindFramebuffer(GL_FRAMEBUFFER, frame_.get());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, labels_.name(), 0);
  glViewport(0, 0, image.groups_a_row, image.rows);
  table_.bind(kTableUnit, GL_R32UI, kTableTextureWidth, table_rows_);
  glUseProgram(program_);
  glUniform1i(uniform(program_, "image"), kImageUnit);
  glUniform1i(uniform(program_, "table"), kTableUnit);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

const std::uint8_t* FragmentThreshold::labels(const GroupedImage& image) {
  pack_.bind(image.label_bytes());
  glReadPixels(0, 0, image.groups_a_row, image.rows, GL_RGBA_INTEGER, GL_UNSIGNED_INT, nullptr);
  return static_cast<const std::uint8_t*>(pack_.map_to_read(image.label_bytes()));
}

bool FragmentThreshold::release_labels() {
  return pack_.unmap();
}

}  // namespace sslv
