// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/service.h"
#include "services/settings/settings_editor.h"
#include "settings/profiles.h"

#include <string>
#include <vector>

namespace sslv {

/// Saves and applies profiles, that is, settings saved under a name.
class ProfileService final : public Service {
 public:
  /// Both must outlive this.
  ProfileService(Profiles& profiles, SettingsEditor& settings) : profiles_(profiles), settings_(settings) {}

  std::vector<Route> routes() override;

 private:
  /// Throws HttpError 404.
  Profile find(const std::string& name) const;
  Json list() const;
  Response get(const Request& request);
  Response save(const Request& request);
  Response apply(const Request& request);
  Response remove(const Request& request);

  Profiles& profiles_;
  SettingsEditor& settings_;
};

}  // namespace sslv
