// SPDX-License-Identifier: Apache-2.0
#include "kit/sandbox/ask_library.h"

#include "base/clock.h"
#include "base/plain_text.h"
#include "kit/sandbox/start_process.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>

namespace sslv::sandbox {
namespace {

/// Longer answers are rejected.
constexpr std::size_t kLongestAnswer = std::size_t{4} << 20;

/// Reads until a newline or the end of the process. Empty if the answer took too long or is too long, or if
/// `stop` was requested.
std::string read_answer(int socket, int pipe, const ChildProcess& process, OutputLines& output,
                        std::int64_t begin_ns, std::int64_t within_ns, const std::stop_token& stop) {
  constexpr std::int64_t kNsPerMs = 1'000'000, kLookMs = 50;
  std::string answer;
  for (;;) {
    const std::int64_t left_ns = begin_ns + within_ns + process.grace_ns(3 * within_ns) - steady_ns();
    if (left_ns <= 0 || stop.stop_requested()) return {};
    std::array<pollfd, 3> polled{{{socket, POLLIN, 0}, {pipe, POLLIN, 0}, {process.fd(), POLLIN, 0}}};
    ::poll(polled.data(), polled.size(), static_cast<int>(std::min(left_ns / kNsPerMs + 1, kLookMs)));
    if (pipe >= 0 && polled[1].revents != 0 && !output.read(pipe, steady_ns())) pipe = -1;
    std::array<char, 16384> buffer;
    const ssize_t count = ::recv(socket, buffer.data(), buffer.size(), MSG_DONTWAIT);
    if (count == 0 || (count < 0 && errno != EAGAIN && errno != EINTR)) return answer;
    if (count > 0) answer.append(buffer.data(), static_cast<std::size_t>(count));
    if (answer.size() > kLongestAnswer) return {};
    if (answer.ends_with('\n')) return answer;
    // The process has ended and the socket is drained. Other processes may still hold the socket open.
    if (count < 0 && polled[2].revents != 0) return answer;
  }
}

void send_all(int socket, std::string_view text, std::int64_t until_ns) {
  while (!text.empty() && steady_ns() < until_ns) {
    const ssize_t count = ::send(socket, text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (count > 0) {
      text.remove_prefix(static_cast<std::size_t>(count));
      continue;
    }
    if (errno != EAGAIN && errno != EINTR) return;
    constexpr int kLookMs = 10;
    pollfd polled{socket, POLLOUT, 0};
    ::poll(&polled, 1, kLookMs);
  }
}

}  // namespace

Json ask_library(const std::string& library, const Json& question, const std::stop_token& stop,
                 std::chrono::milliseconds within) {
  const std::string name = std::filesystem::path(library).filename().string();
  const std::int64_t within_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(within).count();
  const std::int64_t begin_ns = steady_ns();
  FilePair sockets = local_sockets(SOCK_STREAM);
  FilePair pipe = output_pipe();
  ChildProcess process = start_stage_process({"ask", library}, {sockets.theirs.fd()}, pipe.theirs.fd());
  sockets.theirs = OpenFile();
  pipe.theirs = OpenFile();
  send_all(sockets.ours.fd(), json_text(question), begin_ns + within_ns);
  ::shutdown(sockets.ours.fd(), SHUT_WR);
  OutputLines output("stage library " + name);
  const std::string text =
      read_answer(sockets.ours.fd(), pipe.ours.fd(), process, output, begin_ns, within_ns, stop);
  const bool is_late =
      steady_ns() >= begin_ns + within_ns + process.grace_ns(3 * within_ns) || stop.stop_requested();
  if (text.empty() && !is_late) {
    // The process ended without an answer: wait for its exit status.
    constexpr int kEndsWithinMs = 1000;
    process.has_ended(kEndsWithinMs);
  }
  const std::string end = end_text(process.end());
  output.read(pipe.ours.fd(), steady_ns());
  output.end(steady_ns());
  if (text.empty()) {
    throw std::runtime_error(fmt::format("stage library {}: its process {}", name,
                                         is_late ? std::string("took too long to answer") : end));
  }
  Json answer;
  try {
    answer = parse_bounded_json(text);
  } catch (const std::exception&) {
    throw std::runtime_error(fmt::format("stage library {}: its process gave an invalid answer", name));
  }
  if (!answer.is_object())
    throw std::runtime_error(fmt::format("stage library {}: its process gave an invalid answer", name));
  if (answer.contains("error")) {
    const Json& error = answer.at("error");
    throw std::runtime_error(escaped_text(error.is_string() ? error.get<std::string>() : json_text(error)));
  }
  return answer;
}

}  // namespace sslv::sandbox
