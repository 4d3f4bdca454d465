// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "net/multicast_receiver.h"
#include "recording/league_intake.h"
#include "recording/match_log_writer.h"

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

namespace sslv {

/// Where what a match log holds is sent.
struct MatchLogGroups {
  GroupAddress vision, tracker;
  std::optional<GroupAddress> referee;
  bool operator==(const MatchLogGroups&) const = default;
};

/// Writes what the league sends to the groups of a field into one log after the other. Threads that listen
/// check and copy; one of low priority packs and writes, twice a second onto the disk. A disk that hangs
/// delays nobody: what finds no room then is lost and counted. May be used from any thread.
class MatchLogRecorder {
 public:
  static constexpr std::chrono::milliseconds kFlushInterval{500};
  static constexpr std::size_t kMaxWaitingBytes = 16 * 1024 * 1024;

  struct Status {
    bool is_recording = false;
    std::uint64_t bytes = 0, vision = 0, referee = 0, tracked = 0;
    std::uint64_t lost = 0;     // found no room
    std::uint64_t refused = 0;  // were none of the league's messages, or more than a field sends
    std::uint64_t cut = 0;      // of strangers, when there was little room
    std::uint64_t ours_bytes = 0, strangers_bytes = 0;  // taken, before they are packed
    std::string problem;                                // why it ended early; empty: it did not

    /// Of the log's bytes, what other recordings may go for: strangers' only as far as there are no more of
    /// them than of ours, or all where nothing is ours.
    double counted_share() const;
  };

  /// Whether messages of that type from there are the field's own; otherwise a stranger sends them. Called
  /// from the threads that listen.
  using IsOurs = std::function<bool(std::int32_t type, const boost::asio::ip::udp::endpoint& sender)>;

  explicit MatchLogRecorder(IsOurs is_ours);
  ~MatchLogRecorder();

  /// Where to listen from now on.
  void listen(const MatchLogGroups& groups);

  /// Throws StorageError when the file cannot be made. Only when none is recorded.
  void begin(const std::filesystem::path& file);
  /// Nothing is taken in while it is paused.
  void pause(bool is_paused);
  /// There is little room: from now on strangers' messages are taken only as far as there are no more of them
  /// than of ours, in bytes. Until begin().
  void cut_strangers(bool cuts);
  /// When it returns, the file is complete; or problem() says why not.
  void end();

  /// Of the log that is recorded, or was last.
  Status status() const;

 private:
  struct Waiting {
    struct Message {
      std::int64_t time_ns;
      std::int32_t type;
      std::uint32_t size;
    };
    std::vector<Message> messages;
    std::vector<std::byte> bytes;  // of one message after the other
    void clear() {
      messages.clear();
      bytes.clear();
    }
  };

  struct Group;
  void take(Group& group, const boost::asio::ip::udp::endpoint& sender, std::span<const std::byte> datagram);
  void listen_now();  // with control_mutex_ held
  void keep_writing(const std::stop_token& stop);
  bool write(const Waiting& some);  // false: it cannot be written on

  const IsOurs is_ours_;
  std::mutex control_mutex_;  // for begin(), pause(), end() and listen(), one at a time
  MatchLogGroups groups_;
  bool is_listening_ = false;

  mutable std::mutex mutex_;  // guards the next ones; never held while the disk is waited for
  std::condition_variable_any changed_;
  Status status_;
  Waiting waiting_;
  bool ends_ = false;
  bool cuts_strangers_ = false;
  std::uint64_t ours_before_cut_ = 0, strangers_before_cut_ = 0;  // bytes
  std::unique_ptr<MatchLogWriter> writer_;                        // given to the thread while it records

  std::jthread thread_;
  struct Group {
    Group(MatchLogRecorder& recorder, const char* thread_name, std::int32_t its_type, double bytes_per_s)
        : type(its_type),
          share(bytes_per_s),
          receiver(thread_name, [this, &recorder](auto datagram, const auto& sender) {
            recorder.take(*this, sender, datagram);
          }) {}
    const std::int32_t type;
    LeagueShare share;  // the receiver's thread's
    MulticastReceiver receiver;
  };
  Group vision_, tracker_, referee_;  // last: their threads use the others
};

}  // namespace sslv
