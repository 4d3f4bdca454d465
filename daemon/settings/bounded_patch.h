// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <cstddef>

namespace sslv {

/// Limits while a JSON Patch is applied: a few hundred bytes of "copy" could fill all memory, or nest values
/// deeper than any stack.
struct PatchLimits {
  std::size_t operations = 20'000;
  /// `size`: number of values plus bytes of text in the result. `work`: the same sum over everything that the
  /// operations read and move, plus the keys and elements that are searched along their paths.
  std::size_t size = 1'000'000, work = 10'000'000;
  std::size_t depth = 64;
};

/// Applies a JSON Patch (RFC 6902). Throws SettingsError if a limit would be exceeded, before memory is
/// allocated for it, and if the patch is invalid or does not fit the document.
Json apply_patch(Json document, const Json& patch, const PatchLimits& limits = {});

}  // namespace sslv
