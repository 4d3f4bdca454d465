// SPDX-License-Identifier: Apache-2.0
// Its stage is constructed once the file named in the environment exists. Prints lines continuously.
#include <cstdio>
#include <cstdlib>
#include <thread>

#include <kit/stages.h>
#include <unistd.h>

namespace {
class StartsLate {
 public:
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  StartsLate() {
    const char* const file = std::getenv("SSLV_STARTS_WITH");
    while (file != nullptr && access(file, F_OK) != 0)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  void process(const Params&, const sslv::BallList&, sslv::StageNotes& notes) noexcept {
    if (!has_printed_) std::fputs("half a line", stdout);
    std::fflush(stdout);
    has_printed_ = true;
    notes.say("has printed");
  }

 private:
  bool has_printed_ = false;
};
}  // namespace

SSLV_STAGES(sslv::stage<StartsLate>("starts_late", ""))
