// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "web/http.h"

#include <filesystem>
#include <span>
#include <string>

namespace sslv {

/// The built panel's files, read from their directory at every request, so that a rebuilt panel shows at
/// once.
class StaticFiles {
 public:
  /// The directory may be missing: get() then says how to build the panel.
  explicit StaticFiles(std::filesystem::path directory) : directory_(std::move(directory)) {}

  /// `path`: decoded parts as parse_target() leaves them, none of which leads out of the directory. Throws
  /// HttpError 404.
  Response get(std::span<const std::string> path) const;

 private:
  std::filesystem::path directory_;
};

}  // namespace sslv
