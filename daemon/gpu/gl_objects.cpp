// SPDX-License-Identifier: Apache-2.0
#include "gpu/gl_objects.h"

#include <initializer_list>

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

GlName compiled(GLenum kind, const std::string& source, std::string& problem) {
  GlName shader(glCreateShader(kind), [](GLuint name) { glDeleteShader(name); });
  const char* text = source.c_str();
  glShaderSource(shader.get(), 1, &text, nullptr);
  glCompileShader(shader.get());
  GLint is_good = GL_FALSE;
  glGetShaderiv(shader.get(), GL_COMPILE_STATUS, &is_good);
  if (is_good == GL_FALSE) problem = "shader: " + log_of(shader.get(), glGetShaderInfoLog);
  return shader;
}

GlName linked(std::initializer_list<GLuint> shaders, std::string& problem) {
  const auto destroy = [](GLuint name) { glDeleteProgram(name); };
  if (!problem.empty()) return GlName(destroy);
  GlName program(glCreateProgram(), destroy);
  for (const GLuint shader : shaders) glAttachShader(program.get(), shader);
  glLinkProgram(program.get());
  GLint is_good = GL_FALSE;
  glGetProgramiv(program.get(), GL_LINK_STATUS, &is_good);
  if (is_good == GL_TRUE) return program;
  problem = "program: " + log_of(program.get(), glGetProgramInfoLog);
  return GlName(destroy);
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

void GlTexture::bind(int unit, GLenum format, int width, int height) {
  glActiveTexture(static_cast<GLenum>(GL_TEXTURE0 + unit));
  if (name_ && format == format_ && width == width_ && height == height_) {
    glBindTexture(GL_TEXTURE_2D, name_.get());
    return;
  }
  GLuint name = 0;
  glGenTextures(1, &name);
  name_ = GlName(name, [](GLuint old) { glDeleteTextures(1, &old); });
  format_ = format;
  width_ = width;
  height_ = height;
  glBindTexture(GL_TEXTURE_2D, name);
  glTexStorage2D(GL_TEXTURE_2D, 1, format, width, height);
  // Integer textures are incomplete with any other filter.
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
}

GlName compute_program(const std::string& shader, std::string& problem) {
  const GlName compute = compiled(GL_COMPUTE_SHADER, shader, problem);
  return linked({compute.get()}, problem);
}

GlName fragment_program(const std::string& vertex, const std::string& fragment, std::string& problem) {
  const GlName first = compiled(GL_VERTEX_SHADER, vertex, problem);
  if (!problem.empty()) return linked({}, problem);
  const GlName second = compiled(GL_FRAGMENT_SHADER, fragment, problem);
  return linked({first.get(), second.get()}, problem);
}

}  // namespace sslv
