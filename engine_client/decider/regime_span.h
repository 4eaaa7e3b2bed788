// The frames that surely belong to the present regime of the scene, by the scene descriptors.
// Evidence of other frames belongs to no regime.
//
// A descriptor covers the frames since the previous one, its period. The regime may change within a
// period. Such a period's descriptor is a mixture, which often matches no known regime. So the
// present regime has ended
// - if a descriptor matches another known regime
// - if two descriptors in a row match no known regime; a new regime then begins
//
// Plain values; not thread-safe.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

namespace sweepstake::decision {

enum class DescriptorMatch { kPresent, kOther, kUnknown };

class RegimeSpan {
 public:
  void ObserveFrame(uint64_t frame_index) { next_frame_ = std::max(next_frame_, frame_index + 1); }

  void ObserveDescriptor(DescriptorMatch match) {
    if (!has_ended_) {
      has_ended_ = match == DescriptorMatch::kOther || (match == DescriptorMatch::kUnknown && end_);
      if (match == DescriptorMatch::kPresent) {
        end_.reset();
      } else if (!end_) {
        end_ = period_begin_;
      }
    }
    period_begin_ = next_frame_;
  }

  // Begins the next regime. Its first frame is the one after the latest descriptor.
  void BeginNext() {
    begin_ = period_begin_;
    end_.reset();
    has_ended_ = false;
  }

  bool has_ended() const { return has_ended_; }
  // Returns whether the frames since the latest descriptor may belong to another regime.
  bool is_in_doubt() const { return end_.has_value(); }
  bool Contains(uint64_t frame_index) const {
    return frame_index >= begin_ && (!end_ || frame_index < *end_);
  }

  // Calls visit(name, member) for every member, for the audit log (audit/audit_row.h).
  template <typename Self, typename Visit>
  static void VisitFields(Self& span, Visit& visit) {
    auto& [begin, end, period_begin, next_frame, has_ended] = span;
    visit("begin", begin);
    visit("end", end);
    visit("period_begin", period_begin);
    visit("next_frame", next_frame);
    visit("has_ended", has_ended);
  }

 private:
  uint64_t begin_ = 0;
  std::optional<uint64_t> end_;  // absent: no frame so far is in doubt
  uint64_t period_begin_ = 0;    // the frame after the latest descriptor
  uint64_t next_frame_ = 0;      // the frame after the latest one
  bool has_ended_ = false;
};

}  // namespace sweepstake::decision
