#include "engine_client/broad_phase/common/radix_sort.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "engine_client/broad_phase/common/box_record.h"
#include "engine_client/scene/random.h"

namespace sweepstake {
namespace {

constexpr float kMax = std::numeric_limits<float>::max();
constexpr float kDenormal = std::numeric_limits<float>::denorm_min();

TEST(SortableKey, OrdersAsFloatsDo) {
  const float ascending[] = {-kInfinity, -kMax,  -1e30F, -1,    -kDenormal, 0,
                             kDenormal,  1e-30F, 1,      1e30F, kMax,       kInfinity};
  for (size_t i = 1; i < std::size(ascending); ++i) {
    EXPECT_LT(SortableKey(ascending[i - 1]), SortableKey(ascending[i])) << ascending[i];
  }
}

TEST(SortableKey, IsTheSameForBothZeros) { EXPECT_EQ(SortableKey(-0.0F), SortableKey(0.0F)); }

std::vector<uint64_t> RandomItems(size_t count, uint64_t key_range) {
  SequentialRandom random(count);
  std::vector<uint64_t> items;
  for (size_t i = 0; i < count; ++i) {
    const auto key = static_cast<uint32_t>(random.Next() % key_range);
    const auto top_bit = static_cast<uint32_t>(random.Below(2)) << 31;
    items.push_back(PackSortItem(key, top_bit | static_cast<uint32_t>(i)));
  }
  return items;
}

std::vector<uint64_t> StablySorted(std::vector<uint64_t> items) {
  std::stable_sort(items.begin(), items.end(),
                   [](uint64_t a, uint64_t b) { return SortItemRank(a) < SortItemRank(b); });
  return items;
}

TEST(RadixSort, IsAStableSortOfAnyCountAndRange) {
  RadixSort sort;
  for (const size_t count : {0, 1, 2, 63, 64, 65, 1000, 5000}) {
    for (const uint64_t range : {uint64_t{1}, uint64_t{5}, uint64_t{3000}, uint64_t{1} << 32}) {
      const std::vector<uint64_t> items = RandomItems(count, range);
      std::ranges::copy(items, sort.Items(count).begin());
      EXPECT_TRUE(std::ranges::equal(sort.Sort(), StablySorted(items))) << count << " of " << range;
    }
  }
}

TEST(RadixSort, SortsTheStorageOfTheCaller) {
  RadixSort sort;
  for (const size_t count : {10, 1000}) {
    const std::vector<uint64_t> items = RandomItems(count, 1 << 20);
    AlignedBuffer<uint64_t> storage;
    storage.EnsureDiscarding(count);
    std::ranges::copy(items, storage.data());
    sort.Sort(storage, count);
    EXPECT_TRUE(std::ranges::equal(std::span(storage.data(), count), StablySorted(items)));
  }
}

TEST(RadixSort, CountsTheBytesItHolds) {
  RadixSort sort;
  EXPECT_EQ(sort.native_bytes(), 0U);
  std::ranges::fill(sort.Items(1000), PackSortItem(1, 1));
  sort.Sort();
  EXPECT_GE(sort.native_bytes(), 1000U * 16);
}

}  // namespace
}  // namespace sweepstake
