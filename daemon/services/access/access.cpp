// SPDX-License-Identifier: Apache-2.0
#include "services/access/access.h"

#include "base/log.h"
#include "web/http.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <utility>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/random.h>

namespace sslv {
namespace {

// Each address has 5 tries and regains one every 10 s. All addresses of a circle together have 20 tries and
// regain one per second, because hashing a password occupies a processor core that the cameras need.
constexpr double kMaxTries = 5, kTryBack_s = 10, kMaxTriesOfCircle = 20, kTryOfCircleBack_s = 1;
constexpr std::size_t kMaxAddresses = 1024;
constexpr std::size_t kMaxKnown = 256;  // remembered addresses per role

std::string random_token() {
  std::array<std::uint8_t, 32> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw std::runtime_error("the system provides no random numbers");
  std::string out;
  for (const std::uint8_t byte : bytes) out += fmt::format("{:02x}", byte);
  return out;
}

/// Whether it is a loopback address.
bool is_own_computer(const std::string& address) {
  constexpr std::uint8_t kLoopback = 127;
  in_addr v4{};
  if (inet_pton(AF_INET, address.c_str(), &v4) == 1) return ntohl(v4.s_addr) >> 24 == kLoopback;
  in6_addr v6{};
  if (inet_pton(AF_INET6, address.c_str(), &v6) != 1) return false;
  return IN6_IS_ADDR_LOOPBACK(&v6) || (IN6_IS_ADDR_V4MAPPED(&v6) && v6.s6_addr[12] == kLoopback);
}

/// Subnet of a network from network_of(): the first three numbers of an IPv4 address. One computer can have
/// many addresses in a subnet.
std::string subnet_of(const std::string& network) {
  return network.substr(0, network.rfind('.'));
}

}  // namespace

TooManyTries::TooManyTries(int seconds)
    : HttpError(429, fmt::format("too many wrong passwords; try again in {} s", seconds)), wait_s(seconds) {
  headers = {{"Retry-After", std::to_string(seconds)}};
}

bool Access::Tries::take(double now_s, double most, double back_s) {
  left = std::min(most, left + (now_s - at_s) / back_s);
  at_s = now_s;
  if (left < 1) return false;
  left -= 1;
  return true;
}

int Access::Tries::wait_s(double back_s) const {
  return std::max(1, static_cast<int>(std::ceil((1 - left) * back_s)));
}

Access::Access(Passwords& passwords, std::string cookie, Clock now_s)
    : passwords_(passwords), cookie_(std::move(cookie)), now_s_(std::move(now_s)) {
  circle_tries_.fill({kMaxTriesOfCircle, now_s_()});
}

May Access::may(std::string_view cookies) {
  if (!passwords_.has(Role::kAdmin)) return May::kChange;
  if (const auto role = session_role(cookies)) return *role == Role::kAdmin ? May::kChange : May::kLook;
  return passwords_.has(Role::kViewer) ? May::kNothing : May::kLook;
}

Json Access::state(std::string_view cookies) {
  static constexpr std::array kNames{"nothing", "look", "change"};
  const May allowed = may(cookies);
  Json set = Json::array();
  for (const Role role : {Role::kAdmin, Role::kViewer}) {
    if (passwords_.has(role)) set.push_back(name_of(role));
  }
  return {{"may", kNames.at(static_cast<std::size_t>(allowed))},
          {"signed_in", session_role(cookies).has_value()},
          {"passwords", std::move(set)}};
}

std::string Access::sign_in(const std::string& password, const std::string& address) {
  return open_session(check(password, address), address);
}

std::string Access::sign_out(std::string_view cookies) {
  const std::lock_guard lock(mutex_);
  sessions_.erase(token_in(cookies));
  return fmt::format("{}=; HttpOnly; SameSite=Strict; Path=/; Max-Age=0", cookie_);
}

std::string Access::set_password(Role role, const std::optional<std::string>& password,
                                 const std::string& admin_password, const std::string& address) {
  if (!password && role == Role::kAdmin)
    throw HttpError(409,
                    "the admin's password can be changed here, but not removed; to remove it, run: "
                    "ssl-visionctl passwd --remove");
  if (passwords_.has(Role::kAdmin) && check(admin_password, address) != Role::kAdmin)
    throw HttpError(401, "current_password: this is not the admin's password");
  passwords_.set(role, password);
  if (role == Role::kAdmin) {
    const std::lock_guard lock(mutex_);
    remember(role, address);
  }
  log::info("the {}'s password was {} by {}", name_of(role), password ? "set" : "removed", address);
  return open_session(Role::kAdmin, address);
}

bool Access::is_trusted(const std::string& address) {
  const std::lock_guard lock(mutex_);
  const Circle circle = circle_of(address);
  return circle == Circle::kAdmins || circle == Circle::kThisComputer;
}

Role Access::check(const std::string& password, const std::string& address) {
  passwords_.reload_if_changed();
  if (!passwords_.has(Role::kAdmin)) throw HttpError(409, "no password is set: everything is allowed");
  std::string key;
  {
    const std::lock_guard lock(mutex_);
    const Circle circle = circle_of(address);
    // Other people in an admin's IPv6 network must not use up the admin's tries.
    key = circle == Circle::kAdmins ? "admin " + address : network_of(address);
    take_try(circle, key);
  }
  const auto role = passwords_.role_of(password);
  if (!role) {
    log::warning("audit: {} gave a wrong password", address);
    throw HttpError(401, "wrong password");
  }
  const std::lock_guard lock(mutex_);
  if (*role == Role::kAdmin) {
    tries_.erase(key);
  } else if (const auto own = tries_.find(key); own != tries_.end()) {
    own->second.left += 1;  // restores only this try: a viewer may be guessing the admin's password
  }
  remember(*role, address);
  return *role;
}

Access::Circle Access::circle_of(const std::string& address) const {
  if (is_own_computer(address)) return Circle::kThisComputer;
  const auto found = known_.find(address);
  if (found == known_.end()) return Circle::kStrangers;
  const Known& known = found->second;
  if (now_s_() - known.at_s > kLongest_s || known.hash != passwords_.hash(known.role))
    return Circle::kStrangers;
  return known.role == Role::kAdmin ? Circle::kAdmins : Circle::kViewers;
}

void Access::take_try(Circle circle, const std::string& key) {
  const double now_s = now_s_();
  if (tries_.size() >= kMaxAddresses && !tries_.contains(key)) {
    const auto oldest = std::min_element(tries_.begin(), tries_.end(), [](const auto& a, const auto& b) {
      return a.second.at_s < b.second.at_s;
    });
    tries_.erase(oldest);
  }
  Tries& own = tries_.try_emplace(key, Tries{kMaxTries, now_s}).first->second;
  if (!own.take(now_s, kMaxTries, kTryBack_s)) throw TooManyTries(own.wait_s(kTryBack_s));
  Tries& common = circle_tries_.at(static_cast<std::size_t>(circle));
  if (!common.take(now_s, kMaxTriesOfCircle, kTryOfCircleBack_s)) {
    own.left += 1;  // no password was checked
    throw TooManyTries(common.wait_s(kTryOfCircleBack_s));
  }
}

void Access::remember(Role role, const std::string& address) {
  if (role == Role::kViewer && circle_of(address) == Circle::kAdmins) return;
  const auto has_role = [&](const auto& entry) { return entry.second.role == role; };
  known_.erase(address);
  if (std::count_if(known_.begin(), known_.end(), has_role) >= static_cast<std::ptrdiff_t>(kMaxKnown)) {
    // Each role has its own limit: everybody may know the viewers' password.
    auto oldest = known_.end();
    for (auto entry = known_.begin(); entry != known_.end(); ++entry) {
      if (has_role(*entry) && (oldest == known_.end() || entry->second.at_s < oldest->second.at_s))
        oldest = entry;
    }
    known_.erase(oldest);
  }
  known_[address] = {role, passwords_.hash(role), now_s_()};
}

void Access::make_room_for_session(Role role) {
  std::erase_if(sessions_, [&](const auto& one) { return is_over(one.second); });
  std::map<std::string, std::size_t> of_network, of_subnet;
  std::size_t all = 0;
  for (const auto& [token, session] : sessions_) {
    if (session.role != role) continue;
    ++of_network[session.network];
    ++of_subnet[subnet_of(session.network)];
    ++all;
  }
  if (all < kMaxSessions) return;
  const double now_s = now_s_();
  const auto rank = [&](const Session& session) {  // the session with the highest rank ends
    const double idle_s = now_s - session.used_s;
    return std::tuple(idle_s > kPresent_s, of_subnet[subnet_of(session.network)], of_network[session.network],
                      idle_s);
  };
  auto leaves = sessions_.end();
  for (auto one = sessions_.begin(); one != sessions_.end(); ++one) {
    if (one->second.role != role) continue;
    if (leaves == sessions_.end() || rank(one->second) > rank(leaves->second)) leaves = one;
  }
  sessions_.erase(leaves);
}

bool Access::is_over(const Session& session) const {
  const double now_s = now_s_();
  return now_s - session.used_s > kIdle_s || now_s - session.opened_s > kLongest_s ||
         session.hash != passwords_.hash(session.role);
}

std::string Access::open_session(Role role, const std::string& address) {
  const std::string token = random_token();
  const double now_s = now_s_();
  const std::lock_guard lock(mutex_);
  make_room_for_session(role);
  sessions_[token] = {role, passwords_.hash(role), network_of(address), now_s, now_s};
  return fmt::format("{}={}; HttpOnly; SameSite=Strict; Path=/; Max-Age={:.0f}", cookie_, token, kLongest_s);
}

std::string Access::token_in(std::string_view cookies) const {
  while (!cookies.empty()) {
    const std::string_view one = cookies.substr(0, cookies.find(';'));
    cookies.remove_prefix(std::min(cookies.size(), one.size() + 1));
    const std::string_view bare = one.substr(std::min(one.size(), one.find_first_not_of(' ')));
    if (bare.size() > cookie_.size() && bare.starts_with(cookie_) && bare[cookie_.size()] == '=')
      return std::string(bare.substr(cookie_.size() + 1));
  }
  return {};
}

std::optional<Role> Access::session_role(std::string_view cookies) {
  const std::string token = token_in(cookies);
  if (token.empty()) return std::nullopt;
  const std::lock_guard lock(mutex_);
  const auto found = sessions_.find(token);
  if (found == sessions_.end()) return std::nullopt;
  if (is_over(found->second)) {
    sessions_.erase(found);
    return std::nullopt;
  }
  found->second.used_s = now_s_();
  return found->second.role;
}

}  // namespace sslv
