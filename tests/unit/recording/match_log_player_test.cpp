// SPDX-License-Identifier: Apache-2.0
#include "recording/match_log_player.h"

#include "lab/match_log.h"
#include "recording/match_log_writer.h"
#include "ssl_gc_referee_message.pb.h"
#include "support/temporary_folder.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <unistd.h>

namespace sslv::match_log_player_test {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Optional;

constexpr std::int64_t kBegin_ns = 1'800'000'000'000'000'000;

/// A log of 100 s: an image every second, goals at 20.5 s and 60.5 s.
class PlayerTest : public ::testing::Test {
 protected:
  PlayerTest() {
    MatchLogWriter writer(file());
    const auto add = [&](double at_s, std::int32_t type, const std::string& text) {
      std::vector<std::byte> bytes(text.size());
      std::ranges::transform(text, bytes.begin(), [](char c) { return std::byte(c); });
      writer.add(kBegin_ns + static_cast<std::int64_t>(at_s * 1e9), type, bytes);
    };
    for (int i = 0; i <= 100; ++i) {
      add(i, LoggedMessage::kVision2014, std::to_string(i));
      Referee referee;
      referee.mutable_yellow()->set_score(i >= 60 ? 2 : i >= 20 ? 1 : 0);
      referee.mutable_blue()->set_score(0);
      add(i + 0.5, LoggedMessage::kReferee, referee.SerializeAsString());
    }
    writer.finish();
  }

  std::filesystem::path file() const { return folder_.path() / "match.log.gz"; }
  MatchLogPlayer::Send send() {
    return [this](const LoggedMessage& message) {
      if (message.type == LoggedMessage::kVision2014)
        images_.push_back(std::stoi(
            std::string(reinterpret_cast<const char*>(message.bytes.data()), message.bytes.size())));
    };
  }
  std::vector<int> take() { return std::exchange(images_, {}); }

  test::TemporaryFolder folder_;
  std::vector<int> images_;
};

TEST_F(PlayerTest, GivesMessagesAsFarApartAsTheyCame) {
  MatchLogPlayer player(file());
  EXPECT_DOUBLE_EQ(player.length_s(), 100.5);
  EXPECT_THAT(player.play(1000, send()), Optional(DoubleNear(0.5, 1e-6)));
  EXPECT_THAT(take(), ElementsAre(0));
  EXPECT_THAT(player.play(1000.9, send()), Optional(DoubleNear(0.1, 1e-6)));
  EXPECT_THAT(take(), IsEmpty());
  EXPECT_THAT(player.play(1003.1, send()), Optional(DoubleNear(0.4, 1e-6)));
  EXPECT_THAT(take(), ElementsAre(1, 2, 3));
  EXPECT_NEAR(player.at_s(), 3.1, 1e-6);
}

TEST_F(PlayerTest, PlaysFasterAndSlower) {
  MatchLogPlayer player(file());
  player.set_speed(1000);
  EXPECT_EQ(player.speed(), MatchLogPlayer::kMaxSpeed);
  player.play(0, send());
  player.play(1, send());
  EXPECT_NEAR(player.at_s(), 16, 1e-6);
  player.set_speed(0.1);
  player.play(11, send());
  EXPECT_NEAR(player.at_s(), 17, 1e-6);
}

TEST_F(PlayerTest, GoesToAnyTimeAndEnds) {
  MatchLogPlayer player(file());
  player.go_to(50.2);
  player.play(0, send());
  EXPECT_THAT(player.play(1, send()), Optional(DoubleNear(0.3, 1e-6)));
  EXPECT_THAT(take(), ElementsAre(51));
  player.go_to(1e9);
  EXPECT_EQ(player.play(2, send()), std::nullopt);
  EXPECT_TRUE(player.is_at_end());
  EXPECT_EQ(player.problem(), "");
  player.go_to(-5);
  EXPECT_FALSE(player.is_at_end());
  player.play(3, send());
  EXPECT_THAT(take(), ElementsAre(0));
}

TEST_F(PlayerTest, PausesAndSteps) {
  MatchLogPlayer player(file());
  player.play(0, send());
  player.pause(true);
  EXPECT_EQ(player.play(50, send()), std::nullopt);
  EXPECT_THAT(take(), ElementsAre(0));
  EXPECT_TRUE(player.step(send()));
  EXPECT_TRUE(player.step(send()));
  EXPECT_THAT(take(), ElementsAre(1, 2));
  player.pause(false);
  player.play(100, send());
  player.play(101, send());
  EXPECT_THAT(take(), ElementsAre(3)) << "the time of the pause is not made up for";
}

TEST_F(PlayerTest, JumpsToEvents) {
  MatchLogPlayer player(file());
  EXPECT_FALSE(player.jump(MatchEvent::Kind::kGoal, false));
  EXPECT_TRUE(player.jump(MatchEvent::Kind::kGoal, true));
  EXPECT_NEAR(player.at_s(), 20.5 - 2, 1e-6);
  EXPECT_TRUE(player.jump(MatchEvent::Kind::kGoal, true));
  EXPECT_NEAR(player.at_s(), 60.5 - 2, 1e-6);
  EXPECT_FALSE(player.jump(MatchEvent::Kind::kGoal, true)) << "there is none after it";
  EXPECT_TRUE(player.jump(MatchEvent::Kind::kGoal, false));
  EXPECT_NEAR(player.at_s(), 20.5 - 2, 1e-6);
  player.play(0, send());
  player.play(10, send());  // past the event
  EXPECT_TRUE(player.jump(MatchEvent::Kind::kGoal, false));
  EXPECT_NEAR(player.at_s(), 20.5 - 2, 1e-6) << "the same again";
  EXPECT_FALSE(player.jump(MatchEvent::Kind::kKick, true));
}

TEST_F(PlayerTest, CutsLongGaps) {
  MatchLogPlayer player(file());
  player.set_longest_gap(0.1);
  player.play(0, send());
  EXPECT_THAT(player.play(1.05, send()), Optional(DoubleNear(0.05, 1e-6)));
  EXPECT_THAT(take(), ElementsAre(0, 1, 2, 3, 4, 5));
}

TEST(PlayKeys, AreWhatTerminalsSend) {
  std::string typed = "g\x1b[Cx\x1b[A q";
  std::vector<PlayKey> keys;
  while (!typed.empty()) keys.push_back(take_key(typed));
  EXPECT_THAT(keys, ElementsAre(PlayKey::kNextGoal, PlayKey::kOn, PlayKey::kNone, PlayKey::kFaster,
                                PlayKey::kPause, PlayKey::kEnd));
  EXPECT_EQ(take_key(typed), PlayKey::kNone);
}

/// A pipe in place of a terminal.
class TypedKeys : public testing::Test {
 protected:
  TypedKeys() { EXPECT_EQ(::pipe(pipe_), 0); }
  ~TypedKeys() override {
    ::close(pipe_[0]);
    if (pipe_[1] >= 0) ::close(pipe_[1]);
  }
  void type(std::string_view bytes) {
    ASSERT_EQ(::write(pipe_[1], bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }
  void hang_up() { ::close(std::exchange(pipe_[1], -1)); }

  static constexpr double kForEver_s = 1e6;
  int pipe_[2];
};

TEST_F(TypedKeys, AnArrowMayComeInPieces) {
  KeyReader keys(pipe_[0], kForEver_s);
  EXPECT_EQ(keys.next(0), PlayKey::kNone) << "nothing was typed";
  for (const char* piece : {"\x1b", "["}) {
    type(piece);
    EXPECT_EQ(keys.next(1), PlayKey::kNone);
    EXPECT_EQ(keys.next(0), PlayKey::kNone) << "nothing came meanwhile";
  }
  type("C");
  EXPECT_EQ(keys.next(1), PlayKey::kOn);
  type("g\x1b");
  EXPECT_EQ(keys.next(1), PlayKey::kNextGoal);
  EXPECT_EQ(keys.next(0), PlayKey::kNone);
  type("[D ");
  EXPECT_EQ(keys.next(1), PlayKey::kBack);
  EXPECT_EQ(keys.next(0), PlayKey::kPause);
}

TEST_F(TypedKeys, EscapeAloneDoesNothing) {
  KeyReader keys(pipe_[0], 0);
  type("\x1b");
  EXPECT_EQ(keys.next(1), PlayKey::kNone);
  type("g");
  EXPECT_EQ(keys.next(1), PlayKey::kNextGoal);
  KeyReader patient(pipe_[0], kForEver_s);
  type("\x1b");
  EXPECT_EQ(patient.next(1), PlayKey::kNone);
  type("q");
  EXPECT_EQ(patient.next(1), PlayKey::kNone) << "that was Escape";
  EXPECT_EQ(patient.next(0), PlayKey::kEnd);
}

TEST_F(TypedKeys, EndWithTheTerminal) {
  KeyReader keys(pipe_[0]);
  hang_up();
  EXPECT_EQ(keys.next(kForEver_s), PlayKey::kEnd);
}

}  // namespace
}  // namespace sslv::match_log_player_test
