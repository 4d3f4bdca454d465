// SPDX-License-Identifier: Apache-2.0
#include "gpu/threshold_pass.h"

#include <algorithm>
#include <bit>

namespace sslv {
namespace {

// The shaders read the first byte of a word as its lowest.
static_assert(std::endian::native == std::endian::little);

std::size_t limit(GLenum name) {
  GLint64 value = 0;
  glGetInteger64v(name, &value);
  return static_cast<std::size_t>(std::max<GLint64>(0, value));
}

GLint uniform(GLuint program, const char* name) {
  return glGetUniformLocation(program, name);
}

}  // namespace

ThresholdPass::ThresholdPass() : max_bytes_(limit(GL_MAX_SHADER_STORAGE_BLOCK_SIZE)) {}

bool ThresholdPass::takes(const GroupedImage& image) const {
  return std::max(image.image_bytes(), image.label_bytes()) <= max_bytes_;
}

bool ThresholdPass::prepare(PixelFormat format, int bits, std::string& problem) {
  const GlName* program = programs_.get(format, bits, problem, [&](std::string& said) {
    return compute_program(threshold_shader(format, bits), said);
  });
  if (program == nullptr) return false;
  program_ = program->get();
  return true;
}

void ThresholdPass::load(std::span<const Label> table) {
  table_.bind(table.size());
  glBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, static_cast<GLsizeiptr>(table.size()), table.data());
}

std::uint8_t* ThresholdPass::image_memory(const GroupedImage& image) {
  return static_cast<std::uint8_t*>(image_.map_to_write(image.image_bytes()));
}

bool ThresholdPass::upload(const GroupedImage&) {
  return image_.unmap();
}

void ThresholdPass::run(const GroupedImage& image) {
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

const std::uint8_t* ThresholdPass::labels(const GroupedImage& image) {
  return static_cast<const std::uint8_t*>(labels_.map_to_read(image.label_bytes()));
}

bool ThresholdPass::release_labels() {
  return labels_.unmap();
}

}  // namespace sslv
