// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/event.h"
#include "settings/history.h"

namespace sslv {

/// Event for a step of the settings; its title names the action and the first places that the action changed.
Event event_of(const SettingsStep& step);

}  // namespace sslv
