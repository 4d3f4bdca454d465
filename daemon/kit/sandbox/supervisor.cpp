// SPDX-License-Identifier: Apache-2.0
#include "kit/sandbox/supervisor.h"

#include "base/clock.h"
#include "base/futex.h"
#include "base/log.h"
#include "base/plain_text.h"

#include <algorithm>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <ctime>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

namespace sslv::sandbox {
namespace {

/// Discards a socket's pending messages and closes the files in them.
void drain(int socket) {
  for (;;) {
    std::array<char, 256> bytes;
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control;
    iovec part{bytes.data(), bytes.size()};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    if (::recvmsg(socket, &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC) < 0) return;
    for (cmsghdr* one = CMSG_FIRSTHDR(&message); one != nullptr; one = CMSG_NXTHDR(&message, one)) {
      if (one->cmsg_level != SOL_SOCKET || one->cmsg_type != SCM_RIGHTS) continue;
      int file = -1;
      std::memcpy(&file, CMSG_DATA(one), sizeof file);
      ::close(file);
    }
  }
}

constexpr const char* kEnds = "the service ends";

std::string time_of_day() {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  ::localtime_r(&now, &local);
  return fmt::format("{:02}:{:02}", local.tm_hour, local.tm_min);
}

}  // namespace

StageProcess::StageProcess(std::string stage_name, std::string library_file, std::string floor_name,
                           std::string the_contract)
    : stage(std::move(stage_name)),
      library(std::move(library_file)),
      floor(std::move(floor_name)),
      contract(std::move(the_contract)),
      control(local_sockets(SOCK_SEQPACKET)) {}

struct Supervisor::Impl {
  enum class State : std::uint8_t { kPaused, kStarting, kReady };

  /// A StageProcess with the state of the supervisor's thread.
  struct Watched {
    explicit Watched(std::shared_ptr<StageProcess> the_process)
        : process(std::move(the_process)), output("stage '" + process->stage + "'") {}
    std::shared_ptr<StageProcess> process;
    State state = State::kPaused;
    ChildProcess started;
    OpenFile pipe;
    OutputLines output;
    std::int64_t due_ns = 0;  // kPaused: start time; kStarting: start deadline; kReady: start of readiness
    std::uint32_t lost_lately = 0;
    std::string killed_for;
  };

  explicit Impl(const Options& the_options)
      : options(the_options), wake(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    if (!wake.is_open()) throw std::system_error(errno, std::system_category(), "eventfd");
    thread = std::thread([this] { run(); });
  }
  ~Impl() {
    ends.store(true);
    ring();
    thread.join();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void ring() const {
    const std::uint64_t one = 1;
    (void)!::write(wake.fd(), &one, sizeof one);
  }

  std::shared_ptr<StageProcess> add(std::shared_ptr<StageProcess> process) {
    std::unique_lock lock(mutex);
    added.push_back(process);
    const auto begin = std::chrono::steady_clock::now();
    if (waiting.empty())
      patience = std::min<Duration>(patience + (begin - patience_at), options.longest_wait);
    const auto has_come = waiting.emplace(process.get(), std::nullopt).first;
    ring();
    const Duration longest = slow.contains(process->library) ? Duration(0) : patience;
    if (!settled.wait_until(lock, begin + longest, [&] { return has_come->second || stops; }))
      slow.insert(process->library);
    if (stops) process->is_wanted.store(false);
    patience_at = std::chrono::steady_clock::now();
    patience = std::max(patience - (patience_at - begin), Duration(0));
    const std::string problem = stops ? kEnds : has_come->second.value_or("");
    waiting.erase(has_come);
    lock.unlock();
    if (!problem.empty()) throw std::runtime_error(problem);
    return process;
  }

  void ask_to_stop() {
    {
      const std::lock_guard lock(mutex);
      stops = true;
    }
    settled.notify_all();
  }

  void wait_at_most(std::chrono::milliseconds together) {
    const std::lock_guard lock(mutex);
    patience = std::min<Duration>(patience, together);
    patience_at = std::chrono::steady_clock::now();
  }

  /// Ends the wait in add(), if one is pending. With a problem, the stage is given up.
  void settle(StageProcess& process, const std::string& problem) {
    const std::lock_guard lock(mutex);
    const auto who = waiting.find(&process);
    if (who == waiting.end() || who->second) return;
    who->second = problem;
    if (!problem.empty()) process.is_wanted.store(false);
    settled.notify_all();
  }

  void run() {
    // Keep the normal priority, because child processes inherit the priority of this thread.
    ::pthread_setname_np(::pthread_self(), "stage processes");
    std::vector<pollfd> polled;
    while (!ends.load()) {
      {
        const std::lock_guard lock(mutex);
        for (auto& process : added) all.push_back(std::make_unique<Watched>(std::move(process)));
        added.clear();
      }
      for (auto& one : all) look_after(*one);
      std::erase_if(all, [](const auto& one) {
        return one->state == State::kPaused && !one->process->is_wanted.load();
      });

      polled.assign(1, {wake.fd(), POLLIN, 0});
      for (const auto& one : all) {
        polled.push_back({one->started.fd(), POLLIN, 0});
        polled.push_back({one->pipe.fd(), POLLIN, 0});
        polled.push_back({one->state == State::kStarting ? one->process->control.ours.fd() : -1, POLLIN, 0});
      }
      ::poll(polled.data(), polled.size(), all.empty() ? -1 : next_look_ms());
      std::uint64_t rung = 0;
      (void)!::read(wake.fd(), &rung, sizeof rung);
    }
    for (auto& one : all) {
      if (one->state != State::kPaused) lose(*one);
    }
    const std::lock_guard lock(mutex);
    for (auto& [process, outcome] : waiting) {
      if (!outcome) outcome = kEnds;
    }
    settled.notify_all();
  }

  /// The poll timeout: ends when the next pause ends, and is at most kMost ms, because only polling detects
  /// hung processes.
  int next_look_ms() const {
    constexpr std::int64_t kMost = 50, kNsPerMs = 1'000'000;
    std::int64_t wait_ms = kMost;
    for (const auto& one : all) {
      if (one->state == State::kPaused)
        wait_ms = std::clamp<std::int64_t>((one->due_ns - steady_ns()) / kNsPerMs + 1, 0, wait_ms);
    }
    return static_cast<int>(wait_ms);
  }

  static std::int64_t ns(std::chrono::milliseconds time) {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(time).count();
  }

  void look_after(Watched& one) {
    const std::int64_t now_ns = steady_ns();
    if (one.state == State::kPaused) {
      if (one.process->is_wanted.load() && now_ns >= one.due_ns) start(one, now_ns);
      return;
    }
    if (one.pipe.is_open() && !one.output.read(one.pipe.fd(), now_ns)) one.pipe = OpenFile();
    if (one.state == State::kStarting) hear(one, now_ns);
    if (one.state != State::kPaused && should_be_killed(one, now_ns)) one.started.kill();
    if (one.started.has_ended()) lose(one);
  }

  bool should_be_killed(Watched& one, std::int64_t now_ns) {
    StageProcess& process = *one.process;
    if (!process.is_wanted.load()) {
      one.killed_for = "was stopped";
    } else if (one.state == State::kStarting) {
      if (now_ns < one.due_ns + one.started.grace_ns(3 * ns(options.starts_within))) return false;
      one.killed_for = "did not start in time and was killed";
      const std::lock_guard lock(mutex);
      slow.insert(process.library);
    } else if (process.failures_in_a_row.load() >= options.most_failures_in_a_row) {
      one.killed_for = "failed too often and was killed";
    } else {
      const std::int64_t asked_ns = process.asked_ns.load();
      const bool is_silent = process.channel.from().answer.load() != process.channel.to().request.load() &&
                             asked_ns != 0 && now_ns - asked_ns > ns(options.longest_silence);
      if (!is_silent) return false;
      one.killed_for = "hung and was killed";
    }
    return true;
  }

  void start(Watched& one, std::int64_t now_ns) {
    StageProcess& process = *one.process;
    drain(process.control.theirs.fd());
    drain(process.control.ours.fd());
    // Until generation is set, the Step does not access the following members.
    process.failures_in_a_row.store(0);
    process.asked_ns.store(0);
    process.channel.from().is_asleep.store(0);
    one.killed_for.clear();
    try {
      FilePair pipe = output_pipe();
      one.started = start_stage_process(
          {"run", process.library, process.floor, process.stage, process.contract},
          {process.control.theirs.fd(), process.channel.to_file(), process.channel.from_file()},
          pipe.theirs.fd());
      one.pipe = std::move(pipe.ours);
    } catch (const std::exception& error) {
      log::warning("stage '{}': cannot start its process: {}", process.stage, error.what());
      note_loss(one, "could not be started");
      return;
    }
    one.state = State::kStarting;
    one.due_ns = now_ns + ns(options.starts_within);
  }

  /// Reads whether the process is ready: "+", or "-" and the message of the stage's constructor.
  void hear(Watched& one, std::int64_t now_ns) {
    std::array<char, 1000> word;
    const ssize_t count = ::recv(one.process->control.ours.fd(), word.data(), word.size(), MSG_DONTWAIT);
    if (count <= 0) return;
    if (word[0] == '+') {
      one.state = State::kReady;
      one.due_ns = now_ns;
      do {
        ++newest_generation;
      } while (newest_generation == 0);
      one.process->generation.store(newest_generation);
      settle(*one.process, "");
      const std::lock_guard lock(mutex);
      slow.erase(one.process->library);
      return;
    }
    const std::string problem = escaped_text({word.data() + 1, static_cast<std::size_t>(count) - 1});
    one.killed_for = "cannot start: " + problem;
    one.started.kill();
    settle(*one.process, problem);
  }

  /// Called when the process has ended, or was killed and is about to end.
  void lose(Watched& one) {
    StageProcess& process = *one.process;
    const bool was_ready_long =
        one.state == State::kReady && steady_ns() - one.due_ns > ns(options.forgets_losses);
    process.generation.store(0);
    // Wakes the Step that waits for an answer. Changing the value also prevents the wait of a Step that is
    // about to wait.
    process.channel.from().answer.fetch_xor(1U << 31U);
    futex_wake_all(process.channel.from().answer, FutexScope::kShared);
    std::string how = end_text(one.started.end());
    if (!one.killed_for.empty()) how = one.killed_for;
    if (one.pipe.is_open()) one.output.read(one.pipe.fd(), steady_ns());
    one.output.end(steady_ns());
    one.pipe = OpenFile();
    if (was_ready_long) one.lost_lately = 0;
    note_loss(one, how);
  }

  void note_loss(Watched& one, const std::string& how) {
    one.state = State::kPaused;
    const std::int64_t pause_ns =
        one.lost_lately == 0 ? 0
                             : std::min(ns(options.longest_pause), ns(options.first_pause)
                                                                       << std::min(one.lost_lately - 1, 20U));
    ++one.lost_lately;
    one.due_ns = steady_ns() + pause_ns;
    if (!one.process->is_wanted.load() || ends.load()) return;
    log::warning("stage '{}': its process {}; restarting {}", one.process->stage, how,
                 pause_ns == 0 ? std::string("at once") : fmt::format("in {} ms", pause_ns / 1'000'000));
    StageProcess::Losses losses = one.process->losses.load();
    ++losses.count;
    const std::string text = fmt::format("{} at {}", how, time_of_day());
    losses.length = static_cast<std::uint8_t>(std::min(text.size(), losses.text.size()));
    std::memcpy(losses.text.data(), text.data(), losses.length);
    one.process->losses.store(losses);
    settle(*one.process, "");
  }

  const Options options;
  OpenFile wake;
  std::atomic<bool> ends{false};
  std::uint32_t newest_generation = 0;
  std::vector<std::unique_ptr<Watched>> all;  // used only by the thread

  std::mutex mutex;  // guards the following members
  std::condition_variable settled;
  std::vector<std::shared_ptr<StageProcess>> added;
  /// The stages that add() waits for, with the result: a problem, or an empty text on success.
  std::map<const StageProcess*, std::optional<std::string>> waiting;
  using Duration = std::chrono::steady_clock::duration;
  Duration patience{options.longest_wait};  // remaining waiting budget at patience_at
  std::chrono::steady_clock::time_point patience_at = std::chrono::steady_clock::now();
  std::set<std::string> slow;  // libraries with a stage that did not start in time
  bool stops = false;          // add() no longer waits

  std::thread thread;
};

Supervisor::Supervisor(const Options& options) : options_(options), impl_(std::make_unique<Impl>(options)) {}
Supervisor::~Supervisor() = default;

std::shared_ptr<StageProcess> Supervisor::start(const std::string& stage, const std::string& library,
                                                const std::string& floor, const std::string& contract) {
  return impl_->add(std::make_shared<StageProcess>(stage, library, floor, contract));
}

void Supervisor::ask_to_stop() {
  stop_.request_stop();
  impl_->ask_to_stop();
}

void Supervisor::wait_at_most(std::chrono::milliseconds together) {
  impl_->wait_at_most(together);
}

}  // namespace sslv::sandbox
