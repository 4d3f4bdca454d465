// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/seqlock.h"
#include "kit/sandbox/channel.h"
#include "kit/sandbox/start_process.h"

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>

namespace sslv::sandbox {

/// One stage of one stack in its own process: the state shared by its Step (on a camera's thread) and the
/// supervisor's thread. Neither thread ever waits for the other.
struct StageProcess {
  StageProcess(std::string stage_name, std::string library_file, std::string floor_name,
               std::string the_contract);

  const std::string stage, library, floor, contract;
  Channel channel;
  /// Carries messages with file descriptors to the process, and its report that it is ready. Both ends stay
  /// open when the process is replaced.
  FilePair control;

  /// 0: no process answers. Otherwise unique for each process that became ready.
  std::atomic<std::uint32_t> generation{0};

  // Written by the Step.
  std::atomic<std::uint32_t> failures_in_a_row{0};
  std::atomic<std::int64_t> asked_ns{0};  // steady_ns() of the newest request
  std::atomic<bool> is_wanted{true};      // false once the Step has been destroyed

  /// Written by the supervisor: the number of lost processes, and a text that describes the last loss.
  struct Losses {
    std::uint32_t count = 0;
    std::uint8_t length = 0;
    std::array<char, 100> text{};
  };
  Seqlock<Losses> losses;
};

/// Starts the stages' processes, supervises and restarts them, on its own thread.
class Supervisor {
 public:
  struct Options {
    /// Pauses before restarts. The first restart is immediate; then the pause doubles from first to longest.
    std::chrono::milliseconds first_pause{100}, longest_pause{5000};
    /// After this time without a loss, the next loss counts as the first.
    std::chrono::milliseconds forgets_losses{10'000};
    /// Time limit for loading the library and creating the stage, or for validating its parameters.
    std::chrono::milliseconds starts_within{5000};
    /// Total waiting time of all calls of start(). The budget refills with the time during which no call
    /// waits.
    std::chrono::milliseconds longest_wait{5000};
    /// A process is killed when it leaves a request unanswered for this long or fails this often in a row.
    std::chrono::milliseconds longest_silence{1000};
    std::uint32_t most_failures_in_a_row = 100;
    /// Lower bound of every stage's deadline.
    std::chrono::milliseconds min_deadline{0};
  };

  Supervisor() : Supervisor(Options{}) {}
  /// Throws std::system_error.
  explicit Supervisor(const Options& options);
  /// Ends all processes. Steps may outlive the supervisor; frames then continue without the stages' results.
  ~Supervisor();
  Supervisor(const Supervisor&) = delete;
  Supervisor& operator=(const Supervisor&) = delete;

  /// Starts the stage and waits until it is ready, has ended or takes too long; in the last two cases the
  /// stage is restarted later. After one stage of a library was too slow, does not wait for that library
  /// until one of its stages has been ready. `contract` is contract_of() the stage's row. May block. Throws
  /// std::runtime_error with the message of the stage's constructor, and std::system_error.
  std::shared_ptr<StageProcess> start(const std::string& stage, const std::string& library,
                                      const std::string& floor, const std::string& contract);

  /// Reduces the remaining waiting budget of start() to at most `together`.
  void wait_at_most(std::chrono::milliseconds together);

  /// Makes current and later calls of start() throw instead of waiting. Running processes continue.
  void ask_to_stop();
  /// A token for which ask_to_stop() requests the stop.
  std::stop_token stop() const { return stop_.get_token(); }

  const Options& options() const { return options_; }

 private:
  struct Impl;
  const Options options_;
  std::stop_source stop_;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sslv::sandbox
