// SPDX-License-Identifier: Apache-2.0
#include "colors/margins_json.h"

namespace sslv {

Json margins_json(std::span<const LabelMargin> margins, const LabelSet& labels) {
  Json out = Json::array();
  for (const LabelMargin& margin : margins) {
    out.push_back({{"label", labels.name(margin.label)},
                   {"surface", name_of(margin.surface)},
                   {"brighter", margin.brighter ? Json(*margin.brighter - 1) : Json(nullptr)},
                   {"darker", margin.darker ? Json(1 - *margin.darker) : Json(nullptr)}});
  }
  return out;
}

}  // namespace sslv
