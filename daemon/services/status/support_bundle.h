// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/service.h"

#include <optional>
#include <string>
#include <vector>

namespace sslv {

/// Returns a bug report's attachment as a download: these files, and a README that describes them and lists
/// missing files with the reasons. It contains no secrets, because the settings contain none (see Passwords).
/// Without a recording, it is a .tar.gz. With a recording, which is too large for memory, it is a .tar, for a
/// route that streams.
Response support_bundle(const std::vector<SupportFile>& files,
                        const std::optional<SupportRecording>& recording, const std::stop_token& stop);

/// The last lines of the log.
std::string log_text();

}  // namespace sslv
