#include "engine_client/broad_phase/brute_force.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/brute_force.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target.h.
#include "engine_client/broad_phase/overlap_kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

uint64_t TestAllPairs(const BoxLanes& lanes, PairBuffer& out) {
  return ScanAllTiles<FirstAxis::kBothSides>(lanes, out);
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {
namespace {

HWY_EXPORT(TestAllPairs);

class BruteForce final : public BroadPhase {
 public:
  explicit BruteForce(const BroadPhaseOptions& /*options*/) {}
  std::string_view name() const override { return "BruteForce"; }
  uint32_t version() const override { return 1; }
  void Build(std::span<const Aabb> boxes) override { Take(boxes); }
  void Update(std::span<const Aabb> boxes) override { Take(boxes); }
  void FindPairs(PairBuffer& out) override {
    checks_ = HWY_DYNAMIC_DISPATCH(TestAllPairs)(boxes_.Lanes(), out);
  }
  uint64_t aabb_check_count() const override { return checks_; }
  size_t native_bytes() const override { return boxes_.native_bytes(); }

 private:
  void Take(std::span<const Aabb> boxes) {
    checks_ = 0;
    boxes_.Gather(boxes);
  }

  SoaBoxes boxes_;
  uint64_t checks_ = 0;
};

}  // namespace

std::unique_ptr<BroadPhase> MakeBruteForce(const BroadPhaseOptions& options) {
  return std::make_unique<BruteForce>(options);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
