// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "gpu/gpu_context.h"

#include <memory>

#include <gtest/gtest.h>

namespace sslv {

/// Tests that need any kind of GPU; skipped without one.
class WithGpu : public ::testing::Test {
 protected:
  void SetUp() override {
    try {
      context_ = std::make_unique<GpuContext>();
    } catch (const GpuError& none) {
      GTEST_SKIP() << none.what();
    }
  }
  GpuContext& context() { return *context_; }

  std::unique_ptr<GpuContext> context_;
};

}  // namespace sslv
