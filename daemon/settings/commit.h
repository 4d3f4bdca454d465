// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <type_traits>
#include <utility>

namespace sslv {

/// Makes a prepared change take effect. All that can fail or takes long was done when it was prepared, so it
/// cannot fail. One that is never called undoes, when it is destroyed, what was prepared.
class Commit {
 public:
  /// Nothing to do.
  Commit() = default;

  template <class Act>
  requires(!std::is_same_v<std::remove_cvref_t<Act>, Commit>) Commit(Act act)
      : act_(std::make_unique<Held<Act>>(std::move(act))) {
    static_assert(std::is_nothrow_invocable_v<Act&>, "what commits a change must be noexcept");
  }

  void operator()() noexcept {
    if (act_) act_->call();
  }

 private:
  struct Base {
    virtual ~Base() = default;
    virtual void call() noexcept = 0;
  };
  template <class Act>
  struct Held final : Base {
    explicit Held(Act held) : act(std::move(held)) {}
    void call() noexcept override { act(); }
    Act act;
  };
  std::unique_ptr<Base> act_;
};

}  // namespace sslv
