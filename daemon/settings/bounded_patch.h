// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <cstddef>

namespace sslv {

/// What a JSON Patch may come to while it is applied: a few hundred bytes of "copy" could fill all memory, or
/// nest values deeper than any stack.
struct PatchLimits {
  std::size_t operations = 20'000;
  /// Values and bytes of text in the result; the same of all that the operations read and move, with the keys
  /// and elements that they pass on the way, together.
  std::size_t size = 1'000'000, work = 10'000'000;
  std::size_t depth = 64;
};

/// Applies a JSON Patch (RFC 6902). Throws SettingsError when a limit would be passed, before memory is taken
/// for it, and when the patch is none or does not fit.
Json apply_patch(Json document, const Json& patch, const PatchLimits& limits = {});

}  // namespace sslv
