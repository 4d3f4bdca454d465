// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

namespace sslv {

/// No usable GPU. The text is one line that lists the attempts.
struct GpuError : std::runtime_error {
  using runtime_error::runtime_error;
};

/// OpenGL ES without a window, screen or server, through EGL's surfaceless platform or one of its devices.
/// Prefers a real GPU to Mesa's software renderer. The context is current only during a `Use`, so one thread
/// may create the context and another thread use it later.
class GpuContext {
 public:
  /// Throws GpuError if no EGL display provides a context of OpenGL ES 3.1 or later, which has compute
  /// shaders.
  GpuContext();
  ~GpuContext();
  GpuContext(const GpuContext&) = delete;
  GpuContext& operator=(const GpuContext&) = delete;

  /// Makes the context current in this thread, until the end of the scope.
  class Use {
   public:
    explicit Use(GpuContext& context);
    ~Use();
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;
    /// False if the context is lost or in use by another thread.
    explicit operator bool() const { return is_current_; }

   private:
    GpuContext& context_;
    bool is_current_;
  };

  /// GL_RENDERER.
  const std::string& name() const { return name_; }
  /// name() with the version and the EGL path used.
  const std::string& renderer() const { return renderer_; }
  /// Whether rendering runs on the CPU.
  bool is_software() const { return is_software_; }
  bool has_timer() const { return has_timer_; }

  /// The problem since the last call, in a few words; empty if there was none. Needs a Use.
  std::string take_problem();
  /// Whether this context is permanently unusable, because the GPU was reset or its driver ended. Create
  /// another context then.
  bool is_lost() const { return is_lost_; }

  /// EGLDisplay and EGLContext.
  void* egl_display() const { return display_; }
  void* egl_context() const { return context_; }

 private:
  using ResetStatus = unsigned (*)();

  bool open(void* display, const std::string& way, std::string& tried);
  bool make_context();
  void describe(const std::string& way);
  void close();

  void* display_ = nullptr;
  void* context_ = nullptr;
  ResetStatus reset_status_ = nullptr;  // null if the driver does not report resets
  std::string name_, renderer_;
  bool is_software_ = false, has_timer_ = false, is_lost_ = false;
};

}  // namespace sslv
