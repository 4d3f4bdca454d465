// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/kept_files.h"
#include "support/patience.h"

#include <chrono>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <filesystem>
#include <mutex>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace sslv::test {

/// The service manager's side of a service: receives sd_notify(3) messages and keeps the files sent to it.
/// It always listens, like the real one: its socket queues about ten messages, then senders block.
class ServiceManager {
 public:
  explicit ServiceManager(const std::filesystem::path& socket) : path_(socket) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.string().copy(address.sun_path, sizeof address.sun_path - 1);
    if (socket_ < 0 || ::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
      throw std::runtime_error("no socket for notifications: " + std::string(std::strerror(errno)));
    thread_ = std::jthread([this](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        pollfd waiting{socket_, POLLIN, 0};
        ::poll(&waiting, 1, 100);
        const std::lock_guard lock(mutex_);
        read_all();
      }
    });
  }
  ~ServiceManager() {
    thread_ = {};
    ::close(socket_);
  }
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;

  /// For the service's environment.
  std::string variable() const { return "NOTIFY_SOCKET=" + path_.string(); }

  /// The next message; nullopt on timeout.
  std::optional<std::string> next(std::chrono::milliseconds timeout) {
    std::unique_lock lock(mutex_);
    read_all();
    if (!came_.wait_for(lock, timeout, [this] { return !heard_.empty(); })) return std::nullopt;
    Message message = std::move(heard_.front());
    heard_.pop_front();
    see(message.text, std::move(message.file));
    return message.text;
  }

  /// Files that the service has stored here, to get them back after a crash.
  const std::vector<KeptFile>& kept() const { return kept_; }
  /// Reads the last messages after the service's end.
  void hear_the_rest() {
    while (next(std::chrono::milliseconds(0))) {
    }
  }

  /// The next message with this beginning; throws std::runtime_error with those received instead.
  std::string wait_for(const std::string& beginning) {
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    std::string others;
    while (std::chrono::steady_clock::now() < deadline) {
      const auto message = next(std::chrono::seconds(1));
      if (message && message->starts_with(beginning)) return *message;
      if (message) others += *message + "\n";
    }
    throw std::runtime_error("the service manager was not told " + beginning + " but\n" + others);
  }

 private:
  struct Message {
    std::string text;
    OpenFile file;
  };

  void read_all() {
    for (;;) {
      char text[4096];
      iovec part{text, sizeof text};
      alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))];
      msghdr message{};
      message.msg_iov = &part;
      message.msg_iovlen = 1;
      message.msg_control = control;
      message.msg_controllen = sizeof control;
      const ssize_t size = ::recvmsg(socket_, &message, MSG_CMSG_CLOEXEC | MSG_DONTWAIT);
      if (size < 0) return;
      OpenFile file;
      const cmsghdr* const sent = CMSG_FIRSTHDR(&message);
      if (sent != nullptr && sent->cmsg_type == SCM_RIGHTS) {
        int fd = -1;
        std::memcpy(&fd, CMSG_DATA(sent), sizeof fd);
        file = OpenFile(fd);
      }
      heard_.push_back({std::string(text, static_cast<std::size_t>(size)), std::move(file)});
      came_.notify_all();
    }
  }

  void see(const std::string& message, OpenFile file) {
    std::string name;
    bool keeps = false, forgets = false;
    std::istringstream lines(message);
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("FDNAME=")) name = line.substr(7);
      keeps |= line == "FDSTORE=1";
      forgets |= line == "FDSTOREREMOVE=1";
    }
    if (forgets) std::erase_if(kept_, [&](const KeptFile& one) { return one.name == name; });
    if (keeps) kept_.push_back({name, std::move(file)});
  }

  std::vector<KeptFile> kept_;
  const std::filesystem::path path_;
  const int socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  std::mutex mutex_;
  std::condition_variable came_;
  std::deque<Message> heard_;
  std::jthread thread_;  // last member: uses the others
};

}  // namespace sslv::test
