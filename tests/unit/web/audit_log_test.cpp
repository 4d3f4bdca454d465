// SPDX-License-Identifier: Apache-2.0
#include "web/audit_log.h"

#include "base/log.h"

#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::audit_log_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

class AuditLogTest : public testing::Test {
 protected:
  /// Log lines since the last call.
  std::vector<std::string> lines() {
    const auto fresh = log::recent().newer_than(seen_, log::Level::kInfo);
    seen_ = fresh.newest;
    std::vector<std::string> out;
    for (const auto& line : fresh.lines) out.push_back(line.text);
    return out;
  }
  void refuse(const std::string& address, int times = 1, int status = 401) {
    for (int i = 0; i < times; ++i) audit_->add(address, "PATCH", "/api/settings", status);
  }

  std::uint64_t seen_ = log::recent().newer_than(0, log::Level::kInfo).newest;
  double now_s_ = 1000;
  std::optional<AuditLog> audit_{std::in_place, [this] { return now_s_; }};
};

TEST_F(AuditLogTest, EveryChangeHasALine) {
  for (int i = 0; i < 3; ++i) audit_->add("192.0.2.7", "PATCH", "/api/settings", 200);
  EXPECT_THAT(lines(), ElementsAre("audit: 192.0.2.7 PATCH \"/api/settings\" 200",
                                   "audit: 192.0.2.7 PATCH \"/api/settings\" 200",
                                   "audit: 192.0.2.7 PATCH \"/api/settings\" 200"));
}

TEST_F(AuditLogTest, RefusalsAreWrittenOnceAndThenCounted) {
  refuse("192.0.2.7", 100'000);
  refuse("192.0.2.7", 50'000, 404);
  refuse("192.0.2.8");
  EXPECT_THAT(lines(), ElementsAre("audit: 192.0.2.7 PATCH \"/api/settings\" 401",
                                   "audit: 192.0.2.8 PATCH \"/api/settings\" 401"));
  now_s_ += 59;
  audit_->write_due();
  EXPECT_THAT(lines(), IsEmpty());
  now_s_ += 1;
  audit_->write_due();
  EXPECT_THAT(lines(),
              ElementsAre("audit: 192.0.2.7: 149999 more requests were refused in 60 s: 401 x 99999, 404 x "
                          "50000; the last: PATCH \"/api/settings\" 404"));
  refuse("192.0.2.7");
  EXPECT_THAT(lines(), IsEmpty()) << "it goes on";
  now_s_ += 60;
  audit_->write_due();
  EXPECT_THAT(lines(), SizeIs(1));
  now_s_ += 60;
  refuse("192.0.2.7");
  EXPECT_THAT(lines(), ElementsAre("audit: 192.0.2.7 PATCH \"/api/settings\" 401")) << "a first one again";
}

TEST_F(AuditLogTest, RepeatedSignOutsHaveOneLine) {
  for (int i = 0; i < 1000; ++i) audit_->add("192.0.2.7", "DELETE", "/api/session", 200);
  EXPECT_THAT(lines(), SizeIs(1));
}

TEST_F(AuditLogTest, ManyAddressesAreCountedTogether) {
  for (int i = 0; i < 5000; ++i) refuse("198.51." + std::to_string(i / 250) + "." + std::to_string(i % 250));
  EXPECT_THAT(lines(), SizeIs(AuditLog::kMaxAddresses));
  for (int i = 0; i < 5000; ++i) refuse("2001:db8::" + std::to_string(i));
  now_s_ += 60;
  audit_->write_due();
  EXPECT_THAT(lines(),
              ElementsAre("audit: other addresses: 9936 more requests were refused in 60 s: 401 x 9936; the "
                          "last: PATCH \"/api/settings\" 401"));
  for (int i = 0; i < 5000; ++i) refuse("2001:db8::" + std::to_string(i));
  EXPECT_THAT(lines(), ElementsAre("audit: 2001:db8::0 PATCH \"/api/settings\" 401")) << "a network is one";
}

TEST_F(AuditLogTest, CountsAreLoggedAtTheEnd) {
  refuse("192.0.2.7", 3);
  lines();
  audit_.reset();
  EXPECT_THAT(lines(),
              ElementsAre("audit: 192.0.2.7: 2 more requests were refused in 0 s: 401 x 2; the last: "
                          "PATCH \"/api/settings\" 401"));
}

TEST_F(AuditLogTest, AnAddressIsShownAsText) {
  audit_->add("192.0.2.7", "PUT", std::string("/x\n\x1b\xe2\x80\xae") + std::string(1000, 'y'), 404);
  const auto written = lines();
  ASSERT_THAT(written, SizeIs(1));
  EXPECT_THAT(written[0], testing::StartsWith("audit: 192.0.2.7 PUT \"/x\\n\\u001b\\u202eyyy"));
  EXPECT_LT(written[0].size(), 300u);
}

}  // namespace
}  // namespace sslv::audit_log_test
