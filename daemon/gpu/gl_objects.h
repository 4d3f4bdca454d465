// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "gpu/gl.h"

#include <cstddef>
#include <string>
#include <utility>

namespace sslv {

/// Owns a GL object name; 0: none. Deletes the object only while a context is current: a lost context has
/// destroyed all its objects.
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

/// A GL buffer object that only grows.
class GlBuffer {
 public:
  /// `target` and `usage`: see glBufferData.
  GlBuffer(GLenum target, GLenum usage) : target_(target), usage_(usage) {}

  /// Binds the buffer with at least `bytes` of space; growing discards its contents.
  void bind(std::size_t bytes);
  GLuint name() const { return name_.get(); }

  /// Maps `bytes` for writing; null on failure. Write all bytes, and call unmap() before GL reads them.
  void* map_to_write(std::size_t bytes);
  /// Maps the first `bytes` for reading after GL has written them; null on failure.
  const void* map_to_read(std::size_t bytes);
  /// Returns false if the written contents were lost.
  bool unmap();

 private:
  GLenum target_, usage_;
  std::size_t room_ = 0;
  GlName name_{[](GLuint name) { glDeleteBuffers(1, &name); }};
};

/// Builds a program from a compute shader. Empty if the driver rejects the GLSL; `problem` is then the
/// driver's message.
GlName compute_program(const std::string& shader, std::string& problem);

}  // namespace sslv
