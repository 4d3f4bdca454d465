// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/event.h"
#include "settings/history.h"

namespace sslv {

/// A step of the settings for the history of events: what was done, and the first of the places it changed.
Event event_of(const SettingsStep& step);

}  // namespace sslv
