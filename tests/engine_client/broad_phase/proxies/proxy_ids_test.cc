// ProxyIds must give the lowest free id, like a sorted set of all free ids.
#include "engine_client/broad_phase/proxies/proxy_ids.h"

#include <gtest/gtest.h>

#include <map>
#include <vector>

#include "engine_client/scene/random.h"

namespace sweepstake {
namespace {

constexpr uint32_t kIdsPerPage = ProxyIds::kPageIds;

// The ids in use, and their rows.
using ListedIds = std::map<uint32_t, uint32_t>;

uint32_t LowestFree(const ListedIds& listed) {
  uint32_t lowest = 0;
  for (const auto& [id, row] : listed) {
    if (id != lowest) break;
    ++lowest;
  }
  return lowest;
}

uint32_t AddId(ProxyIds& ids, uint32_t row) {
  const uint32_t id = ids.LowestFree();
  ids.Take(id, row);
  return id;
}

TEST(ProxyIdsTest, GiveTheLowestFreeIdInARandomGame) {
  SequentialRandom random(3);
  ProxyIds ids;
  ListedIds listed;
  for (uint32_t step = 0; step < 400; ++step) {
    const bool grows = step / 40 % 2 == 0;
    for (uint32_t k = 0; k < 200; ++k) {
      if (listed.empty() || random.Below(4) < (grows ? 3U : 1U)) {
        const uint32_t expected = LowestFree(listed);
        ASSERT_EQ(AddId(ids, step), expected);
        listed[expected] = step;
      } else {
        auto any = listed.lower_bound(static_cast<uint32_t>(random.Below(6 * kIdsPerPage)));
        if (any == listed.end()) any = listed.begin();
        ids.Free(any->first);
        listed.erase(any);
      }
    }
    if (step % 7 == 0) ids.FreeUnused();
    for (uint32_t id = 0; id < 6 * kIdsPerPage; ++id) {
      const auto found = listed.find(id);
      ASSERT_EQ(ids.row(id), found == listed.end() ? ProxyIds::kNoRow : found->second);
    }
  }
  EXPECT_EQ(ids.row(ProxyIds::kMaxIds), ProxyIds::kNoRow);
  EXPECT_EQ(ids.row(~0U), ProxyIds::kNoRow);
}

TEST(ProxyIdsTest, FreePagesThatWereNotUsedSinceTheLastTime) {
  ProxyIds ids;
  for (uint32_t k = 0; k < kIdsPerPage; ++k) AddId(ids, k);
  ids.FreeUnused();
  const size_t bytes = ids.native_bytes();
  for (uint32_t k = 0; k < 300 * kIdsPerPage; ++k) AddId(ids, k);
  const uint32_t last = 301 * kIdsPerPage - 1;
  for (uint32_t id = kIdsPerPage; id < last; ++id) ids.Free(id);
  const size_t full = ids.native_bytes();
  ids.FreeUnused();
  EXPECT_EQ(ids.native_bytes(), full);
  ids.FreeUnused();
  EXPECT_LE(ids.native_bytes(), bytes + 5000 + 512 * 16);  // the page of the last id, and the list
  EXPECT_EQ(ids.row(last), 300 * kIdsPerPage - 1);
  EXPECT_EQ(AddId(ids, 9), kIdsPerPage);
  ids.Free(kIdsPerPage);
  ids.Free(last);
  ids.FreeUnused();
  ids.FreeUnused();
  EXPECT_LE(ids.native_bytes(), bytes + 1024);
  EXPECT_EQ(AddId(ids, 9), kIdsPerPage);
}

TEST(ProxyIdsTest, CanBeAssignedAgain) {
  constexpr uint32_t kBit = 0x80000000;
  ProxyIds ids;
  for (uint32_t k = 0; k < 2 * kIdsPerPage; ++k) AddId(ids, k);
  ids.Assign(std::vector<uint32_t>{kBit | 200 * kIdsPerPage, ProxyIds::kNoId, kBit}, kBit);
  EXPECT_EQ(ids.row(5), ProxyIds::kNoRow);
  EXPECT_EQ(ids.row(0), 2U);
  EXPECT_EQ(ids.row(200 * kIdsPerPage), 0U);
  for (uint32_t id = 1; id < 3 * kIdsPerPage; ++id) ASSERT_EQ(AddId(ids, 1), id);
  std::vector<uint32_t> full;
  for (uint32_t k = 0; k < kIdsPerPage; ++k) full.push_back(k);
  ids.Assign(full, 0);
  EXPECT_EQ(ids.row(200 * kIdsPerPage), ProxyIds::kNoRow);
  EXPECT_EQ(AddId(ids, 1), kIdsPerPage);
}

}  // namespace
}  // namespace sweepstake
