#include "engine_client/broad_phase/axis_sweep.h"

#include <algorithm>
#include <limits>

#include "engine_client/broad_phase/pair_set.h"
#include "engine_client/broad_phase/soa_boxes.h"
#include "engine_client/broad_phase/sorted_endpoints.h"
#include "engine_client/broad_phase/sweep_axis.h"
#include "engine_client/broad_phase/sweep_kernel.h"

namespace sweepstake {
namespace {

// Motion is little while at most 9 of 20 neighbouring endpoints are out of order. Half of them are
// in a random order, a quarter at 10,000 boxes of unit density that move by up to 0.001, where a
// repair takes 0.43 ms and a sweep 0.95 ms.
bool IsLittleMotion(size_t descents, size_t endpoints) { return 20 * descents <= 9 * endpoints; }

// Passings that a repair may make before a sweep is the cheaper way: a passing takes as long as
// about 100 lanes of a sweep (13 ns), and sorting anew as long as a third of a passing per
// endpoint.
size_t PassBudget(uint64_t sweep_checks, size_t endpoints) {
  return static_cast<size_t>(sweep_checks / 100) + endpoints / 3;
}

constexpr size_t kMostPairsPerBox = 32;
// Frames without another try after a repair ran out of its budget: its work was lost.
constexpr int kPauseFrames = 8;

// A box that does not take part begins after everything and ends before everything: it overlaps
// nothing.
BoxKeys KeysOf(const Aabb& box) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const bool takes_part = TakesPart(box);
  BoxKeys keys;
  for (int axis = 0; axis < 3; ++axis) {
    keys.face[axis] = SortableKey(takes_part ? box.min[axis] : kInfinity);
    keys.face[axis + 3] = SortableKey(takes_part ? box.max[axis] : -kInfinity);
  }
  return keys;
}

bool KeysOverlap(const BoxKeys& a, const BoxKeys& b) {
  bool overlap = true;
  for (int axis = 0; axis < 3; ++axis) {
    overlap = overlap && a.face[axis] <= b.face[axis + 3] && b.face[axis] <= a.face[axis + 3];
  }
  return overlap;
}

OverlapPair Ordered(uint32_t a, uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

class AxisSweep final : public BroadPhase {
 public:
  explicit AxisSweep(const BroadPhaseOptions& /*options*/) {}
  std::string_view name() const override { return "AxisSweep"; }
  uint32_t version() const override { return 1; }
  void Build(std::span<const Aabb> boxes) override;
  void Update(std::span<const Aabb> boxes) override;
  void FindPairs(PairBuffer& out) override;
  uint64_t aabb_check_count() const override { return checks_; }
  size_t native_bytes() const override;

 private:
  void TakeKeys(std::span<const Aabb> boxes);
  std::span<const BoxKeys> keys() const { return {keys_.data(), count_}; }
  size_t Refresh();
  bool Repair();
  void Pass(uint64_t stayed, uint64_t moved);
  void PrepareSweep(std::span<const Aabb> boxes);
  void CopyPairs(PairBuffer& out) const;
  void AdoptPairs(std::span<const OverlapPair> pairs);

  AlignedBuffer<BoxKeys> keys_;  // of the latest boxes
  SortedEndpoints axes_[3];
  RadixSort sort_;
  AlignedBuffer<uint32_t> order_;
  SoaBoxes swept_;
  int sweep_axis_ = 0;
  PairSet pairs_;
  size_t count_ = 0;
  bool pairs_known_ = false;  // pairs_ holds the pairs of the latest boxes
  bool calm_ = false;         // the pairs of the next sweep are worth keeping
  int pause_frames_ = 0;
  uint64_t checks_ = 0;
  uint64_t sweep_checks_ = 0;  // of the latest sweep
};

void AxisSweep::Build(std::span<const Aabb> boxes) {
  TakeKeys(boxes);
  for (SortedEndpoints& axis : axes_) axis.Reset(boxes.size());
  Refresh();
  calm_ = false;
  pause_frames_ = 0;
  checks_ = 0;
  PrepareSweep(boxes);
}

void AxisSweep::Update(std::span<const Aabb> boxes) {
  if (boxes.size() != count_) return Build(boxes);
  TakeKeys(boxes);
  const size_t descents = Refresh();
  calm_ = pause_frames_ == 0 && IsLittleMotion(descents, 6 * count_);
  pause_frames_ = std::max(0, pause_frames_ - 1);
  checks_ = 0;
  if (pairs_known_ && calm_ && Repair()) return;
  PrepareSweep(boxes);
}

void AxisSweep::FindPairs(PairBuffer& out) {
  if (pairs_known_) {
    CopyPairs(out);
    return;
  }
  const size_t before = out.size();
  sweep_checks_ = SweepSorted(swept_.Lanes(sweep_axis_), out);
  checks_ += sweep_checks_;
  if (calm_) AdoptPairs(out.pairs().subspan(before));
}

size_t AxisSweep::native_bytes() const {
  size_t bytes = keys_.capacity_bytes() + sort_.native_bytes() + order_.capacity_bytes() +
                 swept_.native_bytes() + pairs_.native_bytes();
  for (const SortedEndpoints& axis : axes_) bytes += axis.native_bytes();
  return bytes;
}

void AxisSweep::TakeKeys(std::span<const Aabb> boxes) {
  count_ = boxes.size();
  keys_.EnsureDiscarding(count_);
  std::transform(boxes.begin(), boxes.end(), keys_.data(), KeysOf);
}

size_t AxisSweep::Refresh() {
  size_t descents = 0;
  for (int axis = 0; axis < 3; ++axis) descents += axes_[axis].Refresh(keys(), axis);
  return descents;
}

// False when that is too much work; the pairs are then unknown.
bool AxisSweep::Repair() {
  size_t budget = PassBudget(sweep_checks_, 6 * count_);
  const auto on_pass = [this](uint64_t stayed, uint64_t moved) { Pass(stayed, moved); };
  for (SortedEndpoints& axis : axes_) {
    if (axis.Repair(budget, on_pass) && pairs_.size() <= kMostPairsPerBox * count_) continue;
    calm_ = false;
    pause_frames_ = kPauseFrames;
    return false;
  }
  return true;
}

// `moved` is now below `stayed`. A pair that begins does so on some axis, where the final test sees
// it; one that ends does so on some axis too, and no axis undoes the other because every test is
// against the latest boxes.
void AxisSweep::Pass(uint64_t stayed, uint64_t moved) {
  if (IsUpperFace(stayed) == IsUpperFace(moved)) return;
  const uint32_t a = EndpointOwner(stayed);
  const uint32_t b = EndpointOwner(moved);
  if (IsUpperFace(moved)) {
    pairs_.Erase(Ordered(a, b));
  } else if (a != b) {
    ++checks_;
    if (KeysOverlap(keys_[a], keys_[b])) pairs_.Insert(Ordered(a, b));
  }
}

void AxisSweep::PrepareSweep(std::span<const Aabb> boxes) {
  pairs_known_ = false;
  for (SortedEndpoints& axis : axes_) axis.Resort(sort_);
  sweep_axis_ = AxisOfLargestSpread(boxes);
  order_.EnsureDiscarding(count_);
  size_t slot = 0;
  for (const uint64_t endpoint : axes_[sweep_axis_].endpoints()) {
    if (!IsUpperFace(endpoint)) order_[slot++] = EndpointOwner(endpoint);
  }
  swept_.Gather(boxes, {order_.data(), count_});
}

void AxisSweep::CopyPairs(PairBuffer& out) const {
  const std::span<const OverlapPair> pairs = pairs_.pairs();
  std::copy(pairs.begin(), pairs.end(), out.EnsureRoom(pairs.size()));
  out.Advance(pairs.size());
}

void AxisSweep::AdoptPairs(std::span<const OverlapPair> pairs) {
  if (pairs.size() > kMostPairsPerBox * count_) return;
  pairs_.Clear();
  pairs_.Reserve(2 * pairs.size());
  for (const OverlapPair pair : pairs) pairs_.Insert(pair);
  pairs_known_ = true;
}

}  // namespace

std::unique_ptr<BroadPhase> MakeAxisSweep(const BroadPhaseOptions& options) {
  return std::make_unique<AxisSweep>(options);
}

}  // namespace sweepstake
