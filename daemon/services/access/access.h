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

/// Thrown for a sign-in too soon after failed sign-ins.
struct TooManyTries : HttpError {
  explicit TooManyTries(int seconds);
  int wait_s;
};

/// Access control. Without an admin password, everybody may change everything; the daemon then serves only
/// its own computer. With an admin password, everybody may view; if there is also a viewers' password, only
/// people who know it may view. Signing in sets a cookie with 256 random bits; sessions end with the
/// service. Thread-safe.
class Access {
 public:
  using Clock = std::function<double()>;  // steady, s
  static constexpr double kIdle_s = 24 * 3600.0, kLongest_s = 7 * 24 * 3600.0;
  /// Limit for each role. At the limit, a new session ends an earlier one of the same role, preferably one
  /// unused for kPresent_s (an open panel uses its session more often). Of the candidates, the subnet with
  /// the most sessions loses one: its address with the most sessions loses the session unused for longest.
  /// A person who opens many sessions thus ends only their own.
  static constexpr std::size_t kMaxSessions = 256;
  static constexpr double kPresent_s = 60;

  /// `cookie`: name of the cookie. Browsers share cookies between the ports of a computer.
  Access(Passwords& passwords, std::string cookie, Clock now_s);

  /// `cookies`: the Cookie header, "" if there is none.
  May may(std::string_view cookies);

  /// {"may": ..., "signed_in": ..., "passwords": [...]} of docs/openapi.json.
  Json state(std::string_view cookies);

  /// Returns the Set-Cookie header. Takes tens of milliseconds. Throws HttpError 401 for a wrong password,
  /// TooManyTries, and HttpError 409 if no password is set.
  std::string sign_in(const std::string& password, const std::string& address);
  /// Returns the Set-Cookie header that removes the cookie.
  std::string sign_out(std::string_view cookies);

  /// Sets the password of a role, or removes the viewers' password. This client stays signed in; all other
  /// clients that used the old password are signed out. If an admin password is set, `admin_password` must
  /// match it. Returns the Set-Cookie header. Throws like sign_in() and Passwords::set().
  std::string set_password(Role role, const std::optional<std::string>& password,
                           const std::string& admin_password, const std::string& address);

  /// Whether this address may use reserved connections: it belongs to this computer, or the current admin
  /// password was entered there within kLongest_s. Fast: no password is hashed.
  bool is_trusted(const std::string& address);

 private:
  struct Session {
    Role role;
    std::string hash;     // hash of the password that opened it
    std::string network;  // network from which it was opened
    double opened_s, used_s;
  };
  /// An address from which somebody signed in.
  struct Known {
    Role role;
    std::string hash;  // hash of the password that was entered
    double at_s;
  };
  /// Group of addresses that share a limit of password tries. Each circle has its own limit, so that no
  /// circle can use up the tries of another.
  enum class Circle { kStrangers, kViewers, kAdmins, kThisComputer };
  static constexpr std::size_t kCircles = 4;
  /// Remaining password tries; they are regained over time.
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
  std::mutex mutex_;                         // guards the members below
  std::map<std::string, Session> sessions_;  // by token
  std::map<std::string, Known> known_;       // by address
  std::map<std::string, Tries> tries_;       // by network; for admins by address
  std::array<Tries, kCircles> circle_tries_;
};

}  // namespace sslv
