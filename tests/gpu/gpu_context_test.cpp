// SPDX-License-Identifier: Apache-2.0
#include "gpu/gpu_context.h"

#include "faked_reset.h"
#include "gpu/gl.h"
#include "gpu/gpu_threshold.h"
#include "gpu_or_skip.h"

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <latch>
#include <string>
#include <thread>
#include <vector>

#include <EGL/egl.h>
#include <dlfcn.h>
#include <gmock/gmock.h>

std::atomic<unsigned> sslv::faked_reset_status{GL_NO_ERROR};

namespace {

GLenum reset_status() {
  return sslv::faked_reset_status;
}

}  // namespace

/// Replaces EGL's function: a driver that reports a reset when a test requests it.
extern "C" __eglMustCastToProperFunctionPointerType eglGetProcAddress(const char* name) {
  if (std::strncmp(name, "glGetGraphicsResetStatus", std::strlen("glGetGraphicsResetStatus")) == 0)
    return reinterpret_cast<__eglMustCastToProperFunctionPointerType>(&reset_status);
  static const auto real =
      reinterpret_cast<decltype(&eglGetProcAddress)>(dlsym(RTLD_NEXT, "eglGetProcAddress"));
  return real(name);
}

namespace sslv {
namespace {

using ::testing::HasSubstr;

const std::vector<std::uint8_t> kGrey(64 * 8, 90);

/// A small grey image.
struct Grey {
  Image image{ImageView{kGrey.data(), 64, 8, 64, PixelFormat::kMono8}, nullptr, nullptr, nullptr};
  Mask mask;
  LabelImage labels;
};

Lut lut_of_one(Label label) {
  return Lut(ColorTable(7, std::vector<Label>(std::size_t{1} << 21, label)));
}

class GpuContextTest : public WithGpu {
 protected:
  void TearDown() override { faked_reset_status = GL_NO_ERROR; }
};

TEST_F(GpuContextTest, SaysWhatItIs) {
  EXPECT_THAT(context().renderer(), HasSubstr("OpenGL ES 3"));
  EXPECT_EQ(context().is_software(), context().renderer().find("llvmpipe") != std::string::npos);
  EXPECT_FALSE(context().is_lost());
  EXPECT_EQ(eglGetCurrentContext(), EGL_NO_CONTEXT) << "only while it is used";
}

TEST_F(GpuContextTest, AContextThatIsGoneIsToldWithEveryImage) {
  GpuThreshold gpu(context());
  const Lut lut = lut_of_one(3);
  Grey grey;
  ASSERT_TRUE(gpu.process(lut, grey.mask, grey.image, grey.labels));
  ASSERT_TRUE(eglDestroyContext(context().egl_display(), context().egl_context()));
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(gpu.process(lut, grey.mask, grey.image, grey.labels));
    EXPECT_FALSE(gpu.set_lut(lut, PixelFormat::kMono8));
    EXPECT_EQ(gpu.problem(), "the context is lost");
  }
  EXPECT_TRUE(context().is_lost());
  EXPECT_THROW(GpuThreshold{context()}, GpuError);
  // A new context works, even in the same process.
  GpuContext next;
  GpuThreshold again(next);
  EXPECT_TRUE(again.process(lut, grey.mask, grey.image, grey.labels)) << again.problem();
}

TEST_F(GpuContextTest, AResetIsToldWithTheImageThatItTook) {
  GpuThreshold gpu(context());
  const Lut lut = lut_of_one(4);
  Grey grey;
  ASSERT_TRUE(gpu.process(lut, grey.mask, grey.image, grey.labels));
  faked_reset_status = GL_UNKNOWN_CONTEXT_RESET_KHR;
  EXPECT_FALSE(gpu.process(lut, grey.mask, grey.image, grey.labels));
  EXPECT_EQ(gpu.problem(), "the GPU was reset");
  EXPECT_TRUE(context().is_lost());
  // A GPU that works again does not restore the lost context.
  faked_reset_status = GL_NO_ERROR;
  EXPECT_FALSE(gpu.process(lut, grey.mask, grey.image, grey.labels));
  EXPECT_EQ(gpu.problem(), "the context is lost");
}

TEST_F(GpuContextTest, IsMadeInOneThreadAndUsedInAnother) {
  GpuThreshold gpu(context());
  const Lut lut = lut_of_one(5);
  for (int i = 0; i < 2; ++i) {
    std::thread([&] {
      Grey grey;
      EXPECT_TRUE(gpu.process(lut, grey.mask, grey.image, grey.labels)) << gpu.problem();
      EXPECT_EQ(grey.labels.labels, std::vector<Label>(kGrey.size(), 5));
    }).join();
  }
}

TEST_F(GpuContextTest, WhatAnotherThreadUsesIsNotLost) {
  GpuThreshold gpu(context());
  const Lut lut = lut_of_one(5);
  Grey grey;
  std::latch taken(1), tried(1);
  std::thread other([&] {
    const GpuContext::Use use(context());
    EXPECT_TRUE(use);
    taken.count_down();
    tried.wait();
  });
  taken.wait();
  EXPECT_FALSE(gpu.process(lut, grey.mask, grey.image, grey.labels));
  EXPECT_EQ(gpu.problem(), "another thread uses the context");
  tried.count_down();
  other.join();
  EXPECT_TRUE(gpu.process(lut, grey.mask, grey.image, grey.labels)) << gpu.problem();
}

TEST_F(GpuContextTest, SeveralLiveInOneProcess) {
  GpuContext second;
  GpuThreshold a(context()), b(second);
  const Lut three = lut_of_one(3), four = lut_of_one(4);
  Grey grey;
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(a.process(three, grey.mask, grey.image, grey.labels)) << a.problem();
    EXPECT_EQ(grey.labels.labels.front(), 3);
    ASSERT_TRUE(b.process(four, grey.mask, grey.image, grey.labels)) << b.problem();
    EXPECT_EQ(grey.labels.labels.front(), 4);
  }
}

/// Tries to open a GPU without EGL drivers. EGL searches for them once per process, so this needs its own
/// process.
[[noreturn]] void open_without_drivers() {
  setenv("__EGL_VENDOR_LIBRARY_DIRS", "/nonexistent", 1);
  unsetenv("__EGL_VENDOR_LIBRARY_FILENAMES");
  try {
    const GpuContext context;
    std::fprintf(stderr, "there is one: %s\n", context.renderer().c_str());
    std::exit(0);
  } catch (const GpuError& none) {
    std::fprintf(stderr, "%s\n", none.what());
    std::exit(3);
  }
}

TEST(GpuContextDeathTest, WithoutADriverOneLineSaysSo) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(open_without_drivers(), ::testing::ExitedWithCode(3), "^no GPU: [^\n]+\n$");
}

}  // namespace
}  // namespace sslv
