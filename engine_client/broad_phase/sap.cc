#include "engine_client/broad_phase/sap.h"

#include <limits>

#include "engine_client/broad_phase/radix_sort.h"
#include "engine_client/broad_phase/sweep_axis.h"
#include "engine_client/broad_phase/sweep_kernel.h"

namespace sweepstake {
namespace {

class Sap final : public BroadPhase {
 public:
  explicit Sap(const BroadPhaseOptions& /*options*/) {}
  std::string_view name() const override { return "SAP"; }
  uint32_t version() const override { return 1; }
  void Build(std::span<const Aabb> boxes) override { Update(boxes); }
  void Update(std::span<const Aabb> boxes) override;
  void FindPairs(PairBuffer& out) override { checks_ = SweepSorted(boxes_.Lanes(axis_), out); }
  uint64_t aabb_check_count() const override { return checks_; }
  size_t native_bytes() const override {
    return boxes_.native_bytes() + sort_.native_bytes() + order_.capacity_bytes();
  }

 private:
  void SortByLowerFace(std::span<const Aabb> boxes);

  RadixSort sort_;
  AlignedBuffer<uint32_t> order_;
  SoaBoxes boxes_;  // ascending lower face on axis_
  int axis_ = 0;
  uint64_t checks_ = 0;
};

void Sap::Update(std::span<const Aabb> boxes) {
  checks_ = 0;
  axis_ = AxisOfLargestSpread(boxes);
  SortByLowerFace(boxes);
  boxes_.Gather(boxes, {order_.data(), boxes.size()});
}

// Boxes that do not take part go last: the sweep never reaches them.
void Sap::SortByLowerFace(std::span<const Aabb> boxes) {
  const uint32_t last = SortableKey(std::numeric_limits<float>::infinity());
  const std::span<uint64_t> items = sort_.Items(boxes.size());
  for (size_t i = 0; i < boxes.size(); ++i) {
    const uint32_t key = TakesPart(boxes[i]) ? SortableKey(boxes[i].min[axis_]) : last;
    items[i] = PackSortItem(key, static_cast<uint32_t>(i));
  }
  order_.EnsureDiscarding(boxes.size());
  size_t slot = 0;
  for (const uint64_t item : sort_.Sort()) order_[slot++] = SortItemPayload(item);
}

}  // namespace

std::unique_ptr<BroadPhase> MakeSap(const BroadPhaseOptions& options) {
  return std::make_unique<Sap>(options);
}

}  // namespace sweepstake
