// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/source.h"

namespace sslv {

/// "aravis": GigE Vision and USB3 Vision cameras.
Backend aravis_backend();

}  // namespace sslv
