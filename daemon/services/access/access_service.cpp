// SPDX-License-Identifier: Apache-2.0
#include "services/access/access_service.h"

#include "base/clock.h"
#include "base/params_json.h"

#include <optional>
#include <tuple>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

struct SignIn {
  std::string password;
  static constexpr auto fields() {
    return std::tuple{secret("password", &SignIn::password, "the admin's or the viewers'")};
  }
};

struct NewPassword {
  std::string password, admin_password;
  static constexpr auto fields() {
    return std::tuple{secret("password", &NewPassword::password, "the new one; empty: removes it"),
                      secret("admin_password", &NewPassword::admin_password,
                             "the current admin password, if there is one")};
  }
};

struct OpenLock {
  bool opened = false;
  static constexpr auto fields() {
    return std::tuple{flag("opened", &OpenLock::opened, "settings may be changed until the match ends")};
  }
};

Json lock_json(const MatchLock::State& lock) {
  return {{"game_is_running", lock.game_is_running}, {"opened", lock.opened}, {"locked", lock.is_locked()}};
}

}  // namespace

AccessService::AccessService(const Snapshot<Config>& config, Passwords& passwords, MatchLock& match_lock,
                             const Snapshot<PanelReach>& reach)
    : config_(config),
      passwords_(passwords),
      match_lock_(match_lock),
      reach_(reach),
      access_(passwords, fmt::format("ssl_visiond_{}", config.load()->panel.port), steady_s) {}

std::vector<Route> AccessService::routes() {
  const auto call = [this](Response (AccessService::*handle)(const Request&)) -> Handler {
    return [this, handle](const Request& request) { return (this->*handle)(request); };
  };
  return {
      {"GET", "/api/session", [this](const Request& request) { return state_response(request.cookies); },
       Needs::kNothing, Speed::kAtOnce},
      {"POST", "/api/session", call(&AccessService::sign_in), Needs::kNothing,
       Speed::kTakesMemory},  // hashing a password takes 16 MiB
      {"DELETE", "/api/session", call(&AccessService::sign_out), Needs::kNothing},
      {"PUT", "/api/passwords/([^/]+)", call(&AccessService::set_password), Needs::kChange,
       Speed::kTakesMemory},
      {"POST", "/api/match_lock", call(&AccessService::set_lock), Needs::kChange},
  };
}

void AccessService::report(HealthReport& report) const {
  if (report.status) (*report.status)["panel"] = panel_reach_json(*reach_.load());
}

void AccessService::each_second() {
  refresh();  // also for clients that stay connected
  // state() also locks again when the match ends.
  const bool is_running = match_lock_.state().game_is_running;
  if (std::exchange(was_running_, is_running) == is_running) return;
  events_.add(is_running
                  ? Event{"match_locked", "The game is running: the settings are locked"}
                  : Event{"match_unlocked", "The game is no longer running: the settings are unlocked"});
}

Response AccessService::state_response(const std::string& cookies) {
  Json out = access_.state(cookies);
  out["match_lock"] = lock_json(match_lock_.state());
  return json_response(out);
}

/// Answers with the state that applies to the new cookie.
Response AccessService::set_cookie_response(const std::string& set_cookie) {
  Response response = state_response(set_cookie.substr(0, set_cookie.find(';')));
  response.headers.emplace_back("Set-Cookie", set_cookie);
  return response;
}

Response AccessService::sign_in(const Request& request) {
  const auto body = params_from_json<SignIn>(parse_json(request.body), "");
  return set_cookie_response(access_.sign_in(body.password, request.address));
}

Response AccessService::sign_out(const Request& request) {
  return set_cookie_response(access_.sign_out(request.cookies));
}

Response AccessService::set_password(const Request& request) {
  const auto role = role_named(request.matches[1]);
  if (!role) throw HttpError(404, "there are only passwords for \"admin\" and \"viewer\"");
  const auto body = params_from_json<NewPassword>(parse_json(request.body), "");
  const auto password = body.password.empty() ? std::nullopt : std::optional(body.password);
  return set_cookie_response(access_.set_password(*role, password, body.admin_password, request.address));
}

Response AccessService::set_lock(const Request& request) {
  const auto body = params_from_json<OpenLock>(parse_json(request.body), "");
  const MatchLock::State state = match_lock_.set_opened(body.opened, request.address);
  events_.add({body.opened ? "match_unlocked" : "match_locked",
               body.opened ? "The settings were unlocked for this match"
                           : "The settings were locked again for this match",
               request.address});
  return json_response(lock_json(state));
}

}  // namespace sslv
