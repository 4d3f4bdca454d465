// SPDX-License-Identifier: Apache-2.0
#include "net/local_listeners.h"

#include <array>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <system_error>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <pwd.h>

namespace sslv {
namespace {

using boost::asio::ip::address_v4;

std::string proc_text(const char* file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

template <class Number>
std::optional<Number> number_in(std::string_view digits, int base) {
  Number value{};
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value, base);
  if (error != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
  return value;
}

/// The kernel prints the address's bytes in memory order as one number.
std::string kernel_hex(const address_v4& address) {
  return fmt::format("{:08X}", htonl(address.to_uint()));
}

/// Inodes of this process's sockets.
std::set<std::uint64_t> own_sockets() {
  std::set<std::uint64_t> inodes;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", error)) {
    std::error_code gone;  // the file was closed meanwhile
    const std::string target = std::filesystem::read_symlink(entry.path(), gone).string();
    constexpr std::string_view kBefore = "socket:[";
    if (gone || !target.starts_with(kBefore) || !target.ends_with(']')) continue;
    const auto inode = number_in<std::uint64_t>(
        std::string_view(target).substr(kBefore.size(), target.size() - kBefore.size() - 1), 10);
    if (inode) inodes.insert(*inode);
  }
  return inodes;
}

}  // namespace

std::vector<ListeningSocket> listening_sockets(std::string_view proc_net_udp, const address_v4& group,
                                               int port) {
  const std::string group_hex = kernel_hex(group);
  const std::string all_v4(8, '0'), all_v6(32, '0');
  // IPv4-mapped IPv6 address.
  const std::string group_v6 = "0000000000000000" + kernel_hex(address_v4(0xFFFF)) + group_hex;
  std::vector<ListeningSocket> sockets;
  std::istringstream lines{std::string(proc_net_udp)};
  std::string line;
  std::getline(lines, line);  // the columns' names
  while (std::getline(lines, line)) {
    // sl local_address rem_address st tx:rx tr:tm retrnsmt uid timeout inode ...
    std::istringstream fields(line);
    std::array<std::string, 10> field;
    for (std::string& one : field) fields >> one;
    const std::size_t colon = field[1].find(':');
    if (!fields || colon == std::string::npos) continue;
    const std::string address = field[1].substr(0, colon);
    if (number_in<int>(std::string_view(field[1]).substr(colon + 1), 16) != port) continue;
    ListeningSocket socket;
    if (address == group_hex || address == group_v6) {
      socket.address = group.to_string();
    } else if (address == all_v4) {
      socket.address = "0.0.0.0";
    } else if (address == all_v6) {
      socket.address = "::";
    } else {
      continue;
    }
    socket.user_id = number_in<std::uint32_t>(field[7], 10).value_or(0);
    socket.inode = number_in<std::uint64_t>(field[9], 10).value_or(0);
    sockets.push_back(std::move(socket));
  }
  return sockets;
}

std::vector<GroupMembership> group_memberships(std::string_view proc_net_igmp, const address_v4& group) {
  const std::string group_hex = kernel_hex(group);
  std::vector<GroupMembership> memberships;
  GroupMembership card;
  std::istringstream lines{std::string(proc_net_igmp)};
  std::string line;
  std::getline(lines, line);  // the columns' names
  while (std::getline(lines, line)) {
    std::istringstream fields(line);
    std::string first, second, colon, count, version;
    if (!line.starts_with('\t')) {
      // For example "2 eth0 : 3 V3"; a long name has no space before the colon.
      fields >> first >> second >> colon;
      if (second.ends_with(':')) {
        second.pop_back();
        fields >> version;
      } else {
        fields >> count >> version;
      }
      card = {.interface = second};
      if (version.starts_with('V')) {
        card.igmp_version = number_in<int>(std::string_view(version).substr(1), 10).value_or(0);
      }
      continue;
    }
    fields >> first >> second;
    if (first != group_hex) continue;
    card.joins = number_in<unsigned>(second, 10).value_or(0);
    memberships.push_back(card);
  }
  return memberships;
}

LocalListeners local_listeners(const address_v4& group, int port) {
  LocalListeners out;
  const std::set<std::uint64_t> own = own_sockets();
  for (const char* file : {"/proc/net/udp", "/proc/net/udp6"}) {
    for (ListeningSocket& socket : listening_sockets(proc_text(file), group, port)) {
      if (!own.contains(socket.inode)) out.others.push_back(std::move(socket));
    }
  }
  // Raw sockets have no port; services of this program receive through them.
  for (ListeningSocket& socket : listening_sockets(proc_text("/proc/net/raw"), group, IPPROTO_UDP)) {
    if (socket.address == group.to_string() && !own.contains(socket.inode))
      out.others.push_back(std::move(socket));
  }
  out.memberships = group_memberships(proc_text("/proc/net/igmp"), group);
  return out;
}

std::string user_name(std::uint32_t id) {
  passwd entry{};
  passwd* found = nullptr;
  std::array<char, 4096> buffer{};
  if (getpwuid_r(id, &entry, buffer.data(), buffer.size(), &found) != 0 || !found) return std::to_string(id);
  return found->pw_name;
}

}  // namespace sslv
