// SPDX-License-Identifier: Apache-2.0
#include "web/connections.h"

#include "web/http.h"

#include <algorithm>
#include <map>
#include <utility>

namespace sslv {
namespace {

// Of all connections. One address may have half of what there is, one address' viewers a quarter, all
// strangers' viewers half, and strangers all but an eighth.
constexpr std::size_t kPartOfAddress = 2, kPartOfViewers = 2, kPartOfAddressViewers = 4, kPartKept = 8;
// An address with so many connections is not one person's browser.
constexpr std::size_t kPartThatIsMany = 16;

std::size_t part(std::size_t max, std::size_t of) {
  return std::max<std::size_t>(1, max / of);
}

}  // namespace

Connections::Connections(int max, Clock now_s)
    : max_(static_cast<std::size_t>(max)), now_s_(std::move(now_s)) {}

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
    std::function<bool(const Seat&)> among;  // one of these must go; none: there is room
    if (!is_trusted && count(neighbours) >= part(max_, kPartOfAddress)) {
      among = neighbours;
      problem = "too many connections from your address";
    } else if (!is_trusted && count(strangers) >= max_ - max_ / kPartKept) {
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
      seats_.erase(leaves->place_);
      leaves->is_counted_ = false;
      close = std::move(leaves->close_);
    }
    seat = std::make_shared<Seat>(*this, network, is_trusted);
    seat->place_ = seats_.insert(seats_.end(), seat.get());
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
  std::map<std::string, std::size_t> of_network;
  for (const Seat* seat : seats_) ++of_network[seat->network_];
  const double patient_since_s = now_s_() - patience_s;
  Seat* best = nullptr;
  std::size_t best_count = 0;
  for (Seat* seat : seats_) {
    const bool can_go = seat->close_ && (seat->state_ == State::kWaits ||
                                         (seat->state_ == State::kSends && seat->since_s_ < patient_since_s));
    const std::size_t neighbours = of_network[seat->network_];
    if (!can_go || neighbours < min_of_network || neighbours <= best_count || !which(*seat)) continue;
    best = seat;
    best_count = neighbours;
  }
  return best;
}

Connections::Seat::Seat(Connections& connections, std::string network, bool is_trusted)
    : connections_(connections),
      network_(std::move(network)),
      is_trusted_(is_trusted),
      since_s_(connections.now_s_()) {}

Connections::Seat::~Seat() {
  const std::lock_guard lock(connections_.mutex_);
  if (is_counted_) connections_.seats_.erase(place_);
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
  since_s_ = connections_.now_s_();
  if (is_counted_) connections_.seats_.splice(connections_.seats_.end(), connections_.seats_, place_);
}

bool Connections::Seat::stays(bool is_trusted, std::string& problem) {
  const std::lock_guard lock(connections_.mutex_);
  if (!is_counted_) {
    problem = "too many connections; try again later";
    return false;
  }
  is_trusted_ = is_trusted_ || is_trusted;
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

}  // namespace sslv
