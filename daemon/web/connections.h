// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

namespace sslv {

/// A server's connections: how many there may be, and which one is closed when there is no room for another.
///
/// A newcomer is let in as long as something can go for it: a connection whose request is not there yet (it
/// is idle, or half of a request came), or one that takes its answer for longer than kSendPatience_s. Of
/// these goes the one whose address has most connections, and of equals the one that has been so for longest.
/// Where none can go, an address with many connections gives the one that has taken its answer for longest.
/// So a client that sends a request at once is served, however many others never do. Viewers (WebSockets and
/// streams of images) stay until they go, and are few enough to leave room.
///
/// A part of the connections is kept for trusted addresses: strangers never have all of them.
///
/// What waits in memory for clients is bounded too: answers, images and messages until they are taken, bodies
/// of requests until they have come. All of strangers together, that of one address, and all of trusted
/// addresses have a limit. When there is too much, a client that moves no byte for kSendPatience_s is closed,
/// first of the address that has most; for an address with much, kSendPatienceWithMany_s is enough unless it
/// is a viewer. Where nobody is so slow, the newest is refused.
///
/// Seats may be given back from any thread; everything else is for the socket's thread.
class Connections {
 public:
  using Clock = std::function<double()>;  // steady, s
  static constexpr double kSendPatience_s = 5;
  static constexpr double kSendPatienceWithMany_s = 0.5;
  static constexpr std::size_t kMaxUnsentBytes = std::size_t{12} << 20U,
                               kMaxUnsentBytesOfAddress = std::size_t{8} << 20U,
                               kMaxUnsentBytesOfTrusted = std::size_t{24} << 20U;
  /// As much each connection may have, so that who only asks whether all is well always gets an answer.
  static constexpr std::size_t kAlwaysSentBytes = 16 * 1024;

  class Seat;

  /// `max`: connections at once, viewers included. `unsent`: counts what was dropped because too much waits.
  Connections(int max, Clock now_s, std::atomic<std::uint64_t>& unsent);
  Connections(const Connections&) = delete;
  Connections& operator=(const Connections&) = delete;

  /// A seat for a connection from this address, which must not outlive this; null when there is no room, with
  /// the reason for the client in `problem`.
  std::shared_ptr<Seat> admit(const std::string& address, bool is_trusted, std::string& problem);

 private:
  enum class State { kWaits, kWorks, kSends, kStays };

  // With mutex_ held:
  std::size_t count(const std::function<bool(const Seat&)>& which) const;
  /// Null: none can go whose network has so many. `patience_s`: how long an answer may be on its way.
  Seat* most_dispensable(const std::function<bool(const Seat&)>& which, double patience_s,
                         std::size_t min_of_network) const;
  /// Null: none of these has moved nothing for so long.
  Seat* slowest(const std::function<bool(const Seat&)>& which, double patience_s,
                std::size_t min_bytes_of_network) const;
  std::function<void()> leave(Seat& seat);  // returns what closes it, to be called without the mutex
  void count_in(Seat& seat);
  void count_out(Seat& seat);
  void set_unsent_bytes(Seat& seat, std::size_t bytes);

  /// `large_bytes`: that wait for seats with more than kAlwaysSentBytes.
  struct Sums {
    std::size_t seats = 0, large_bytes = 0;
  };
  using Groups = std::map<std::pair<std::string, bool>, Sums>;  // by network, and whether it is trusted
  Sums& all_of(bool is_trusted) { return is_trusted ? trusted_ : strangers_; }

  const std::size_t max_;
  const Clock now_s_;
  std::atomic<std::uint64_t>& unsent_;
  mutable std::mutex mutex_;  // guards what follows and what the seats have
  std::list<Seat*> seats_;    // those in the same state for longest come first
  Groups groups_;             // of these
  Sums strangers_, trusted_;  // likewise
};

/// One connection's. Takes no room any more once it is gone or was told to close.
class Connections::Seat : public std::enable_shared_from_this<Connections::Seat> {
 public:
  Seat(Connections& connections, std::string network, bool is_trusted);
  ~Seat();
  Seat(const Seat&) = delete;
  Seat& operator=(const Seat&) = delete;

  /// How the connection is closed when another needs the room. Called from within admit(); must not destroy
  /// the seat.
  void closes_by(std::function<void()> close);

  /// What the connection does from now on.
  void waits() { is(State::kWaits); }  // for a request, or for the rest of one
  void works() { is(State::kWorks); }  // its request is being handled
  void sends() { is(State::kSends); }  // the answer is on its way

  /// Asks to stay open as a viewer. False when there are too many of these, with the reason in `problem`.
  bool stays(bool is_trusted, std::string& problem);

  /// So many bytes are to wait in memory until the client takes them, or sends them. False when that is more
  /// than before and too much: nothing has changed then, and `problem` says so. May close other connections.
  bool holds(std::size_t bytes, std::string& problem);
  /// The client took or sent some of these: it is not the slowest.
  void makes_progress();

 private:
  friend class Connections;
  void is(State state);
  void enter(State state);  // with the mutex held

  Connections& connections_;
  const std::string network_;
  bool is_trusted_;
  State state_ = State::kWaits;
  double since_s_;
  std::size_t unsent_bytes_ = 0;
  double unmoved_since_s_ = 0;  // the client has taken and sent nothing
  std::function<void()> close_;
  std::list<Seat*>::iterator place_;
  Groups::iterator group_;
  bool is_counted_ = true;
};

}  // namespace sslv
