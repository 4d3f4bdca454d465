// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

namespace sslv {

/// There is no GPU that can be used; one line that says what was tried.
struct GpuError : std::runtime_error {
  using runtime_error::runtime_error;
};

/// OpenGL ES without a window, a screen or a server: EGL's surfaceless platform, or one of its devices. A
/// real GPU goes before Mesa's renderer on the CPU. The context is current only while a `Use` of it lives, so
/// that one thread may make it and another use it, one after the other.
class GpuContext {
 public:
  /// Throws GpuError where no EGL display gives a context of OpenGL ES 3.0 or later.
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
    /// False: the context is lost, or another thread uses it.
    explicit operator bool() const { return is_current_; }

   private:
    GpuContext& context_;
    bool is_current_;
  };

  /// GL's name of the renderer.
  const std::string& name() const { return name_; }
  /// The same with the version, and how it was reached.
  const std::string& renderer() const { return renderer_; }
  /// It is a program on the CPU.
  bool is_software() const { return is_software_; }
  /// OpenGL ES 3.1.
  bool has_compute() const { return has_compute_; }
  bool has_timer() const { return has_timer_; }

  /// What went wrong since the last call, in a few words; empty: nothing. Needs a Use.
  std::string take_problem();
  /// The GPU was reset, or its driver ended: nothing comes from this context any more. Make another one.
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
  ResetStatus reset_status_ = nullptr;  // where the driver tells of resets
  std::string name_, renderer_;
  bool is_software_ = false, has_compute_ = false, has_timer_ = false, is_lost_ = false;
};

}  // namespace sslv
