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

/// Settings that are to take the place of others.
struct SettingsChange {
  enum class Origin {
    kStart,      // what is missing is reported, and the service starts all the same
    kAdminFile,  // may name files anywhere
    kNetwork,
  };
  const Config& now;  // in effect; at start the same as `next`
  const Config& next;
  Origin origin;
};

/// A file of the support bundle.
struct SupportFile {
  std::string name;
  std::string what;                   // for the bundle's README
  std::function<std::string()> make;  // may throw: the bundle says that the file is missing, and why
};

/// A recording that is wanted in the support bundle. It is too large for memory.
struct SupportRecording {
  std::filesystem::path file;
  std::string what;  // for the bundle's README
};

/// One capability that the panel offers: it owns its state and its lock, its routes and their JSON, its
/// alerts, checks and metrics. It takes by reference what it needs of others, never the daemon, and runs from
/// its constructor to its destructor. All members may be called from any thread; only daemon.cpp knows all
/// services.
class Service {
 public:
  virtual ~Service() = default;

  /// Begins what the destructor does, and does not wait for it: all services are told before one is waited
  /// for.
  virtual void ask_to_stop() {}

  /// Rows of the route table, whose handlers live as long as this.
  virtual std::vector<Route> routes() { return {}; }

  /// What it will do about changed settings. Has no effect and asks no device anything; at most it reads the
  /// files that the settings name. Throws SettingsError for what cannot be done.
  virtual Plan plan(const SettingsChange&) const { return {}; }

  /// Adds alerts and checks, and its keys of docs/openapi.json's Status where they are asked for. What an
  /// alert is about and a key says too comes from one reading, so that they agree.
  virtual void report(HealthReport&) const {}
  /// Adds keys to docs/openapi.json's Diagnostics.
  virtual void add_diagnostics(Json&) const {}
  virtual void write_metrics(MetricsText&) const {}
  virtual std::vector<SupportFile> support_files() const { return {}; }
  /// A clip of this name; none: it is not this service's. Throws HttpError when it cannot be had now.
  virtual std::optional<SupportRecording> support_clip(const std::string& /*name*/) const { return {}; }

  /// Called once a second by a thread of low priority, one service after the other: for what may wait.
  virtual void each_second() {}

  /// What is wrong now, as all services say; called once a second by that thread too.
  virtual void see_alerts(const std::vector<Alert>&) {}

  /// What was done since the last call, for the history. Called by that thread too, and at the end.
  virtual std::vector<Event> take_events() { return {}; }

 protected:
  Service() = default;
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  /// For what a plan does once it is carried out: making it is const.
  template <class S>
  static S& later(const S& service) {
    return const_cast<S&>(service);
  }
};

/// A number of the path or the query may not be larger.
inline constexpr int kMaxRouteNumber = 2'147'483'647;

}  // namespace sslv
