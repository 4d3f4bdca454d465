// SPDX-License-Identifier: Apache-2.0
// libFuzzer: a datagram received by multicast has at worst no effect, even if its sender is named in the
// settings. An input is a sequence of datagrams, each preceded by a byte for the sender and two for the
// length. ./run test-long
#include "fuzz/expect.h"
#include "net/heard_cameras.h"
#include "net/other_visions.h"
#include "net/referee_listener.h"
#include "pipeline/validate.h"
#include "tracking/agreement.h"
#include "tracking/clocks.h"
#include "tracking/gather.h"
#include "tracking/track.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

namespace sslv {
namespace {

// Little is stored per sender and camera, but there may be many of them: an upper bound on the sizes of the
// tables that this program can observe.
constexpr std::size_t kMaxCameras = 4096;

/// The field's stack without its output.
class Field final : private FieldClock {
 public:
  void take(const ArrivedSightings& arrived, double now_s) {
    now_s_ = now_s;
    gather_.process({}, {}, *this, arrived, sightings_, left_out_);
    clocks_.process({}, sightings_, time_);
    agreement_.process({}, sightings_, time_, observations_, learnt_);
    track_.process({}, *this, {}, arrived, observations_, tracked_);
    expect(!drop_invalid(sightings_).any() && !drop_invalid(time_).any(), "what passed the door has none");
    expect(!drop_invalid(observations_).any() && !drop_invalid(tracked_).any(), "tracks without sense");
    expect(learnt_.repaired() + tracked_.repaired == 0, "a filter that is no number");
  }

 private:
  double now_s() const noexcept override { return now_s_; }

  double now_s_ = 0;
  Gather gather_;
  Clocks clocks_;
  Agreement agreement_;
  Track track_;
  CameraSightings sightings_;
  LeftOut left_out_;
  ImageTime time_;
  Observations observations_;
  CameraAgreement learnt_;
  TrackedField tracked_;
};

struct Listeners {
  Listeners() { visions.set_named({"192.0.2.0", "192.0.2.1"}); }
  void hear(const VisionMessage& message, const std::string& address, bool is_named, double now_s) {
    if (cameras.hear(message, address, is_named, now_s, now_s, arrived)) field.take(arrived, now_s);
  }
  HeardCameras cameras;
  ArrivedSightings arrived;
  Field field;
  OtherVisions visions{[](const auto&) { return false; }, [](auto, double) {},
                       [this](const VisionMessage& message, const std::string& address, bool is_named,
                              double now_s) { hear(message, address, is_named, now_s); }};
  RefereeListener referee{[] {}};
};

void check(const Listeners& listeners, double now_s) {
  for (const OtherVision& other : listeners.visions.seen(now_s)) {
    expect(other.cameras.size() <= kMaxCameras, "a table of cameras without bounds");
    expect(!other.address.empty() && other.silent_s >= 0, "a vision without an address");
    if (!other.field) continue;
    for (const SizeConflict& conflict : size_conflicts(*other.field, *other.field))
      expect(std::isfinite(conflict.ours), "a size that is no number");
  }
  expect(listeners.cameras.cameras(now_s).size() <= 256 &&
             listeners.cameras.conflicts(now_s).size() <= kMaxCameras,
         "tables of cameras without bounds");
  const RefereeStatus status = listeners.referee.status(now_s);
  for (const std::string& name : status.team_names) expect(name.size() <= 65'535, "a name that is too long");
}

}  // namespace
}  // namespace sslv

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace sslv;
  Listeners listeners;
  std::span<const std::uint8_t> rest(bytes, size);
  double now_s = 100;
  while (rest.size() >= 3) {
    const auto host = boost::asio::ip::address_v4(0xc0000200u + rest[0]);
    const std::size_t length = std::min<std::size_t>(rest[1] + 256u * rest[2], rest.size() - 3);
    const auto datagram = std::as_bytes(rest.subspan(3, length));
    listeners.visions.receive(datagram, {host, 10006}, now_s);
    listeners.referee.receive(datagram, {host, 10003}, now_s);
    check(listeners, now_s);
    now_s += 0.1;
    rest = rest.subspan(3 + length);
  }
  return 0;
}
