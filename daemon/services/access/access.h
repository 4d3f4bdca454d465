// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "settings/passwords.h"
#include "web/gate.h"
#include "web/route.h"

#include <array>
#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

namespace sslv {

/// A sign-in that came too soon after others that failed.
struct TooManyTries : HttpError {
  explicit TooManyTries(int seconds);
  int wait_s;
};

/// Who may do what. Without an admin's password everybody may change everything: the daemon serves its own
/// computer only, then. With one, everybody may look, or only who knows the viewers' password where there is
/// one. Who signs in gets a cookie with 256 random bits; sessions end with the service. May be used from any
/// thread.
class Access {
 public:
  using Clock = std::function<double()>;  // steady, s
  static constexpr double kIdle_s = 24 * 3600.0, kLongest_s = 7 * 24 * 3600.0;
  /// Of each role. One that is too many ends one of its own role: if it can, one that was not used for
  /// kPresent_s, which an open panel always was. Of these it is the idlest of the address that has most of
  /// them, in the subnet that has most: who opens many ends only his own.
  static constexpr std::size_t kMaxSessions = 256;
  static constexpr double kPresent_s = 60;

  /// `cookie`: its name; browsers do not tell the ports of a computer apart.
  Access(Passwords& passwords, std::string cookie, Clock now_s);

  /// By the Cookie header, "" when there is none.
  May may(std::string_view cookies);

  /// {"may": ..., "signed_in": ..., "passwords": [...]} of docs/openapi.json.
  Json state(std::string_view cookies);

  /// The Set-Cookie header. Takes some ten milliseconds. Throws HttpError 401 for a wrong password,
  /// TooManyTries, and HttpError 409 when there is no password.
  std::string sign_in(const std::string& password, const std::string& address);
  /// The Set-Cookie header that removes the cookie.
  std::string sign_out(std::string_view cookies);

  /// Sets the password of a role, or removes the viewers' password. The client that did so stays signed in,
  /// all others that used the old one are signed out. With an admin's password set, `admin_password` must be
  /// it. Answers with the Set-Cookie header. Throws as sign_in() and Passwords::set() do.
  std::string set_password(Role role, const std::optional<std::string>& password,
                           const std::string& admin_password, const std::string& address);

  /// Whether strangers must leave room for this address: it is this computer's own, or the current
  /// admin password came from it within kLongest_s. Takes no time.
  bool is_trusted(const std::string& address);

 private:
  struct Session {
    Role role;
    std::string hash;     // of the password it was opened with
    std::string network;  // that it was opened from
    double opened_s, used_s;
  };
  /// An address that somebody signed in from.
  struct Known {
    Role role;
    std::string hash;  // of the password that was given
    double at_s;
  };
  /// Addresses that share a limit of tries. Each circle has its own, so that none of them can use up
  /// another's.
  enum class Circle { kStrangers, kViewers, kAdmins, kThisComputer };
  static constexpr std::size_t kCircles = 4;
  /// Tries that may still be made: they come back with time.
  struct Tries {
    double left, at_s;
    bool take(double now_s, double most, double back_s);
    int wait_s(double back_s) const;
  };
  std::optional<Role> session_role(std::string_view cookies);
  Role check(const std::string& password, const std::string& address);
  std::string open_session(Role role, const std::string& address);
  std::string token_in(std::string_view cookies) const;

  // With mutex_ held:
  Circle circle_of(const std::string& address) const;
  void take_try(Circle circle, const std::string& key);
  void remember(Role role, const std::string& address);
  void make_room_for_session(Role role);
  bool is_over(const Session& session) const;

  Passwords& passwords_;
  const std::string cookie_;
  const Clock now_s_;
  std::mutex mutex_;                         // guards what follows
  std::map<std::string, Session> sessions_;  // by token
  std::map<std::string, Known> known_;       // by address
  std::map<std::string, Tries> tries_;       // by network, an admin's by address
  std::array<Tries, kCircles> circle_tries_;
};

}  // namespace sslv
