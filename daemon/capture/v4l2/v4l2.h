// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/source.h"
#include "capture/v4l2/v4l2_nodes.h"

#include <memory>
#include <vector>

namespace sslv {

/// "v4l2": webcams and every other camera with a kernel driver.
Backend v4l2_backend();

/// The backend's open and list functions for a given system, for tests.
std::unique_ptr<Source> open_v4l2(const Json& options, const V4l2System& system);
std::vector<FoundCamera> list_v4l2(const V4l2System& system);

}  // namespace sslv
