// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "net/multicast.h"
#include "ssl_gc_referee_message.pb.h"
#include "support/group_listener.h"

#include <chrono>
#include <stop_token>
#include <string>
#include <thread>

namespace sslv::test {

/// A game controller that repeats its message, as real ones do: the service unlocks the settings when it is
/// silent.
class RepeatedReferee {
 public:
  static constexpr int kFirstHalf = 1, kHalt = 0, kForceStart = 3;

  explicit RepeatedReferee(const GroupListener& group) : sender_(settings_for(group)) {}

  void say(int stage, int command) {
    Referee referee;
    referee.mutable_yellow()->set_name("");
    referee.mutable_blue()->set_name("");
    referee.set_stage(stage);
    referee.set_command(command);
    thread_ = std::jthread([this, message = referee.SerializeAsString()](const std::stop_token& stop) {
      for (; !stop.stop_requested(); std::this_thread::sleep_for(std::chrono::milliseconds(100)))
        send(sender_, message);
    });
  }

 private:
  MulticastSender sender_;
  std::jthread thread_;  // last: ends before the members it uses are destroyed
};

}  // namespace sslv::test
