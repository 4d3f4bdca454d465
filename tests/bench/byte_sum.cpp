// SPDX-License-Identifier: Apache-2.0
#include "byte_sum.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "byte_sum.cpp"
#include <hwy/foreach_target.h>
// Must follow foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sslv::bench {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

std::uint64_t ByteSum(const std::uint8_t* data, std::size_t size) {
  std::size_t i = 0;
  std::uint64_t total = 0;
#if HWY_TARGET != HWY_SCALAR
  const hn::ScalableTag<std::uint8_t> d;
  const hn::Repartition<std::uint64_t, decltype(d)> d64;
  const std::size_t lanes = hn::Lanes(d);
  auto sum0 = hn::Zero(d64), sum1 = sum0, sum2 = sum0, sum3 = sum0;
  for (; i + 4 * lanes <= size; i += 4 * lanes) {
    sum0 = hn::Add(sum0, hn::SumsOf8(hn::LoadU(d, data + i)));
    sum1 = hn::Add(sum1, hn::SumsOf8(hn::LoadU(d, data + i + lanes)));
    sum2 = hn::Add(sum2, hn::SumsOf8(hn::LoadU(d, data + i + 2 * lanes)));
    sum3 = hn::Add(sum3, hn::SumsOf8(hn::LoadU(d, data + i + 3 * lanes)));
  }
  total = hn::GetLane(hn::SumOfLanes(d64, hn::Add(hn::Add(sum0, sum1), hn::Add(sum2, sum3))));
#endif
  for (; i < size; ++i) total += data[i];
  return total;
}

}  // namespace HWY_NAMESPACE
}  // namespace sslv::bench
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sslv::bench {

HWY_EXPORT(ByteSum);

std::uint64_t byte_sum(const std::uint8_t* data, std::size_t size) {
  return HWY_DYNAMIC_DISPATCH(ByteSum)(data, size);
}

}  // namespace sslv::bench
#endif
