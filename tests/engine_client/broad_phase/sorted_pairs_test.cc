#include "engine_client/broad_phase/sweep/sorted_pairs.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "engine_client/scene/random.h"

namespace sweepstake {
namespace {

std::vector<OverlapPair> PairsOf(const SortedPairs& pairs) {
  return {pairs.pairs().begin(), pairs.pairs().end()};
}

TEST(SortedPairs, SortAdoptedPairs) {
  SortedPairs pairs;
  const OverlapPair found[] = {{3, 4}, {0, 9}, {3, 5}, {0, 2}, {1, 2}};
  pairs.Adopt(found, 10);
  EXPECT_EQ(PairsOf(pairs), (std::vector<OverlapPair>{{0, 2}, {0, 9}, {1, 2}, {3, 4}, {3, 5}}));
}

TEST(SortedPairs, AddAndDropTouchedPairs) {
  SortedPairs pairs;
  const OverlapPair found[] = {{0, 2}, {1, 2}, {3, 4}};
  pairs.Adopt(found, 6);
  pairs.Touch(2, 1);  // ends
  pairs.Touch(5, 0);  // begins
  pairs.Touch(0, 5);
  pairs.Touch(3, 4);  // stays
  pairs.Touch(2, 3);  // this is not a pair, before or after
  pairs.Settle([](uint32_t a, uint32_t b) { return (a == 0 && b == 5) || a == 3; });
  EXPECT_EQ(PairsOf(pairs), (std::vector<OverlapPair>{{0, 2}, {0, 5}, {3, 4}}));
}

// Requests a stop at one of the checks.
class StopAt final : public StopRequest {
 public:
  explicit StopAt(uint64_t question) : question_(question) {}
  bool WantsStop(uint64_t, uint64_t) noexcept override { return ++asked >= question_; }

  uint64_t asked = 0;

 private:
  const uint64_t question_;
};

TEST(SortedPairs, TestForAStopInEachBlockOfMarks) {
  constexpr size_t kBlocks = 4;
  constexpr size_t kMarks = kBlocks * kBoxesPerQuestion;
  for (const uint64_t stop_at : {uint64_t{1000}, uint64_t{1}, uint64_t{3 * kBlocks}}) {
    SortedPairs pairs;
    pairs.Adopt({}, kMarks + 1);
    for (size_t k = kMarks; k > 0; --k) {
      pairs.Touch(static_cast<uint32_t>(k), static_cast<uint32_t>(k - 1));
    }
    StopAt stop(stop_at);
    pairs.Settle([](uint32_t a, uint32_t) { return a % 2 == 0; }, &stop);
    if (stop_at < 1000) {
      EXPECT_LE(stop.asked, stop_at + 2) << "Settle must end soon after the stop";
    } else {
      EXPECT_EQ(pairs.pairs().size(), kMarks / 2);
      // Stop tests happen in two passes of the sort, in grouping, in the test of each mark, and
      // while half of the pairs are inserted.
      EXPECT_GE(stop.asked, 4 * kBlocks);
    }
  }
}

TEST(SortedPairs, DropPairsOfRemovedObjects) {
  SortedPairs pairs;
  const OverlapPair found[] = {{0, 2}, {1, 5}, {3, 4}};
  pairs.Adopt(found, 6);
  pairs.Truncate(5);
  EXPECT_EQ(PairsOf(pairs), (std::vector<OverlapPair>{{0, 2}, {3, 4}}));
}

TEST(SortedPairs, AgreeWithAnOrderedSetOverManyChanges) {
  SequentialRandom random(3);
  SortedPairs pairs;
  pairs.Adopt({}, 40);
  std::set<OverlapPair> expected;
  for (int frame = 0; frame < 2000; ++frame) {
    for (size_t change = random.Below(30); change > 0; --change) {
      const auto a = static_cast<uint32_t>(random.Below(39));
      const auto b = a + 1 + static_cast<uint32_t>(random.Below(39 - a));
      const OverlapPair pair{a, b};
      if (!expected.erase(pair)) expected.insert(pair);
      pairs.Touch(b, a);
    }
    pairs.Settle([&](uint32_t a, uint32_t b) { return expected.contains({a, b}); });
    ASSERT_EQ(PairsOf(pairs), std::vector<OverlapPair>(expected.begin(), expected.end()));
  }
}

}  // namespace
}  // namespace sweepstake
