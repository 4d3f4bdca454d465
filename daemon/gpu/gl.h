// SPDX-License-Identifier: Apache-2.0
#pragma once

// gl2ext.h needs gl31.h.
// clang-format off
#include <GLES3/gl31.h>
#include <GLES2/gl2ext.h>
// clang-format on
