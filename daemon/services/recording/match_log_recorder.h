// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "net/multicast_receiver.h"
#include "recording/league_intake.h"
#include "recording/match_log_writer.h"
#include "recording/tracks_for_log.h"

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

/// The multicast groups that a match log records.
struct MatchLogGroups {
  GroupAddress vision, tracker;
  std::optional<GroupAddress> referee;
  bool operator==(const MatchLogGroups&) const = default;
};

/// Records the league's messages that are sent to a field's groups, one log after the other. A sender is
/// either ours (one of the field's own senders, see IsOurs) or a stranger. Receiver threads check and copy
/// messages; a thread of low priority compresses and writes them, and syncs to the disk twice a second. A
/// disk that hangs delays no receiver: messages that do not fit into the buffer are lost and counted. Our
/// tracks are in a log even if the settings do not send them to the network. May be used from any thread.
class MatchLogRecorder {
 public:
  static constexpr std::chrono::milliseconds kFlushInterval{500};
  static constexpr std::size_t kMaxWaitingBytes = 16 * 1024 * 1024;

  struct Status {
    bool is_recording = false;
    std::uint64_t bytes = 0, vision = 0, referee = 0, tracked = 0;
    std::uint64_t lost = 0;                             // messages that did not fit into the buffer
    std::uint64_t refused = 0;                          // not the league's messages, or above the rate limit
    std::uint64_t cut = 0;                              // strangers' messages dropped because space was low
    std::uint64_t ours_bytes = 0, strangers_bytes = 0;  // accepted bytes, uncompressed
    std::string problem;                                // why the log ended early; empty: it did not

    /// Share of the log's bytes, 0 to 1, that counts when space is freed: our bytes, and at most the same
    /// number of strangers' bytes; 1 if the log has no bytes from us.
    double counted_share() const;
  };

  /// Whether messages of that type from that sender are the field's own; otherwise the sender is a stranger.
  /// Called from the receiver threads.
  using IsOurs = std::function<bool(std::int32_t type, const boost::asio::ip::udp::endpoint& sender)>;

  /// `tracks` must outlive this.
  MatchLogRecorder(IsOurs is_ours, TracksForLog& tracks);
  ~MatchLogRecorder();

  /// Sets the groups to record.
  void listen(const MatchLogGroups& groups);

  /// Starts a log, while none is recorded. Throws StorageError if the file cannot be created.
  void begin(const std::filesystem::path& file);
  /// Records nothing while paused.
  void pause(bool is_paused);
  /// For low disk space: while set, a stranger's message is dropped if strangers would otherwise have more
  /// bytes in the log than our senders, both counted since cutting was switched on. begin() switches cutting
  /// off.
  void cut_strangers(bool cuts);
  /// Ends the log. Afterwards the file is complete, or Status::problem says why not.
  void end();

  /// Status of the current or the last log.
  Status status() const;

 private:
  struct Waiting {
    struct Message {
      std::int64_t steady_ns, time_ns;  // as in TracksForLog
      std::int32_t type;
      std::uint32_t size;
    };
    std::vector<Message> messages;
    std::vector<std::byte> bytes;  // the messages' bytes, concatenated
    void clear() {
      messages.clear();
      bytes.clear();
    }
  };

  struct Group;
  void take(Group& group, const boost::asio::ip::udp::endpoint& sender, std::span<const std::byte> datagram);
  void listen_now();  // with control_mutex_ held
  void keep_writing(const std::stop_token& stop);
  /// Writes `some`, and our tracks up to `until_steady_ns`. Returns false if the log cannot be continued.
  bool write(const Waiting& some, std::int64_t until_steady_ns);

  const IsOurs is_ours_;
  TracksForLog& tracks_;
  std::mutex control_mutex_;  // serializes begin(), pause(), end() and listen()
  MatchLogGroups groups_;
  bool is_listening_ = false;

  mutable std::mutex mutex_;  // guards the next members; never held while waiting for the disk
  std::condition_variable_any changed_;
  Status status_;
  Waiting waiting_;
  bool ends_ = false;
  bool cuts_strangers_ = false;
  std::uint64_t ours_before_cut_ = 0, strangers_before_cut_ = 0;  // bytes
  std::unique_ptr<MatchLogWriter> writer_;                        // used by the thread while it records
  std::int64_t written_steady_ns_ = 0, written_ns_ = 0;           // times of the last message, for the thread

  std::jthread thread_;
  struct Group {
    Group(MatchLogRecorder& recorder, const char* thread_name, std::int32_t its_type, double bytes_per_s)
        : type(its_type),
          share(bytes_per_s),
          receiver(thread_name, [this, &recorder](auto datagram, const auto& sender) {
            recorder.take(*this, sender, datagram);
          }) {}
    const std::int32_t type;
    LeagueShare share;  // used by the receiver's thread
    MulticastReceiver receiver;
  };
  Group vision_, tracker_, referee_;  // last: their threads use the members above
};

}  // namespace sslv
