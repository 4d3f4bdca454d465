// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace sslv {

struct Column {
  std::string title;
  bool is_number = false;  // right-aligned
};

/// A table for a terminal: columns as wide as their widest cell, two spaces apart, under a line of titles.
std::string table_text(const std::vector<Column>& columns, const std::vector<std::vector<std::string>>& rows);

/// Unix time in seconds as local time.
std::string local_time_text(double unix_s);

}  // namespace sslv
