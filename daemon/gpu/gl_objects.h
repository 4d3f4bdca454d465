// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "gpu/gl.h"

#include <cstddef>
#include <string>
#include <utility>

namespace sslv {

/// A name of GL's, 0: none yet. Deleted only where a context is current: a lost one took all with it.
class GlName {
 public:
  using Delete = void (*)(GLuint name);

  explicit GlName(Delete destroy) : destroy_(destroy) {}
  GlName(GLuint name, Delete destroy) : name_(name), destroy_(destroy) {}
  GlName(GlName&& other) noexcept : name_(std::exchange(other.name_, 0)), destroy_(other.destroy_) {}
  GlName& operator=(GlName&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }
  GlName(const GlName&) = delete;
  GlName& operator=(const GlName&) = delete;
  ~GlName();

  GLuint get() const { return name_; }
  explicit operator bool() const { return name_ != 0; }

 private:
  GLuint name_ = 0;
  Delete destroy_;
};

/// Memory of GL's that only grows.
class GlBuffer {
 public:
  /// `target` and `usage` as glBufferData has them.
  GlBuffer(GLenum target, GLenum usage) : target_(target), usage_(usage) {}

  /// Binds it, with room for so many bytes; what was in it is gone when it grows.
  void bind(std::size_t bytes);
  GLuint name() const { return name_.get(); }

  /// Room for `bytes` that are all written, or null. Unmap before GL reads them.
  void* map_to_write(std::size_t bytes);
  /// The first `bytes`, when GL has written them; or null.
  const void* map_to_read(std::size_t bytes);
  /// False: what was written is gone.
  bool unmap();

 private:
  GLenum target_, usage_;
  std::size_t room_ = 0;
  GlName name_{[](GLuint name) { glDeleteBuffers(1, &name); }};
};

/// A 2D texture of whole numbers, without filters.
class GlTexture {
 public:
  /// Binds it to a unit, with this format and size.
  void bind(int unit, GLenum format, int width, int height);
  GLuint name() const { return name_.get(); }

 private:
  GLenum format_ = 0;
  int width_ = 0, height_ = 0;
  GlName name_{[](GLuint name) { glDeleteTextures(1, &name); }};
};

/// A program of one compute shader, or of a vertex and a fragment shader. Empty when it is not GLSL as this
/// driver knows it: `problem` has the driver's words.
GlName compute_program(const std::string& shader, std::string& problem);
GlName fragment_program(const std::string& vertex, const std::string& fragment, std::string& problem);

}  // namespace sslv
