// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "services/event.h"
#include "services/health_report.h"
#include "settings/plan.h"
#include "web/route.h"

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace sslv {

struct Config;
class MetricsText;

/// The settings in effect and the settings that are to replace them.
struct SettingsChange {
  enum class Origin {
    kStart,      // missing parts are reported, and the service starts anyway
    kAdminFile,  // may name files anywhere
    kNetwork,
  };
  const Config& now;  // settings in effect; at start the same as `next`
  const Config& next;
  Origin origin;
};

/// A file of the support bundle.
struct SupportFile {
  std::string name;
  std::string what;                   // for the bundle's README
  std::function<std::string()> make;  // may throw; the bundle then lists the file as missing, with the reason
};

/// A recording requested for the support bundle. It is too large for memory.
struct SupportRecording {
  std::filesystem::path file;
  std::string what;  // for the bundle's README
};

/// One capability that the panel offers. A service owns its state and its lock, its routes and their JSON,
/// its alerts, checks and metrics. Its constructor receives references to the interfaces that it needs of
/// other services, never to the whole daemon. It runs from its constructor to its destructor. All members are
/// thread-safe; only daemon.cpp knows all services.
class Service {
 public:
  virtual ~Service() = default;

  /// Starts stopping without waiting: the daemon asks all services before it waits for the first one to stop.
  virtual void ask_to_stop() {}

  /// Rows of the route table; their handlers are valid as long as this object.
  virtual std::vector<Route> routes() { return {}; }

  /// Plans a change of settings. Has no effect and queries no device; at most it reads the files that the
  /// settings name. Throws SettingsError if the change is not possible.
  virtual Plan plan(const SettingsChange&) const { return {}; }

  /// Adds alerts and checks, and its keys of docs/openapi.json's Status if they are requested. If an alert
  /// and a key report the same thing, they are computed from the same reading, so that they agree.
  virtual void report(HealthReport&) const {}
  /// Adds keys to docs/openapi.json's Diagnostics.
  virtual void add_diagnostics(Json&) const {}
  virtual void write_metrics(MetricsText&) const {}
  virtual std::vector<SupportFile> support_files() const { return {}; }
  /// Returns the clip with this name; nothing if the clip does not belong to this service. Throws HttpError
  /// if the clip is unavailable at present.
  virtual std::optional<SupportRecording> support_clip(const std::string& /*name*/) const { return {}; }

  /// Called once a second by a thread of low priority, one service after the other: for work that may wait.
  virtual void each_second() {}

  /// Receives the current alerts of all services; called once a second by the thread of each_second().
  virtual void see_alerts(const std::vector<Alert>&) {}

  /// Returns the events since the last call, for the history. Called by the thread of each_second(), and once
  /// at the end.
  virtual std::vector<Event> take_events() { return {}; }

 protected:
  Service() = default;
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  /// For the functions of a plan, which change the service although making the plan is const.
  template <class S>
  static S& later(const S& service) {
    return const_cast<S&>(service);
  }
};

/// Limit for numbers in the path or the query.
inline constexpr int kMaxRouteNumber = 2'147'483'647;

}  // namespace sslv
