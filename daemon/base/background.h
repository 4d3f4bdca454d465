// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sslv {

/// Called by a thread that may wait: names it (at most 15 characters) and makes it yield to the
/// cameras' threads.
void become_background_thread(const char* name);

}  // namespace sslv
