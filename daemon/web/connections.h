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

/// Limits a server's connections and chooses the connection to close when a new one would exceed the limit.
///
/// At the limit, a new connection is accepted if another connection can be closed for it: a connection that
/// waits for a request (idle, or with part of a request received), or whose answer takes longer than
/// kSendPatience_s. The address with most connections loses a connection first; among equals, the connection
/// that has been in its state for longest is closed. Without a candidate, an address with many connections
/// loses the connection whose answer takes longest, if that exceeds kSendPatienceWithMany_s. So a client that
/// sends its request at once is served, even if many other clients send none. Viewers (WebSockets and image
/// streams) are never closed for a new connection; instead, their number is limited.
///
/// Some connections are reserved for trusted addresses: untrusted addresses can never use all connections.
///
/// Memory for data that waits for clients is limited too: unsent answers, images and messages, and bodies of
/// requests still being received. There is a limit for all untrusted addresses together, for each untrusted
/// address, and for all trusted addresses together. Above a limit, a client that has transferred no byte for
/// kSendPatience_s is disconnected, beginning with the address that holds most memory. For an address that
/// holds much memory, kSendPatienceWithMany_s suffices unless the client is a viewer. If no client is that
/// slow, the new data is refused.
///
/// Seats may be released from any thread; all other functions are for the socket's thread.
class Connections {
 public:
  using Clock = std::function<double()>;  // steady, s
  static constexpr double kSendPatience_s = 5;
  static constexpr double kSendPatienceWithMany_s = 0.5;
  static constexpr std::size_t kMaxUnsentBytes = std::size_t{12} << 20U,
                               kMaxUnsentBytesOfAddress = std::size_t{8} << 20U,
                               kMaxUnsentBytesOfTrusted = std::size_t{24} << 20U;
  /// Every connection may always hold this much, so that health checks are always answered.
  static constexpr std::size_t kAlwaysSentBytes = 16 * 1024;

  class Seat;

  /// `max`: simultaneous connections, viewers included. `unsent`: counts answers, messages and requests that
  /// are dropped because too much data waits.
  Connections(int max, Clock now_s, std::atomic<std::uint64_t>& unsent);
  Connections(const Connections&) = delete;
  Connections& operator=(const Connections&) = delete;

  /// Returns a seat for a connection from this address; it must not outlive this object. Null if there is no
  /// room; `problem` then has the reason for the client.
  std::shared_ptr<Seat> admit(const std::string& address, bool is_trusted, std::string& problem);

 private:
  enum class State { kWaits, kWorks, kSends, kStays };

  // With mutex_ held:
  std::size_t count(const std::function<bool(const Seat&)>& which) const;
  /// Null if no network with at least `min_of_network` connections has a connection that can be closed.
  /// `patience_s`: how long sending an answer may take.
  Seat* most_dispensable(const std::function<bool(const Seat&)>& which, double patience_s,
                         std::size_t min_of_network) const;
  /// Null if no connection has stalled for `patience_s`.
  Seat* slowest(const std::function<bool(const Seat&)>& which, double patience_s,
                std::size_t min_bytes_of_network) const;
  std::function<void()> leave(Seat& seat);  // returns a function that closes it: call without mutex_
  void count_in(Seat& seat);
  void count_out(Seat& seat);
  void set_unsent_bytes(Seat& seat, std::size_t bytes);

  /// Sums over seats. `large_bytes`: waiting bytes of the seats that hold more than kAlwaysSentBytes.
  struct Sums {
    std::size_t seats = 0, large_bytes = 0;
  };
  using Groups = std::map<std::pair<std::string, bool>, Sums>;  // by network, and whether it is trusted
  Sums& all_of(bool is_trusted) { return is_trusted ? trusted_ : strangers_; }

  const std::size_t max_;
  const Clock now_s_;
  std::atomic<std::uint64_t>& unsent_;
  mutable std::mutex mutex_;  // guards the members below and those of the seats
  std::list<Seat*> seats_;    // ordered: longest in its state first
  Groups groups_;             // sums over seats_, by network
  Sums strangers_, trusted_;  // sums over seats_
};

/// One connection's seat. It counts until it is destroyed or asked to close.
class Connections::Seat : public std::enable_shared_from_this<Connections::Seat> {
 public:
  Seat(Connections& connections, std::string network, bool is_trusted);
  ~Seat();
  Seat(const Seat&) = delete;
  Seat& operator=(const Seat&) = delete;

  /// Sets the function that closes this connection to make room for another one. It is called from within
  /// admit() or another seat's holds() and must not destroy the seat.
  void closes_by(std::function<void()> close);

  /// Set the connection's state:
  void waits() { is(State::kWaits); }  // for a request, or for the rest of a request
  void works() { is(State::kWorks); }  // the request is being handled
  void sends() { is(State::kSends); }  // the answer is being sent

  /// Asks to stay open as a viewer. False if there are too many viewers, with the reason in `problem`.
  bool stays(bool is_trusted, std::string& problem);

  /// Sets the number of bytes of memory for data that the client is still receiving or sending. May close
  /// other connections. False if the number would grow beyond a limit: nothing has changed then, and
  /// `problem` has the reason.
  bool holds(std::size_t bytes, std::string& problem);
  /// Records that the client received or sent some of these bytes.
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
  double unmoved_since_s_ = 0;  // since then, the client has transferred nothing
  std::function<void()> close_;
  std::list<Seat*>::iterator place_;
  Groups::iterator group_;
  bool is_counted_ = true;
};

}  // namespace sslv
