// SPDX-License-Identifier: Apache-2.0
#include "web/connections.h"

#include "web/http.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace sslv {
namespace {

// Shares of all connections, as divisors: at most 1/2 for one address, 1/2 for all untrusted viewers, 1/4 for
// the viewers of one address; 1/8 is reserved for trusted addresses.
constexpr std::size_t kPartOfAddress = 2, kPartOfViewers = 2, kPartOfAddressViewers = 4, kPartKept = 8;
// An address has many connections if it has 1/16 of all: more than one person's browser needs.
constexpr std::size_t kPartThatIsMany = 16;
/// An address holds much memory if it holds 1/4 of the bytes that may wait.
constexpr std::size_t kPartOfUnsentThatIsMany = 4;

std::size_t part(std::size_t max, std::size_t of) {
  return std::max<std::size_t>(1, max / of);
}

std::size_t if_large(std::size_t bytes) {
  return bytes > Connections::kAlwaysSentBytes ? bytes : 0;
}

}  // namespace

Connections::Connections(int max, Clock now_s, std::atomic<std::uint64_t>& unsent)
    : max_(static_cast<std::size_t>(max)), now_s_(std::move(now_s)), unsent_(unsent) {}

std::shared_ptr<Connections::Seat> Connections::admit(const std::string& address, bool is_trusted,
                                                      std::string& problem) {
  const std::string network = network_of(address);
  std::function<void()> close;
  std::shared_ptr<Seat> seat;
  {
    const std::lock_guard lock(mutex_);
    const auto all = [](const Seat&) { return true; };
    const auto strangers = [](const Seat& one) { return !one.is_trusted_; };
    const auto neighbours = [&](const Seat& one) { return !one.is_trusted_ && one.network_ == network; };
    std::function<bool(const Seat&)> among;  // one of these must close; empty: below all limits
    if (!is_trusted && count(neighbours) >= part(max_, kPartOfAddress)) {
      among = neighbours;
      problem = "too many connections from your address";
    } else if (!is_trusted && strangers_.seats >= max_ - max_ / kPartKept) {
      among = strangers;
      problem = "too many connections; try again later";
    } else if (seats_.size() >= max_) {
      among = all;
      problem = "too many connections; try again later";
    }
    if (among) {
      Seat* leaves = most_dispensable(among, kSendPatience_s, 1);
      if (leaves == nullptr)
        leaves = most_dispensable(among, kSendPatienceWithMany_s, part(max_, kPartThatIsMany));
      if (leaves == nullptr) return nullptr;
      close = leave(*leaves);
    }
    seat = std::make_shared<Seat>(*this, network, is_trusted);
    seat->place_ = seats_.insert(seats_.end(), seat.get());
    count_in(*seat);
  }
  if (close) close();
  return seat;
}

std::size_t Connections::count(const std::function<bool(const Seat&)>& which) const {
  return static_cast<std::size_t>(
      std::count_if(seats_.begin(), seats_.end(), [&](const Seat* seat) { return which(*seat); }));
}

Connections::Seat* Connections::most_dispensable(const std::function<bool(const Seat&)>& which,
                                                 double patience_s, std::size_t min_of_network) const {
  const double patient_since_s = now_s_() - patience_s;
  Seat* best = nullptr;
  std::size_t best_count = 0;
  for (Seat* seat : seats_) {
    const bool can_go = seat->close_ && (seat->state_ == State::kWaits ||
                                         (seat->state_ == State::kSends && seat->since_s_ < patient_since_s));
    const std::size_t neighbours = seat->group_->second.seats;
    if (!can_go || neighbours < min_of_network || neighbours <= best_count || !which(*seat)) continue;
    best = seat;
    best_count = neighbours;
  }
  return best;
}

Connections::Seat* Connections::slowest(const std::function<bool(const Seat&)>& which, double patience_s,
                                        std::size_t min_bytes_of_network) const {
  const double now_s = now_s_();
  Seat* best = nullptr;
  for (Seat* seat : seats_) {
    const std::size_t bytes = seat->group_->second.large_bytes;
    // Viewers always get the longer time: they skip images instead. A request that is being handled does not
    // wait for its client.
    const double own_patience_s = seat->state_ == State::kStays ? kSendPatience_s : patience_s;
    if (!seat->close_ || seat->state_ == State::kWorks || seat->unsent_bytes_ <= kAlwaysSentBytes ||
        seat->unmoved_since_s_ >= now_s - own_patience_s || bytes < min_bytes_of_network || !which(*seat))
      continue;
    const std::size_t most = best == nullptr ? 0 : best->group_->second.large_bytes;
    if (bytes > most || (bytes == most && seat->unmoved_since_s_ < best->unmoved_since_s_)) best = seat;
  }
  return best;
}

std::function<void()> Connections::leave(Seat& seat) {
  count_out(seat);
  seats_.erase(seat.place_);
  seat.is_counted_ = false;
  return std::move(seat.close_);
}

void Connections::count_in(Seat& seat) {
  seat.group_ = groups_.try_emplace({seat.network_, seat.is_trusted_}).first;
  for (Sums* sums : {&seat.group_->second, &all_of(seat.is_trusted_)}) {
    ++sums->seats;
    sums->large_bytes += if_large(seat.unsent_bytes_);
  }
}

void Connections::count_out(Seat& seat) {
  for (Sums* sums : {&seat.group_->second, &all_of(seat.is_trusted_)}) {
    --sums->seats;
    sums->large_bytes -= if_large(seat.unsent_bytes_);
  }
  if (seat.group_->second.seats == 0) groups_.erase(seat.group_);
}

void Connections::set_unsent_bytes(Seat& seat, std::size_t bytes) {
  if (seat.is_counted_) {
    for (Sums* sums : {&seat.group_->second, &all_of(seat.is_trusted_)})
      sums->large_bytes = sums->large_bytes - if_large(seat.unsent_bytes_) + if_large(bytes);
  }
  seat.unsent_bytes_ = bytes;
}

Connections::Seat::Seat(Connections& connections, std::string network, bool is_trusted)
    : connections_(connections),
      network_(std::move(network)),
      is_trusted_(is_trusted),
      since_s_(connections.now_s_()) {}

Connections::Seat::~Seat() {
  const std::lock_guard lock(connections_.mutex_);
  if (is_counted_) connections_.leave(*this);
}

void Connections::Seat::closes_by(std::function<void()> close) {
  const std::lock_guard lock(connections_.mutex_);
  close_ = std::move(close);
}

void Connections::Seat::is(State state) {
  const std::lock_guard lock(connections_.mutex_);
  enter(state);
}

void Connections::Seat::enter(State state) {
  state_ = state;
  since_s_ = unmoved_since_s_ = connections_.now_s_();
  if (is_counted_) connections_.seats_.splice(connections_.seats_.end(), connections_.seats_, place_);
}

bool Connections::Seat::stays(bool is_trusted, std::string& problem) {
  const std::lock_guard lock(connections_.mutex_);
  if (!is_counted_) {
    problem = "too many connections; try again later";
    return false;
  }
  if (is_trusted && !is_trusted_) {
    connections_.count_out(*this);
    is_trusted_ = true;
    connections_.count_in(*this);
  }
  if (!is_trusted_) {
    const std::size_t max = connections_.max_;
    const auto viewers = [](const Seat& one) { return one.state_ == State::kStays && !one.is_trusted_; };
    const auto neighbours = [&](const Seat& one) { return viewers(one) && one.network_ == network_; };
    if (connections_.count(neighbours) >= part(max, kPartOfAddressViewers)) {
      problem = "too many viewers from your address";
      return false;
    }
    if (connections_.count(viewers) >= part(max, kPartOfViewers)) {
      problem = "too many viewers; try again later";
      return false;
    }
  }
  enter(State::kStays);
  return true;
}

bool Connections::Seat::holds(std::size_t bytes, std::string& problem) {
  std::vector<std::function<void()>> closed;
  bool fits = true;
  {
    const std::lock_guard lock(connections_.mutex_);
    const std::size_t before = unsent_bytes_;
    if (bytes > before && bytes > kAlwaysSentBytes) {
      const auto peers = [this](const Seat& one) { return &one != this && one.is_trusted_ == is_trusted_; };
      const auto neighbours = [&](const Seat& one) { return peers(one) && one.network_ == network_; };
      const auto make_room = [&](const Sums& sums, const auto& among, std::size_t max) {
        for (;;) {
          // A single large answer is always sent, however large it is.
          const std::size_t others = sums.large_bytes - if_large(before);
          if (others == 0 || others + bytes <= max) return true;
          Seat* slow = connections_.slowest(among, kSendPatience_s, 0);
          if (slow == nullptr)
            slow = connections_.slowest(among, kSendPatienceWithMany_s, max / kPartOfUnsentThatIsMany);
          if (slow == nullptr) return false;
          ++connections_.unsent_;
          closed.push_back(connections_.leave(*slow));
        }
      };
      fits = is_counted_ &&
             (is_trusted_ || make_room(group_->second, neighbours, kMaxUnsentBytesOfAddress)) &&
             make_room(connections_.all_of(is_trusted_), peers,
                       is_trusted_ ? kMaxUnsentBytesOfTrusted : kMaxUnsentBytes);
    }
    if (fits) {
      if (before == 0) unmoved_since_s_ = connections_.now_s_();
      connections_.set_unsent_bytes(*this, bytes);
    } else {
      ++connections_.unsent_;
      problem = "too much data is waiting for slow clients; try again in a moment";
    }
  }
  for (const auto& close : closed) close();
  return fits;
}

void Connections::Seat::makes_progress() {
  const std::lock_guard lock(connections_.mutex_);
  unmoved_since_s_ = connections_.now_s_();
}

}  // namespace sslv
