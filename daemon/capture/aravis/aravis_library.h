// SPDX-License-Identifier: Apache-2.0
#pragma once

// Aravis, with what C++ needs to use it.

#include <memory>
#include <string>
#include <string_view>

// The library's headers convert as C does.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wconversion"
#include <arv.h>
#pragma GCC diagnostic pop

namespace sslv {

/// Receives a call's GError.
class Failure {
 public:
  Failure() = default;
  ~Failure() { g_clear_error(&error_); }
  Failure(const Failure&) = delete;
  Failure& operator=(const Failure&) = delete;

  operator GError**() {
    g_clear_error(&error_);
    return &error_;
  }
  bool failed() const { return error_ != nullptr; }
  std::string_view text() const { return error_ != nullptr ? error_->message : "no reason given"; }

 private:
  GError* error_ = nullptr;
};

struct Unref {
  void operator()(void* object) const { g_object_unref(object); }
};
template <class T>
using Object = std::unique_ptr<T, Unref>;

inline std::string text_or_empty(const char* text) {
  return text != nullptr ? text : "";
}

}  // namespace sslv
