#include "tests/support/pair_oracle.h"

#include <algorithm>
#include <iterator>

namespace sweepstake::test_support {
namespace {

void Describe(const char* what, const std::vector<OverlapPair>& pairs, std::string& text) {
  constexpr size_t kShown = 4;
  if (pairs.empty()) return;
  text += std::to_string(pairs.size()) + ' ' + what + ':';
  for (size_t i = 0; i < std::min(kShown, pairs.size()); ++i) {
    text += " (" + std::to_string(pairs[i].a) + ", " + std::to_string(pairs[i].b) + ")";
  }
  text += "; ";
}

}  // namespace

std::vector<OverlapPair> ScalarPairs(std::span<const Aabb> boxes) {
  std::vector<OverlapPair> pairs;
  for (uint32_t a = 0; a < boxes.size(); ++a) {
    for (uint32_t b = a + 1; b < boxes.size(); ++b) {
      if (Overlap(boxes[a], boxes[b])) pairs.push_back({a, b});
    }
  }
  return pairs;
}

std::vector<OverlapPair> Sorted(std::span<const OverlapPair> pairs) {
  std::vector<OverlapPair> sorted(pairs.begin(), pairs.end());
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

std::string PairDifference(std::span<const OverlapPair> found,
                           std::span<const OverlapPair> expected) {
  const std::vector<OverlapPair> sorted = Sorted(found);
  std::vector<OverlapPair> missing;
  std::vector<OverlapPair> surplus;
  std::set_difference(expected.begin(), expected.end(), sorted.begin(), sorted.end(),
                      std::back_inserter(missing));
  std::set_difference(sorted.begin(), sorted.end(), expected.begin(), expected.end(),
                      std::back_inserter(surplus));
  std::string text;
  Describe("missing", missing, text);
  Describe("surplus, duplicate or not a < b", surplus, text);
  return text;
}

}  // namespace sweepstake::test_support
