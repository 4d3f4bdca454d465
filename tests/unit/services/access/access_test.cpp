// SPDX-License-Identifier: Apache-2.0
#include "services/access/access.h"

#include "base/json.h"
#include "support/temporary_folder.h"

#include <fstream>
#include <string>
#include <vector>

#include <crypt.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sslv::access_test {
namespace {

using testing::HasSubstr;

class AccessTest : public testing::Test {
 protected:
  int refused(const auto& act) const {
    try {
      act();
    } catch (const HttpError& error) {
      return error.status;
    }
    return 0;
  }
  /// The part of a Set-Cookie header that a browser sends back.
  static std::string cookie(const std::string& set_cookie) {
    return set_cookie.substr(0, set_cookie.find(';'));
  }
  /// Sets passwords with hashes that crypt(3) computes quickly, for tests with thousands of sign-ins.
  void set_cheaply(const std::string& admin, const std::string& viewer) {
    const auto hash = [](const std::string& password) {
      return std::string(::crypt(password.c_str(), "$6$rounds=1000$salt$"));
    };
    std::ofstream(folder_.path() / Passwords::kFileName)
        << Json{{"admin", hash(admin)}, {"viewer", hash(viewer)}};
    passwords_.reload_if_changed();
  }
  std::string sign_in(const std::string& password) { return cookie(access_.sign_in(password, "192.0.2.1")); }

  const test::TemporaryFolder folder_;
  Passwords passwords_{folder_.path() / Passwords::kFileName};
  double now_s_ = 1000;
  Access access_{passwords_, "session", [this] { return now_s_; }};
};

TEST_F(AccessTest, WithoutAPasswordEverybodyMayChangeAll) {
  EXPECT_EQ(access_.may(""), May::kChange);
  EXPECT_EQ(refused([&] { access_.sign_in("whatever it is", "192.0.2.1"); }), 409);
  EXPECT_EQ(access_.state("").dump(), R"({"may":"change","signed_in":false,"passwords":[]})");
}

TEST_F(AccessTest, WithAnAdminsPasswordOthersMayLook) {
  passwords_.set(Role::kAdmin, "correct horse");
  EXPECT_EQ(access_.may(""), May::kLook);
  EXPECT_EQ(access_.may("session=0123"), May::kLook);
  EXPECT_EQ(access_.may(sign_in("correct horse")), May::kChange);
}

TEST_F(AccessTest, WithAViewersPasswordOthersMayDoNothing) {
  passwords_.set(Role::kAdmin, "correct horse");
  passwords_.set(Role::kViewer, "battery staple");
  EXPECT_EQ(access_.may(""), May::kNothing);
  EXPECT_EQ(access_.may(sign_in("battery staple")), May::kLook);
  EXPECT_EQ(access_.may(sign_in("correct horse")), May::kChange);
}

TEST_F(AccessTest, CookiesAreLongAndForThisServerAlone) {
  passwords_.set(Role::kAdmin, "correct horse");
  const std::string one = access_.sign_in("correct horse", "192.0.2.1");
  EXPECT_THAT(one,
              testing::MatchesRegex("session=[0-9a-f]+; HttpOnly; SameSite=Strict; Path=/; Max-Age=604800"));
  EXPECT_EQ(cookie(one).size(), std::string("session=").size() + 64);
  EXPECT_NE(one, access_.sign_in("correct horse", "192.0.2.1"));
  EXPECT_EQ(access_.may("a=b; " + cookie(one) + "; c=d"), May::kChange);
  for (const std::string& wrong : std::vector<std::string>{
           "session=", "session", "=", ";", "xsession" + cookie(one).substr(7), cookie(one) + "0"})
    EXPECT_EQ(access_.may(wrong), May::kLook) << wrong;
}

TEST_F(AccessTest, SigningOutEndsTheSession) {
  passwords_.set(Role::kAdmin, "correct horse");
  const std::string session = sign_in("correct horse"), other = sign_in("correct horse");
  EXPECT_THAT(access_.sign_out(session), HasSubstr("Max-Age=0"));
  EXPECT_EQ(access_.may(session), May::kLook);
  EXPECT_EQ(access_.may(other), May::kChange);
}

TEST_F(AccessTest, SessionsEndWhenIdleAndAfterTheirMaximumAge) {
  passwords_.set(Role::kAdmin, "correct horse");
  const std::string idle = sign_in("correct horse"), used = sign_in("correct horse");
  for (int hours = 0; hours < 7 * 24; hours += 12) {
    EXPECT_EQ(access_.may(used), May::kChange) << hours;
    now_s_ += 12 * 3600.0;
  }
  EXPECT_EQ(access_.may(idle), May::kLook);
  now_s_ += 1;
  EXPECT_EQ(access_.may(used), May::kLook);
}

TEST_F(AccessTest, ManySessionsOfViewersEndNeitherAnAdminsNorOtherViewers) {
  set_cheaply("correct horse", "battery staple");
  const std::string admin = sign_in("correct horse");
  const std::string viewer = cookie(access_.sign_in("battery staple", "192.0.2.2"));
  std::vector<std::string> many;
  for (std::size_t i = 0; i < 2 * Access::kMaxSessions; ++i) {
    now_s_ += 60;  // attempts are allowed again; the first session is idle for longest
    many.push_back(cookie(access_.sign_in("battery staple", "198.51.100." + std::to_string(i % 2))));
  }
  EXPECT_EQ(access_.may(admin), May::kChange);
  EXPECT_EQ(access_.may(viewer), May::kLook);
  EXPECT_EQ(access_.may(many.front()), May::kNothing);
  EXPECT_EQ(access_.may(many.back()), May::kLook);
  int left = 0;
  for (const std::string& one : many) left += access_.may(one) == May::kLook ? 1 : 0;
  EXPECT_EQ(left + 1, static_cast<int>(Access::kMaxSessions));
}

TEST_F(AccessTest, ManyAddressesEndNoSessionOfAnOpenPanel) {
  set_cheaply("correct horse", "battery staple");
  std::vector<std::string> users, many;
  const auto open = [&](const std::string& address) {
    now_s_ += 2;  // attempts are allowed again
    for (const std::string& one : users) EXPECT_EQ(access_.may(one), May::kLook) << address;
    return cookie(access_.sign_in("battery staple", address));
  };
  for (int i = 0; i < 5; ++i) users.push_back(open("198.51.100.1"));  // all behind one address, as with a NAT
  for (std::size_t i = 0; i <= Access::kMaxSessions; ++i)
    many.push_back(open((i < 128 ? "198.51.100." : "198.51.101.") + std::to_string(2 + i % 128)));
  EXPECT_EQ(access_.may(many.front()), May::kNothing);
  // The same number of addresses of one computer, whose sessions are all in use.
  users = {open("192.0.2.1"), open("192.0.2.1")};
  many.clear();
  for (std::size_t i = 0; i <= Access::kMaxSessions; ++i) {
    for (const std::string& one : many) access_.may(one);
    many.push_back(open("203.0.113." + std::to_string(i % 250)));
  }
  EXPECT_EQ(access_.may(many.back()), May::kLook);
}

TEST_F(AccessTest, AnotherPasswordEndsTheSessionsOfThatRole) {
  passwords_.set(Role::kAdmin, "correct horse");
  passwords_.set(Role::kViewer, "battery staple");
  const std::string admin = sign_in("correct horse"), viewer = sign_in("battery staple");
  // Another program (ssl-visionctl) changes the password.
  Passwords(folder_.path() / Passwords::kFileName).set(Role::kViewer, "another staple");
  passwords_.reload_if_changed();  // as the service does once a second
  EXPECT_EQ(access_.may(viewer), May::kNothing);
  EXPECT_EQ(access_.may(admin), May::kChange);
  const std::string changed =
      access_.set_password(Role::kAdmin, "another horse", "correct horse", "192.0.2.1");
  EXPECT_EQ(access_.may(admin), May::kNothing);
  EXPECT_EQ(access_.may(cookie(changed)), May::kChange) << "who changed it stays signed in";
}

TEST_F(AccessTest, SettingAPasswordNeedsTheAdmins) {
  const std::string first = access_.set_password(Role::kAdmin, "correct horse", "", "192.0.2.1");
  EXPECT_EQ(access_.may(cookie(first)), May::kChange);
  EXPECT_EQ(refused([&] { access_.set_password(Role::kAdmin, "another horse", "", "192.0.2.1"); }), 401);
  EXPECT_EQ(refused([&] { access_.set_password(Role::kAdmin, std::nullopt, "correct horse", "192.0.2.1"); }),
            409);
  access_.set_password(Role::kViewer, "battery staple", "correct horse", "192.0.2.1");
  EXPECT_EQ(
      refused([&] { access_.set_password(Role::kAdmin, "another horse", "battery staple", "192.0.2.1"); }),
      401);
  access_.set_password(Role::kViewer, std::nullopt, "correct horse", "192.0.2.1");
  EXPECT_EQ(access_.may(""), May::kLook);
}

TEST_F(AccessTest, WrongPasswordsCostTime) {
  passwords_.set(Role::kAdmin, "correct horse");
  const auto try_once = [&](const std::string& address) {
    return refused([&] { access_.sign_in("wrong horse", address); });
  };
  for (int i = 0; i < 5; ++i) EXPECT_EQ(try_once("192.0.2.1"), 401) << i;
  EXPECT_EQ(try_once("192.0.2.1"), 429);
  EXPECT_EQ(refused([&] { access_.sign_in("correct horse", "192.0.2.1"); }), 429) << "not even the right one";
  EXPECT_EQ(try_once("192.0.2.2"), 401) << "another address";
  now_s_ += 10;
  EXPECT_EQ(try_once("192.0.2.1"), 401);
  try {
    access_.sign_in("wrong horse", "192.0.2.1");
    FAIL();
  } catch (const TooManyTries& error) {
    EXPECT_EQ(error.wait_s, 10);
    EXPECT_STREQ(error.what(), "too many wrong passwords; try again in 10 s");
  }
}

TEST_F(AccessTest, ACorrectPasswordResetsTheAttempts) {
  passwords_.set(Role::kAdmin, "correct horse");
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(refused([&] { access_.sign_in("wrong horse", "192.0.2.1"); }), 401) << i;
    now_s_ += 2;
    sign_in("correct horse");
  }
}

TEST_F(AccessTest, AttemptsOfAllAddressesTogetherAreLimited) {
  passwords_.set(Role::kAdmin, "correct horse");
  int tried = 0;
  while (refused([&] { access_.sign_in("wrong horse", "192.0.2." + std::to_string(tried)); }) == 401) ++tried;
  EXPECT_EQ(tried, 20);
}

TEST_F(AccessTest, TheViewersPasswordDoesNotHelpToGuessTheAdmins) {
  passwords_.set(Role::kAdmin, "correct horse");
  passwords_.set(Role::kViewer, "battery staple");
  int guesses = 0;
  for (int second = 0; second < 40; ++second) {
    while (refused([&] { access_.sign_in("wrong horse", "192.0.2.1"); }) == 401) ++guesses;
    refused([&] { access_.sign_in("battery staple", "192.0.2.1"); });
    now_s_ += 1;
  }
  EXPECT_LE(guesses, 9);
}

TEST_F(AccessTest, ACorrectViewersPasswordCostsNoAttempt) {
  passwords_.set(Role::kAdmin, "correct horse");
  passwords_.set(Role::kViewer, "battery staple");
  for (int i = 0; i < 10; ++i) EXPECT_EQ(refused([&] { sign_in("battery staple"); }), 0) << i;
}

TEST_F(AccessTest, ManyGuessersDoNotLockOutTheAdmin) {
  passwords_.set(Role::kAdmin, "correct horse");
  sign_in("correct horse");
  const auto everybody_guesses = [&] {
    for (int i = 0; i < 250; ++i)
      refused([&] { access_.sign_in("wrong horse", "198.51.100." + std::to_string(i)); });
  };
  for (int second = 0; second < 20; ++second) {
    everybody_guesses();
    EXPECT_EQ(refused([&] { access_.sign_in("correct horse", "203.0.113.1"); }), 429) << "a stranger";
    EXPECT_EQ(refused([&] { access_.sign_in("correct horse", "127.0.0.1"); }), 0) << second;
    EXPECT_EQ(refused([&] { access_.sign_in("correct horse", "::1"); }), 0) << second;
    EXPECT_EQ(refused([&] { sign_in("correct horse"); }), 0) << "signed in before, " << second;
    now_s_ += 3;
  }
}

TEST_F(AccessTest, ManyWhoKnowTheViewersPasswordDoNotLockOutTheAdmin) {
  set_cheaply("correct horse", "battery staple");
  sign_in("correct horse");
  for (int i = 0; i < 260; ++i) {
    access_.sign_in("battery staple", "198.51.100." + std::to_string(i));
    now_s_ += 1;
  }
  for (int i = 0; i < 260; ++i)
    refused([&] { access_.sign_in("wrong horse", "198.51.100." + std::to_string(i)); });
  EXPECT_EQ(refused([&] { sign_in("correct horse"); }), 0);
}

TEST_F(AccessTest, OthersInTheAdminsNetworkDoNotLockOutTheAdmin) {
  passwords_.set(Role::kAdmin, "correct horse");
  access_.sign_in("correct horse", "2001:db8::1");
  for (int i = 0; i < 10; ++i)
    refused([&] { access_.sign_in("wrong horse", "2001:db8::bad:" + std::to_string(i)); });
  EXPECT_EQ(refused([&] { access_.sign_in("correct horse", "2001:db8::2"); }), 429);
  EXPECT_EQ(refused([&] { access_.sign_in("correct horse", "2001:db8::1"); }), 0);
}

TEST_F(AccessTest, TrustsThisComputerAndTheAdminsAddresses) {
  const auto trusts = [&](const char* address) { return access_.is_trusted(address); };
  EXPECT_TRUE(trusts("127.0.0.1"));
  EXPECT_TRUE(trusts("127.1.2.3"));
  EXPECT_TRUE(trusts("::1"));
  EXPECT_TRUE(trusts("::ffff:127.0.0.1"));
  for (const char* address : {"192.0.2.1", "::ffff:192.0.2.1", "::2", "nonsense", ""})
    EXPECT_FALSE(trusts(address)) << address;

  passwords_.set(Role::kAdmin, "correct horse");
  passwords_.set(Role::kViewer, "battery staple");
  access_.sign_in("battery staple", "192.0.2.1");
  EXPECT_FALSE(trusts("192.0.2.1"));
  access_.sign_in("correct horse", "192.0.2.1");
  EXPECT_TRUE(trusts("192.0.2.1"));
  access_.sign_in("battery staple", "192.0.2.1");
  EXPECT_TRUE(trusts("192.0.2.1"));
  now_s_ += Access::kLongest_s + 1;
  EXPECT_FALSE(trusts("192.0.2.1"));

  access_.sign_in("correct horse", "192.0.2.1");
  access_.set_password(Role::kAdmin, "another horse", "correct horse", "192.0.2.2");
  EXPECT_FALSE(trusts("192.0.2.1")) << "the password was changed";
  EXPECT_TRUE(trusts("192.0.2.2"));
}

}  // namespace
}  // namespace sslv::access_test
