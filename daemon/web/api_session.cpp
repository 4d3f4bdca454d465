// SPDX-License-Identifier: Apache-2.0
#include "base/params_json.h"
#include "web/access.h"
#include "web/api.h"
#include "web/http.h"

#include <httplib.h>

namespace sslv {
namespace {

/// Which passwords may be set is not decided here: a text that is refused is shown, and a password must not
/// be.
constexpr std::size_t kMaxPassword = 2'000'000;

struct SignIn {
  std::string password;
  static constexpr auto fields() {
    return std::tuple{text("password", &SignIn::password, "the admin's or the viewers'", kMaxPassword)};
  }
};

struct NewPassword {
  std::string password, admin_password;
  static constexpr auto fields() {
    return std::tuple{
        text("password", &NewPassword::password, "the new one; empty: none any more", kMaxPassword),
        text("admin_password", &NewPassword::admin_password, "the admin's one of now, where there is one",
             kMaxPassword)};
  }
};

struct OpenLock {
  bool opened = false;
  static constexpr auto fields() {
    return std::tuple{flag("opened", &OpenLock::opened, "settings may be changed until the match ends")};
  }
};

Json lock_json(const MatchLock& lock) {
  return {{"game_is_running", lock.game_is_running}, {"opened", lock.opened}, {"locked", lock.is_locked()}};
}

void answer_state(const WebHost& host, const std::string& cookies, httplib::Response& response) {
  Json out = host.access->state(cookies);
  out["match_lock"] = lock_json(host.match_lock());
  set_json(response, out);
}

/// What it answers with holds for the cookie that it hands out.
void answer_with_cookie(const WebHost& host, const std::string& set_cookie, httplib::Response& response) {
  response.set_header("Set-Cookie", set_cookie);
  answer_state(host, set_cookie.substr(0, set_cookie.find(';')), response);
}

}  // namespace

void get_session(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  answer_state(host, request.get_header_value("Cookie"), response);
}

void sign_in(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  const auto body = params_from_json<SignIn>(parse_json(request.body), "");
  answer_with_cookie(host, host.access->sign_in(body.password, request.remote_addr), response);
}

void sign_out(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  answer_with_cookie(host, host.access->sign_out(request.get_header_value("Cookie")), response);
}

void set_password(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  const auto role = role_named(request.matches[1].str());
  if (!role) throw HttpError(404, "there are passwords for \"admin\" and \"viewer\" only");
  const auto body = params_from_json<NewPassword>(parse_json(request.body), "");
  const auto password = body.password.empty() ? std::nullopt : std::optional(body.password);
  answer_with_cookie(
      host, host.access->set_password(*role, password, body.admin_password, request.remote_addr), response);
}

void open_match_lock(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  const auto body = params_from_json<OpenLock>(parse_json(request.body), "");
  set_json(response, lock_json(host.open_match_lock(body.opened, request.remote_addr)));
}

}  // namespace sslv
