// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/seqlock.h"
#include "kit/apart/channel.h"
#include "kit/apart/start_process.h"

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>

namespace sslv::apart {

/// One stage of one stack, in a process of its own: what its Step on a camera's thread and the supervisor's
/// thread share. Neither ever waits for the other.
struct StageProcess {
  StageProcess(std::string stage_name, std::string library_file, std::string floor_name,
               std::string the_contract);

  const std::string stage, library, floor, contract;
  Channel channel;
  /// Messages with files to the process, and the word from it that it is ready. Both ends stay while
  /// processes come and go.
  FilePair control;

  /// 0: there is no process that answers. Else another number for each that was ready.
  std::atomic<std::uint32_t> generation{0};

  // Told by the Step.
  std::atomic<std::uint32_t> failures_in_a_row{0};
  std::atomic<std::int64_t> asked_ns{0};  // steady_ns() of the newest request
  std::atomic<bool> is_wanted{true};      // until the Step is gone

  /// Told by the supervisor: how often a process was lost, and how the last one went, as a text.
  struct Losses {
    std::uint32_t count = 0;
    std::uint8_t length = 0;
    std::array<char, 100> text{};
  };
  Seqlock<Losses> losses;
};

/// Starts processes of stages, looks after them and starts them again: one thread, which is no camera's.
class Supervisor {
 public:
  struct Options {
    /// A process that is lost the first time is started again at once, then after these times, which double.
    std::chrono::milliseconds first_pause{100}, longest_pause{5000};
    /// After so long without a loss, the next one counts as the first.
    std::chrono::milliseconds forgets_losses{10'000};
    /// For the library to load and the stage to be made, or to check its parameters.
    std::chrono::milliseconds starts_within{5000};
    /// What all calls of start() may wait together; time that goes by without waiting comes back.
    std::chrono::milliseconds longest_wait{5000};
    /// A process that leaves a request so long, or fails so often one after the other, is ended.
    std::chrono::milliseconds longest_silence{1000};
    std::uint32_t most_failures_in_a_row = 100;
    /// An image waits at least this long for its stage, whatever deadline the stage has.
    std::chrono::milliseconds min_deadline{0};
  };

  Supervisor() : Supervisor(Options{}) {}
  /// Throws std::system_error.
  explicit Supervisor(const Options& options);
  /// Ends all processes. Steps may still be there: their frames go on without them.
  ~Supervisor();
  Supervisor(const Supervisor&) = delete;
  Supervisor& operator=(const Supervisor&) = delete;

  /// Starts the stage and waits until it is ready, has ended or takes too long; in the last two cases it is
  /// started again later. Does not wait for a library of which a stage was too slow and none has been ready
  /// since. `contract`: contract_of() its row. For threads that may wait. Throws std::runtime_error with what
  /// the stage's constructor threw, and std::system_error.
  std::shared_ptr<StageProcess> start(const std::string& stage, const std::string& library,
                                      const std::string& floor, const std::string& contract);

  /// From now on calls of start() wait no longer than this together, if that is less than the option says.
  void wait_at_most(std::chrono::milliseconds together);

  /// Nobody waits for a start any more: start() throws, now and later. Processes that run go on.
  void ask_to_stop();
  /// Told by that.
  std::stop_token stop() const { return stop_.get_token(); }

  const Options& options() const { return options_; }

 private:
  struct Impl;
  const Options options_;
  std::stop_source stop_;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sslv::apart
