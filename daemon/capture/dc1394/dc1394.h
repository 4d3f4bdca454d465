// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/source.h"

namespace sslv {

/// IIDC cameras on IEEE 1394 (FireWire), and USB cameras that libdc1394 supports.
Backend dc1394_backend();

}  // namespace sslv
