// SPDX-License-Identifier: Apache-2.0
#include "gpu/gl_objects.h"

#include <EGL/egl.h>

namespace sslv {
namespace {

/// The driver's message, in one line.
template <class Get>
std::string log_of(GLuint name, const Get& get) {
  std::string text(1000, '\0');
  GLsizei length = 0;
  get(name, static_cast<GLsizei>(text.size()), &length, text.data());
  text.resize(static_cast<std::size_t>(length));
  for (char& c : text) {
    if (c == '\n') c = ' ';
  }
  return text;
}

}  // namespace

GlName::~GlName() {
  if (name_ != 0 && eglGetCurrentContext() != EGL_NO_CONTEXT) destroy_(name_);
}

void GlBuffer::bind(std::size_t bytes) {
  if (!name_) {
    GLuint name = 0;
    glGenBuffers(1, &name);
    name_ = GlName(name, [](GLuint old) { glDeleteBuffers(1, &old); });
  }
  glBindBuffer(target_, name_.get());
  if (bytes <= room_) return;
  glBufferData(target_, static_cast<GLsizeiptr>(bytes), nullptr, usage_);
  room_ = bytes;
}

void* GlBuffer::map_to_write(std::size_t bytes) {
  bind(bytes);
  return glMapBufferRange(target_, 0, static_cast<GLsizeiptr>(bytes),
                          GL_MAP_WRITE_BIT | GL_MAP_INVALIDATE_BUFFER_BIT);
}

const void* GlBuffer::map_to_read(std::size_t bytes) {
  glBindBuffer(target_, name_.get());
  return glMapBufferRange(target_, 0, static_cast<GLsizeiptr>(bytes), GL_MAP_READ_BIT);
}

bool GlBuffer::unmap() {
  glBindBuffer(target_, name_.get());
  return glUnmapBuffer(target_) == GL_TRUE;
}

GlName compute_program(const std::string& source, std::string& problem) {
  const auto destroy = [](GLuint name) { glDeleteProgram(name); };
  const GlName shader(glCreateShader(GL_COMPUTE_SHADER), [](GLuint name) { glDeleteShader(name); });
  const char* text = source.c_str();
  glShaderSource(shader.get(), 1, &text, nullptr);
  glCompileShader(shader.get());
  GLint is_good = GL_FALSE;
  glGetShaderiv(shader.get(), GL_COMPILE_STATUS, &is_good);
  if (is_good == GL_FALSE) {
    problem = "shader: " + log_of(shader.get(), glGetShaderInfoLog);
    return GlName(destroy);
  }
  GlName program(glCreateProgram(), destroy);
  glAttachShader(program.get(), shader.get());
  glLinkProgram(program.get());
  glGetProgramiv(program.get(), GL_LINK_STATUS, &is_good);
  if (is_good == GL_TRUE) return program;
  problem = "program: " + log_of(program.get(), glGetProgramInfoLog);
  return GlName(destroy);
}

}  // namespace sslv
