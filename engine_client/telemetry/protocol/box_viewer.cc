#include "engine_client/telemetry/protocol/box_viewer.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <vector>

#include "engine_client/telemetry/protocol/wire.h"

namespace sweepstake {
namespace {

constexpr uint32_t kBoxBytes = 12;
constexpr uint32_t kPairBytes = 4;
constexpr float kSteps = 65'535;

// Returns the number of boxes that fit into three quarters of the bytes. The last quarter is for
// pairs.
size_t MaxBoxes(uint32_t max_bytes) { return max_bytes / 4 * 3 / kBoxBytes; }

void PutNumber(float value, std::string& bytes) {
  const auto number = static_cast<uint32_t>(std::clamp(value, 0.0F, kSteps));
  bytes.push_back(static_cast<char>(number & 0xFF));
  bytes.push_back(static_cast<char>(number >> 8));
}

Aabb BoundsOf(const std::vector<Aabb>& boxes) {
  Aabb bounds = boxes.front();
  for (const Aabb& box : boxes) {
    for (int axis = 0; axis < 3; ++axis) {
      bounds.min[axis] = std::min(bounds.min[axis], box.min[axis]);
      bounds.max[axis] = std::max(bounds.max[axis], box.max[axis]);
    }
  }
  return bounds;
}

// Rounds the box outwards to kSteps steps per axis of `bounds`, and appends it to `bytes`.
void PutBox(const Aabb& box, const Aabb& bounds, std::string& bytes) {
  float scale[3];
  for (int axis = 0; axis < 3; ++axis) {
    const float extent = bounds.max[axis] - bounds.min[axis];
    scale[axis] = extent > 0 && std::isfinite(extent) ? kSteps / extent : 0;
  }
  for (int axis = 0; axis < 3; ++axis)
    PutNumber(std::floor((box.min[axis] - bounds.min[axis]) * scale[axis]), bytes);
  for (int axis = 0; axis < 3; ++axis)
    PutNumber(std::ceil((box.max[axis] - bounds.min[axis]) * scale[axis]), bytes);
}

// Finds up to `max_pairs` overlapping pairs by a sweep along x. No backend is used, because a
// backend would find all pairs; these are millions if all boxes overlap.
std::string PairsOf(const std::vector<Aabb>& boxes, size_t max_pairs) {
  std::vector<uint32_t> order(boxes.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(),
            [&](uint32_t a, uint32_t b) { return boxes[a].min[0] < boxes[b].min[0]; });
  std::string pairs;
  for (size_t i = 0; i < order.size(); ++i) {
    for (size_t j = i + 1; j < order.size(); ++j) {
      if (boxes[order[j]].min[0] > boxes[order[i]].max[0]) break;
      if (!Overlap(boxes[order[i]], boxes[order[j]])) continue;
      if (pairs.size() >= max_pairs * kPairBytes) return pairs;
      const auto [first, second] = std::minmax(order[i], order[j]);
      PutNumber(static_cast<float>(first), pairs);
      PutNumber(static_cast<float>(second), pairs);
    }
  }
  return pairs;
}

}  // namespace

protocol::BoxView ViewOf(const ViewedFrame& frame, uint32_t max_bytes) {
  protocol::BoxView view{.frame_index = frame.frame_index,
                         .object_count = static_cast<uint32_t>(std::min<size_t>(
                             frame.object_count, std::numeric_limits<uint32_t>::max())),
                         .stride = static_cast<uint32_t>(frame.stride),
                         .bounds = {},
                         .boxes = {},
                         .pairs = {}};
  std::vector<Aabb> boxes;
  std::copy_if(frame.boxes.begin(), frame.boxes.end(), std::back_inserter(boxes), IsValid);
  boxes.resize(std::min(boxes.size(), MaxBoxes(max_bytes)));
  if (boxes.empty()) return view;
  const Aabb bounds = BoundsOf(boxes);
  view.bounds.assign(std::begin(bounds.min), std::end(bounds.min));
  view.bounds.insert(view.bounds.end(), std::begin(bounds.max), std::end(bounds.max));
  for (const Aabb& box : boxes) PutBox(box, bounds, view.boxes);
  view.pairs = PairsOf(boxes, (max_bytes - view.boxes.size()) / kPairBytes);
  return view;
}

void BoxViewer::OnRequest(const protocol::BoxRequest& request, uint64_t now_ns) {
  if (request.interval_ms == 0 || request.until_ms == 0 || MaxBoxes(request.max_bytes) == 0)
    return Stop();
  interval_ns_ =
      uint64_t{std::clamp(request.interval_ms, kMinIntervalMs, kMaxIntervalMs)} * kNsPerMs;
  max_bytes_ = std::min(request.max_bytes, kMaxBytes);
  until_ns_ = now_ns + std::min(request.until_ms, kMaxUntilMs) * kNsPerMs;
}

bool BoxViewer::Advance(uint64_t now_ns) {
  if (now_ns >= until_ns_) {
    End();
    return false;
  }
  if (waits_ && tap_.has_frame()) {
    waits_ = false;
    next_ns_ = now_ns + interval_ns_;
    message_ = protocol::Encode(ViewOf(tap_.frame(), max_bytes_));
  }
  if (!waits_ && message_.empty() && now_ns >= next_ns_) Begin();
  return !message_.empty();
}

void BoxViewer::Begin() {
  tap_.Request(MaxBoxes(max_bytes_));
  asked_ = waits_ = true;
}

// Ends the viewing and frees the tap's memory. If the frame thread is copying at this moment,
// Release fails, and the next Advance tries again.
void BoxViewer::End() {
  message_.clear();
  if (!asked_ || !tap_.Release()) return;
  asked_ = waits_ = false;
  next_ns_ = 0;
}

}  // namespace sweepstake
