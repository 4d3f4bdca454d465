// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "web/router.h"

#include <span>

namespace sslv {

/// Every route; what is not listed is looked for among the panel's files.
std::span<const Route> routes();

}  // namespace sslv
