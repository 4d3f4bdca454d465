// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"

#include <string>
#include <tuple>

namespace sslv {

/// The destinations of tracks. Off by default, because in the league's matches the automatic referees send
/// tracks, not the vision.
struct TrackerSettings {
  bool enabled = false;
  std::string group = "224.5.23.2";
  int port = 10010;
  std::string source_name = "ssl-visiond";

  static constexpr auto fields() {
    using T = TrackerSettings;
    return std::tuple{
        flag("enabled", &T::enabled, "send tracks of robots and balls, as TrackerWrapperPacket"),
        text("group", &T::group,
             "IPv4 multicast or broadcast address that teams listen to for tracks; they go to "
             "network/vision/broadcast as well"),
        number("port", &T::port, 1, 65535, "", "UDP port that teams listen to for tracks"),
        text("source_name", &T::source_name, "name that identifies our tracks to other programs", 60),
    };
  }
};

}  // namespace sslv
