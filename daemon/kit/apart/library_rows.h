// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipeline/camera_stage.h"
#include "pipeline/field_stage.h"

#include <string>
#include <vector>

namespace sslv {

/// What a stage library has.
struct StageRows {
  std::vector<StageType> camera;
  std::vector<FieldStageType> field;
};

/// The rows of a library, which says them by `extern "C" const sslv::StageRows* sslv_stages()`. Its code
/// runs. It stays loaded. Throws std::runtime_error, one line.
const StageRows& load_rows(const std::string& library);

}  // namespace sslv
