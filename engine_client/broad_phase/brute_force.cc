#include "engine_client/broad_phase/brute_force.h"

#include <numeric>

#include "engine_client/broad_phase/common/byte_scan.h"
#include "engine_client/broad_phase/common/parallel.h"

namespace sweepstake {
namespace {

// The minimum number of items per part of a parallel loop. Fewer items take less time than waking a
// thread for them.
constexpr size_t kMinRowsPerPart = 512;
constexpr size_t kMinBoxesPerPart = 2048;

class BruteForce final : public BroadPhase {
 public:
  explicit BruteForce(const BroadPhaseOptions& options) : executor_(options.executor) {}
  std::string_view name() const override { return "BruteForce"; }
  uint32_t version() const override { return 4; }
  void DoBuild(std::span<const Aabb> boxes) override {
    pair_count_ = 0;
    Load(boxes);
  }
  void DoUpdate(std::span<const Aabb> boxes) override { Load(boxes); }
  void DoFindPairs(PairBuffer& out) override;
  uint64_t aabb_check_count() const override { return checks_; }
  size_t native_bytes() const override { return boxes_.native_bytes() + parts_.native_bytes(); }

 private:
  void Load(std::span<const Aabb> boxes);

  Executor* executor_;
  ByteBoxes boxes_;  // the box with id k is in slot k
  PairParts parts_;
  size_t pair_count_ = 0;  // the number of pairs of the latest search
  uint64_t checks_ = 0;
};

void BruteForce::Load(std::span<const Aabb> boxes) {
  checks_ = 0;
  boxes_.Resize(boxes.size(), false);
  std::iota(boxes_.ids(), boxes_.ids() + boxes.size(), 0U);
  const CoordinateRange range = CoordinateRange::Sample(boxes);
  const size_t part_count = PartCount(executor_, boxes.size(), kMinBoxesPerPart);
  RunParts(executor_, part_count, [&](size_t part) {
    const PartRange slots = RangeOfPart(boxes.size(), part, part_count, ByteBoxes::kGranule);
    ForEachBlock(stop(), slots.begin, slots.end,
                 [&](size_t from, size_t to) { boxes_.Fill(boxes, range, {}, from, to); });
  });
}

void BruteForce::DoFindPairs(PairBuffer& out) {
  const ByteLanes lanes = boxes_.Lanes();
  const size_t before = out.size();
  checks_ = parts_.Run(
      executor_, lanes.count, kMinRowsPerPart, kRowsPerTile, out,
      [&](size_t begin, size_t end, PairBuffer& pairs) {
        return FindPairsOfAll(lanes, begin, end, pair_count_, pairs, stop());
      },
      stop());
  pair_count_ = out.size() - before;
}

}  // namespace

std::unique_ptr<BroadPhase> MakeBruteForce(const BroadPhaseOptions& options) {
  return std::make_unique<BruteForce>(options);
}

}  // namespace sweepstake
