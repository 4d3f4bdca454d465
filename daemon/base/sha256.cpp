// SPDX-License-Identifier: Apache-2.0
#include "base/sha256.h"

#include <memory>

#include <glib.h>

namespace sslv {

std::string sha256_of(std::string_view bytes) {
  const std::unique_ptr<gchar, decltype(&g_free)> hash(
      g_compute_checksum_for_data(G_CHECKSUM_SHA256, reinterpret_cast<const guchar*>(bytes.data()),
                                  bytes.size()),
      &g_free);
  return hash.get();
}

}  // namespace sslv
