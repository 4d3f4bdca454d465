// SPDX-License-Identifier: Apache-2.0
#include "base/json.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace sslv {

std::string json_text(const Json& value, int indent) {
  return value.dump(indent, ' ', false, Json::error_handler_t::replace);
}

std::string reason_of(const Json::exception& error) {
  const std::string what = error.what();  // "[json.exception.parse_error.101] parse error at ..."
  const auto end = what.find("] ");
  return end == std::string::npos ? what : what.substr(end + 2);
}

bool is_utf8(const Json& value) {
  try {
    static_cast<void>(value.dump());
    return true;
  } catch (const Json::type_error&) {
    return false;
  }
}

Json parse_own_json(std::string_view text) {
  return Json::parse(text);
}

JsonExtent extent_of(const Json& value, std::size_t max_size) {
  JsonExtent out;
  std::vector<std::pair<const Json*, std::size_t>> left{{&value, 1}};
  while (!left.empty() && out.size <= max_size) {
    const auto [at, depth] = left.back();
    left.pop_back();
    out.depth = std::max(out.depth, depth);
    ++out.size;
    if (at->is_string()) {
      out.size += at->get_ref<const std::string&>().size();
    } else if (at->is_array()) {
      for (const Json& one : *at) left.emplace_back(&one, depth + 1);
    } else if (at->is_object()) {
      for (const auto& [key, one] : at->items()) {
        out.size += key.size();
        left.emplace_back(&one, depth + 1);
      }
    }
  }
  return out;
}

namespace {

/// Estimates the memory of the parsed text. (With a callback, the library's parser searches a whole list
/// again for each of its objects: parsing a megabyte of `{},` took a minute.)
class JsonCount final : public nlohmann::json_sax<Json> {
 public:
  explicit JsonCount(std::size_t max_bytes) : max_bytes_(max_bytes) {}

  bool null() override { return add(kBytesOfValue); }
  bool boolean(bool /*value*/) override { return add(kBytesOfValue); }
  bool number_integer(number_integer_t /*value*/) override { return add(kBytesOfValue); }
  bool number_unsigned(number_unsigned_t /*value*/) override { return add(kBytesOfValue); }
  bool number_float(number_float_t /*value*/, const string_t& /*text*/) override {
    return add(kBytesOfValue);
  }
  bool string(string_t& value) override { return add(kBytesOfValue + kBytesOfText + value.size()); }
  bool binary(binary_t& value) override { return add(kBytesOfValue + value.size()); }
  bool start_object(std::size_t /*size*/) override {
    add(kBytesOfValue + kBytesOfList);
    keys_[++depth_] = 0;
    return true;
  }
  bool key(string_t& name) override {
    if (++keys_[depth_] > kMaxKeys)
      throw std::length_error("JSON with more than " + std::to_string(kMaxKeys) + " keys in an object");
    return add(kBytesOfKey + name.size());
  }
  bool end_object() override { return end_array(); }
  bool start_array(std::size_t /*size*/) override {
    add(kBytesOfValue + kBytesOfList);
    ++depth_;
    return true;
  }
  bool end_array() override {
    --depth_;
    return true;
  }
  bool parse_error(std::size_t /*place*/, const std::string& /*token*/,
                   const nlohmann::detail::exception& /*error*/) override {
    return false;  // the parser that follows reports the error
  }

 private:
  static constexpr std::size_t kMaxDepth = 64;
  static constexpr int kMaxKeys = 1000;
  // Roughly the library's allocations: a few bytes of text, "[],", become a hundred bytes in memory.
  static constexpr std::size_t kBytesOfValue = 32, kBytesOfText = 32, kBytesOfKey = 48, kBytesOfList = 32;

  bool add(std::size_t bytes) {
    if (depth_ > kMaxDepth)
      throw std::length_error("JSON nested deeper than " + std::to_string(kMaxDepth) + " levels");
    bytes_ += bytes;
    if (bytes_ > max_bytes_)
      throw std::length_error("JSON that takes more than " + std::to_string(max_bytes_ >> 20U) +
                              " MiB of memory");
    return true;
  }

  const std::size_t max_bytes_;
  std::size_t bytes_ = 0, depth_ = 0;
  std::array<int, kMaxDepth + 2> keys_{};
};

}  // namespace

Json parse_bounded_json(std::string_view text, std::size_t max_bytes) {
  JsonCount count(max_bytes);
  Json::sax_parse(text, &count);
  return parse_own_json(text);
}

}  // namespace sslv
