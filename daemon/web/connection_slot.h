// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>

namespace sslv {

/// Counts one open connection for as long as it lives. The counter must outlive it.
class ConnectionSlot {
 public:
  explicit ConnectionSlot(std::atomic<int>& open) : open_(&open) { ++open; }

 private:
  struct CountDown {
    void operator()(std::atomic<int>* open) const { --*open; }
  };
  std::unique_ptr<std::atomic<int>, CountDown> open_;
};

}  // namespace sslv
