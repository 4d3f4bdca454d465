// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/service.h"

#include <optional>
#include <string>
#include <vector>

namespace sslv {

/// A bug report's attachment, as a file to download: these files, and a README that says what they are and
/// which are missing, and why. There is no secret in it: the settings hold none (see Passwords). It is a
/// .tar.gz; with a recording, which is not held in memory, a .tar, for a route that streams.
Response support_bundle(const std::vector<SupportFile>& files,
                        const std::optional<SupportRecording>& recording, const std::stop_token& stop);

/// The last lines of the log.
std::string log_text();

}  // namespace sslv
