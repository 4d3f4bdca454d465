// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>

namespace sslv {

/// Result of the driver's glGetGraphicsResetStatus in this program (gpu_context_test.cpp); 0: no reset.
extern std::atomic<unsigned> faked_reset_status;

}  // namespace sslv
