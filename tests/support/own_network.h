// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <arpa/inet.h>
#include <net/if.h>
#include <net/route.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

namespace sslv {

/// Runs `act` in a child process; returns its result as the exit status, 128 on a crash.
template <class Act>
int in_child(const Act& act) {
  const pid_t child = fork();
  if (child == 0) _exit(act());
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

/// Exit codes of child processes.
inline constexpr int kPassed = 0, kNoNamespaces = 77;

/// Runs `act` in a new network namespace, with the loopback interface still down.
template <class Act>
int without_network(const Act& act) {
  return in_child([&] { return unshare(CLONE_NEWUSER | CLONE_NEWNET) == 0 ? act() : kNoNamespaces; });
}

inline bool ask_system(unsigned long what, void* request) {
  const int fd = socket(AF_INET, SOCK_DGRAM, 0);
  const bool is_done = ioctl(fd, what, request) == 0;
  close(fd);
  return is_done;
}

inline sockaddr system_address(const char* text) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  inet_pton(AF_INET, text, &address.sin_addr);
  return reinterpret_cast<const sockaddr&>(address);
}

inline bool bring_loopback_up() {
  ifreq request{};
  request.ifr_name[0] = 'l';
  request.ifr_name[1] = 'o';
  request.ifr_flags = IFF_UP;
  return ask_system(SIOCSIFFLAGS, &request);
}

/// `what`: SIOCSIFADDR, SIOCSIFNETMASK.
inline bool set_loopback(unsigned long what, const char* address) {
  ifreq request{};
  request.ifr_name[0] = 'l';
  request.ifr_name[1] = 'o';
  request.ifr_addr = system_address(address);
  return ask_system(what, &request);
}

inline bool route_to_loopback(const char* net, const char* mask) {
  char card[] = "lo";
  rtentry route{};
  route.rt_dst = system_address(net);
  route.rt_genmask = system_address(mask);
  route.rt_flags = RTF_UP;
  route.rt_dev = card;
  return ask_system(SIOCADDRT, &route);
}

}  // namespace sslv
