// SPDX-License-Identifier: Apache-2.0
#include "kit/apart/library_rows.h"

#include <stdexcept>

#include <dlfcn.h>
#include <fmt/format.h>

namespace sslv {

const StageRows& load_rows(const std::string& library) {
  void* const loaded = ::dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (loaded == nullptr) throw std::runtime_error(::dlerror());
  using Rows = const StageRows* (*)();
  const auto rows = reinterpret_cast<Rows>(::dlsym(loaded, "sslv_stages"));
  if (rows == nullptr) throw std::runtime_error(fmt::format("{}: has no stages", library));
  const StageRows* const all = rows();
  if (all == nullptr) throw std::runtime_error(fmt::format("{}: has no stages", library));
  return *all;
}

}  // namespace sslv
