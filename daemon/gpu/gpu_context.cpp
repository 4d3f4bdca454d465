// SPDX-License-Identifier: Apache-2.0
#include "gpu/gpu_context.h"

#include "gpu/gl.h"

#include <array>
#include <string_view>
#include <utility>
#include <vector>

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <fmt/format.h>

namespace sslv {
namespace {

/// Whether a space-separated list contains this name.
bool has(const char* names, std::string_view name) {
  std::string_view rest = names != nullptr ? names : "";
  while (!rest.empty()) {
    const std::size_t end = rest.find(' ');
    if (rest.substr(0, end) == name) return true;
    if (end == std::string_view::npos) return false;
    rest.remove_prefix(end + 1);
  }
  return false;
}

std::string egl_error() {
  return fmt::format("EGL error 0x{:04x}", eglGetError());
}

const char* gl_text(GLenum name) {
  const GLubyte* text = glGetString(name);
  return text != nullptr ? reinterpret_cast<const char*>(text) : "";
}

template <class Function>
Function function_named(const char* name) {
  return reinterpret_cast<Function>(eglGetProcAddress(name));
}

/// A display that may provide a context, and its name.
using Candidate = std::pair<EGLDisplay, std::string>;

std::vector<Candidate> candidates() {
  std::vector<Candidate> found;
  const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  const auto display_of = function_named<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
  if (!has(client, "EGL_EXT_platform_base") || display_of == nullptr) return found;
  if (has(client, "EGL_MESA_platform_surfaceless")) {
    found.emplace_back(display_of(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr),
                       "surfaceless");
  }
  const auto query = function_named<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
  if (!has(client, "EGL_EXT_platform_device") || query == nullptr) return found;
  std::array<EGLDeviceEXT, 32> devices{};
  EGLint count = 0;
  if (!query(static_cast<EGLint>(devices.size()), devices.data(), &count)) return found;
  for (EGLint i = 0; i < count; ++i) {
    found.emplace_back(display_of(EGL_PLATFORM_DEVICE_EXT, devices[static_cast<std::size_t>(i)], nullptr),
                       fmt::format("device {}", i));
  }
  return found;
}

}  // namespace

GpuContext::GpuContext() {
  std::string tried;
  Candidate software{EGL_NO_DISPLAY, ""};
  for (const auto& [display, way] : candidates()) {
    if (!open(display, way, tried)) continue;
    if (!is_software_) return;
    if (software.first == EGL_NO_DISPLAY) software = {display, way};
    close();
  }
  if (software.first != EGL_NO_DISPLAY && open(software.first, software.second, tried)) return;
  throw GpuError(
      fmt::format("no GPU: {}", tried.empty() ? "EGL has no driver for a display without a window" : tried));
}

GpuContext::~GpuContext() {
  close();
}

bool GpuContext::open(void* display, const std::string& way, std::string& tried) {
  const auto failed = [&](const std::string& why) {
    close();
    tried += fmt::format("{}{}: {}", tried.empty() ? "" : "; ", way, why);
    return false;
  };
  if (display == EGL_NO_DISPLAY) return failed("EGL has no such display");
  if (!eglInitialize(display, nullptr, nullptr)) return failed("cannot be opened, " + egl_error());
  display_ = display;
  const char* extensions = eglQueryString(display_, EGL_EXTENSIONS);
  if (!has(extensions, "EGL_KHR_surfaceless_context") || !has(extensions, "EGL_KHR_create_context"))
    return failed("supports no contexts without a surface");
  if (!make_context()) return failed("has no OpenGL ES 3.1, " + egl_error());
  const Use use(*this);
  if (!use) return failed("its context cannot be used, " + egl_error());
  describe(way);
  return true;
}

bool GpuContext::make_context() {
  const char* extensions = eglQueryString(display_, EGL_EXTENSIONS);
  EGLConfig config = EGL_NO_CONFIG_KHR;
  if (!has(extensions, "EGL_KHR_no_config_context")) {
    // Nothing is drawn to a surface, so any surface type will do.
    const std::array<EGLint, 5> wanted{EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_ES3_BIT_KHR,
                                       EGL_NONE};
    EGLint count = 0;
    if (!eglChooseConfig(display_, wanted.data(), &config, 1, &count) || count == 0) return false;
  }
  if (!eglBindAPI(EGL_OPENGL_ES_API)) return false;
  const bool tells_resets = has(extensions, "EGL_EXT_create_context_robustness");
  for (const bool robust : {true, false}) {
    if (robust && !tells_resets) continue;
    std::vector<EGLint> attributes{EGL_CONTEXT_MAJOR_VERSION_KHR, 3, EGL_CONTEXT_MINOR_VERSION_KHR, 1};
    if (robust) {
      attributes.insert(attributes.end(),
                        {EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY_EXT, EGL_LOSE_CONTEXT_ON_RESET_EXT});
    }
    attributes.push_back(EGL_NONE);
    context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, attributes.data());
    if (context_ != EGL_NO_CONTEXT) return true;
  }
  return false;
}

void GpuContext::describe(const std::string& way) {
  name_ = gl_text(GL_RENDERER);
  renderer_ = fmt::format("{}, {}, {}", name_, gl_text(GL_VERSION), way);
  is_software_ = false;
  for (const std::string_view program : {"llvmpipe", "softpipe", "SWR", "SwiftShader"})
    is_software_ = is_software_ || name_.find(program) != std::string::npos;
  const char* extensions = gl_text(GL_EXTENSIONS);
  has_timer_ = has(extensions, "GL_EXT_disjoint_timer_query");
  reset_status_ = nullptr;
  if (has(extensions, "GL_EXT_robustness"))
    reset_status_ = function_named<ResetStatus>("glGetGraphicsResetStatusEXT");
  else if (has(extensions, "GL_KHR_robustness"))
    reset_status_ = function_named<ResetStatus>("glGetGraphicsResetStatusKHR");
}

std::string GpuContext::take_problem() {
  if (reset_status_ != nullptr && reset_status_() != GL_NO_ERROR) is_lost_ = true;
  std::string problem;
  // Bounded: a lost context may return errors forever.
  for (int i = 0; i < 8; ++i) {
    const GLenum error = glGetError();
    if (error == GL_NO_ERROR) break;
    if (error == GL_CONTEXT_LOST_KHR) is_lost_ = true;
    if (problem.empty()) problem = fmt::format("GL error 0x{:04x}", error);
  }
  return is_lost_ ? "the GPU was reset" : problem;
}

void GpuContext::close() {
  // The display stays open: all EGL contexts of the process share it, and eglTerminate() would end them all.
  if (context_ != EGL_NO_CONTEXT) eglDestroyContext(display_, context_);
  context_ = EGL_NO_CONTEXT;
  display_ = EGL_NO_DISPLAY;
}

GpuContext::Use::Use(GpuContext& context) : context_(context) {
  is_current_ =
      !context.is_lost_ && eglMakeCurrent(context.display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context.context_);
  // EGL_BAD_ACCESS means that another thread uses the context, which is then not lost.
  if (!is_current_ && !context.is_lost_) context.is_lost_ = eglGetError() != EGL_BAD_ACCESS;
}

GpuContext::Use::~Use() {
  if (is_current_) eglMakeCurrent(context_.display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
}

}  // namespace sslv
