// SPDX-License-Identifier: Apache-2.0
#include "services/recording/match_log_recorder.h"

#include "base/background.h"
#include "base/clock.h"
#include "base/error.h"
#include "base/log.h"

#include <algorithm>
#include <utility>

namespace sslv {

double MatchLogRecorder::Status::counted_share() const {
  if (ours_bytes == 0) return 1;
  const auto ours = static_cast<double>(ours_bytes), strangers = static_cast<double>(strangers_bytes);
  return (ours + std::min(ours, strangers)) / (ours + strangers);
}

MatchLogRecorder::MatchLogRecorder(IsOurs is_ours, TracksForLog& tracks)
    : is_ours_(std::move(is_ours)),
      tracks_(tracks),
      thread_([this](const std::stop_token& stop) { keep_writing(stop); }),
      vision_(*this, "log vision", LoggedMessage::kVision2014, kVisionShare_bytes_per_s),
      tracker_(*this, "log tracker", LoggedMessage::kTracker2020, kTrackerShare_bytes_per_s),
      referee_(*this, "log referee", LoggedMessage::kReferee, kRefereeShare_bytes_per_s) {}

MatchLogRecorder::~MatchLogRecorder() {
  end();
}

void MatchLogRecorder::listen_now() {
  tracks_.want(is_listening_);
  vision_.receiver.listen(is_listening_ ? std::optional(groups_.vision) : std::nullopt);
  tracker_.receiver.listen(is_listening_ ? std::optional(groups_.tracker) : std::nullopt);
  referee_.receiver.listen(is_listening_ ? groups_.referee : std::nullopt);
}

void MatchLogRecorder::listen(const MatchLogGroups& groups) {
  const std::lock_guard control(control_mutex_);
  if (groups == groups_) return;
  groups_ = groups;
  if (is_listening_) listen_now();
}

void MatchLogRecorder::begin(const std::filesystem::path& file) {
  const std::lock_guard control(control_mutex_);
  auto writer = std::make_unique<MatchLogWriter>(file);
  {
    const std::lock_guard lock(mutex_);
    status_ = {.is_recording = true, .problem = {}};
    waiting_.clear();
    tracks_.discard();  // those of the log before
    written_steady_ns_ = 0;
    ends_ = cuts_strangers_ = false;
    writer_ = std::move(writer);
  }
  changed_.notify_all();
  is_listening_ = true;
  listen_now();
}

void MatchLogRecorder::pause(bool is_paused) {
  const std::lock_guard control(control_mutex_);
  if (is_listening_ == !is_paused || !status().is_recording) return;
  is_listening_ = !is_paused;
  listen_now();
}

void MatchLogRecorder::cut_strangers(bool cuts) {
  const std::lock_guard lock(mutex_);
  if (!std::exchange(cuts_strangers_, cuts)) {
    ours_before_cut_ = status_.ours_bytes;
    strangers_before_cut_ = status_.strangers_bytes;
  }
}

void MatchLogRecorder::end() {
  const std::lock_guard control(control_mutex_);
  if (is_listening_) {
    is_listening_ = false;
    listen_now();
  }
  std::unique_lock lock(mutex_);
  ends_ = true;
  changed_.notify_all();
  changed_.wait(lock, [this] { return !status_.is_recording; });
}

MatchLogRecorder::Status MatchLogRecorder::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

void MatchLogRecorder::take(Group& group, const boost::asio::ip::udp::endpoint& sender,
                            std::span<const std::byte> datagram) {
  // In this order, so that invalid datagrams do not count towards the rate limit.
  const bool is_good = is_league_message(group.type, datagram) &&
                       group.share.take(sender.address().to_v4().to_uint(), datagram.size(), steady_s());
  const bool is_ours = is_good && is_ours_(group.type, sender);
  const std::lock_guard lock(mutex_);
  // Under the lock, so that messages are in order of time.
  const std::int64_t now_steady_ns = steady_ns(), time_ns = unix_time_ns();
  if (!status_.is_recording) return;
  if (!is_good) {
    ++status_.refused;
    return;
  }
  const std::uint64_t bytes = datagram.size() + kMessageHeaderBytes;
  const std::uint64_t ours_bytes = status_.ours_bytes - ours_before_cut_,
                      strangers_bytes = status_.strangers_bytes - strangers_before_cut_;
  if (!is_ours && cuts_strangers_ && strangers_bytes + bytes > ours_bytes) {
    ++status_.cut;
    return;
  }
  if (waiting_.bytes.size() + datagram.size() > kMaxWaitingBytes) {
    ++status_.lost;
    return;
  }
  (is_ours ? status_.ours_bytes : status_.strangers_bytes) += bytes;
  waiting_.messages.push_back(
      {now_steady_ns, time_ns, group.type, static_cast<std::uint32_t>(datagram.size())});
  waiting_.bytes.insert(waiting_.bytes.end(), datagram.begin(), datagram.end());
  ++(group.type == LoggedMessage::kVision2014 ? status_.vision
     : group.type == LoggedMessage::kReferee  ? status_.referee
                                              : status_.tracked);
}

bool MatchLogRecorder::write(const Waiting& some, std::int64_t until_steady_ns) {
  try {
    std::uint64_t tracked = 0, tracked_bytes = 0;
    const auto add = [&](std::int64_t steady_ns, std::int64_t time_ns, std::int32_t type,
                         std::span<const std::byte> message) {
      // Tracks may be late: the field's thread may be interrupted before it hands them over.
      if (steady_ns >= written_steady_ns_) {
        written_steady_ns_ = steady_ns;
        written_ns_ = time_ns;
      }
      writer_->add(written_ns_, type, message);
    };
    const auto add_tracks = [&](std::int64_t steady_ns) {
      tracks_.read(steady_ns, [&](const TracksForLog::Packet& packet) {
        add(packet.steady_ns, packet.time_ns, LoggedMessage::kTracker2020, packet.bytes);
        ++tracked;
        tracked_bytes += packet.bytes.size() + kMessageHeaderBytes;
      });
    };
    std::span<const std::byte> bytes(some.bytes);
    for (const Waiting::Message& message : some.messages) {
      add_tracks(message.steady_ns);
      add(message.steady_ns, message.time_ns, message.type, bytes.first(message.size));
      bytes = bytes.subspan(message.size);
    }
    add_tracks(until_steady_ns);
    writer_->flush();
    const std::lock_guard lock(mutex_);
    status_.tracked += tracked;
    status_.ours_bytes += tracked_bytes;
    status_.lost += tracks_.take_dropped();
    return true;
  } catch (const StorageError& error) {
    log::error("{}; the match log ends", error.what());
    const std::lock_guard lock(mutex_);
    status_.problem = error.what();
    return false;
  }
}

void MatchLogRecorder::keep_writing(const std::stop_token& stop) {
  become_background_thread("match log", 15);
  Waiting some;
  while (true) {
    bool ends;
    std::int64_t until_steady_ns;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, stop, [this] { return status_.is_recording; });
      if (!status_.is_recording) return;  // stopped; end() was called before
      changed_.wait_for(lock, stop, kFlushInterval, [this] { return ends_; });
      ends = ends_ || stop.stop_requested();
      std::swap(some, waiting_);
      until_steady_ns = steady_ns();
    }
    bool is_well = write(some, until_steady_ns);
    some.clear();
    if (is_well && ends) {
      try {
        writer_->finish();
      } catch (const StorageError& error) {
        log::error("{}; the match log is not complete", error.what());
        const std::lock_guard lock(mutex_);
        status_.problem = error.what();
      }
    }
    const std::uint64_t bytes = writer_->bytes();
    if (!is_well || ends) writer_.reset();
    const std::lock_guard lock(mutex_);
    status_.bytes = bytes;
    if (!is_well || ends) {
      status_.is_recording = false;
      waiting_.clear();
      changed_.notify_all();
    }
  }
}

}  // namespace sslv
