// Queries one set on several threads at the same time. Their results reveal most errors of shared
// state; ThreadSanitizer finds the rest.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

#include "sweepstake/c_api.h"

namespace {

constexpr uint32_t kCount = 400;
constexpr int kThreads = 4;
constexpr int kRounds = 50;

// Returns a row of unit boxes along x; every second one is static, and each touches the next.
std::vector<swp_aabb> Row() {
  std::vector<swp_aabb> boxes;
  for (uint32_t i = 0; i < kCount; ++i) {
    const auto x = static_cast<float>(i);
    boxes.push_back({{x, 0, 0}, {x + 1, 1, 1}});
  }
  return boxes;
}

struct Answers {
  std::vector<swp_proxy> found;
  std::vector<uint64_t> ends;
  std::vector<swp_ray_hit> nearest;
  std::vector<swp_ray_hit> all;
};

bool operator==(const Answers& a, const Answers& b) {
  const auto same_hits = [](const std::vector<swp_ray_hit>& x, const std::vector<swp_ray_hit>& y) {
    return std::equal(x.begin(), x.end(), y.begin(), y.end(),
                      [](const swp_ray_hit& one, const swp_ray_hit& other) {
                        return one.proxy == other.proxy && one.distance == other.distance;
                      });
  };
  return a.found == b.found && a.ends == b.ends && same_hits(a.nearest, b.nearest) &&
         same_hits(a.all, b.all);
}

Answers AskAll(const swp_proxies* proxies, const std::vector<swp_aabb>& boxes) {
  Answers answers;
  answers.found.resize(3 * kCount);
  answers.ends.resize(kCount);
  answers.nearest.resize(kCount);
  answers.all.resize(kCount);
  EXPECT_EQ(swp_proxies_query_boxes(proxies, boxes.data(), kCount, nullptr, answers.found.data(),
                                    answers.found.size(), answers.ends.data()),
            SWP_OK);
  std::vector<swp_ray> rays;
  for (const swp_aabb& box : boxes) {
    rays.push_back({{box.min[0] + 0.5F, -1, 0.5F}, {0, 1, 0}, 10});
  }
  EXPECT_EQ(swp_proxies_cast_rays(proxies, rays.data(), kCount, nullptr, answers.nearest.data()),
            SWP_OK);
  const swp_ray along = {{-1, 0.5F, 0.5F}, {1, 0, 0}, 10.0F * kCount};
  uint64_t count = 0;
  EXPECT_EQ(swp_proxies_cast_ray(proxies, &along, nullptr, answers.all.data(), answers.all.size(),
                                 &count),
            SWP_OK);
  answers.all.resize(count);
  return answers;
}

TEST(ParallelQueriesTest, EachThreadGetsTheResultsOfOneThreadAlone) {
  const std::vector<swp_aabb> boxes = Row();
  std::vector<swp_proxy_options> options(kCount, {{1, ~0U}, 0, 0, 0});
  for (uint32_t i = 0; i < kCount; i += 2) options[i].flags = SWP_PROXY_STATIC;
  std::vector<swp_proxy> added(kCount);
  swp_proxies* proxies = nullptr;
  ASSERT_EQ(swp_proxies_create(nullptr, &proxies), SWP_OK);
  ASSERT_EQ(swp_proxies_add_many(proxies, boxes.data(), options.data(), kCount, added.data()),
            SWP_OK);
  ASSERT_EQ(swp_proxies_prepare_queries(proxies), SWP_OK);
  const Answers alone = AskAll(proxies, boxes);
  EXPECT_EQ(alone.ends.back(), 3 * kCount - 2);
  EXPECT_EQ(alone.all.size(), kCount);
  EXPECT_EQ(alone.nearest[7].proxy, added[7]);
  std::atomic<int> begun_count = 0;
  std::atomic<int> wrong_count = 0;
  std::vector<std::thread> threads;
  for (int k = 0; k < kThreads; ++k) {
    threads.emplace_back([&] {
      ++begun_count;
      while (begun_count < kThreads) std::this_thread::yield();
      for (int round = 0; round < kRounds; ++round) {
        if (!(AskAll(proxies, boxes) == alone)) ++wrong_count;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong_count, 0);
  swp_proxies_destroy(proxies);
}

}  // namespace
