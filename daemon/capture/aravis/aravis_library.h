// SPDX-License-Identifier: Apache-2.0
#pragma once

// Aravis with C++ helpers.

#include "capture/source.h"

#include <memory>
#include <string>
#include <string_view>

#include <fmt/format.h>

// The library's headers use implicit conversions.
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
  /// The camera did not answer in time. If false, the camera lacks the feature or refused the call.
  bool is_unanswered() const {
    return g_error_matches(error_, ARV_DEVICE_ERROR, ARV_DEVICE_ERROR_TIMEOUT) != FALSE ||
           g_error_matches(error_, ARV_DEVICE_ERROR, ARV_DEVICE_ERROR_NOT_CONNECTED) != FALSE;
  }
  /// Throws CaptureError if the camera did not answer, because any default value would be a guess.
  void require_answer(std::string_view label) const {
    if (is_unanswered()) throw CaptureError(fmt::format("camera \"{}\": does not answer: {}", label, text()));
  }

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
