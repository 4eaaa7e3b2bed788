// Sends a game's boxes to a daemon that requests them. While the request is valid, it regularly
// requests some of a frame's boxes from the frame thread (engine_client/adaptive/view_tap.h) and
// encodes them as a message. Views are not evidence: at most one view waits to be sent, and it is
// dropped if the connection is lost.
//
// Time: `now_ns` as in SessionLink. Not thread-safe. Memory: one message and the memory of the tap,
// while views are requested.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "engine_client/adaptive/view_tap.h"
#include "engine_client/telemetry/protocol/messages.h"

namespace sweepstake {

class BoxViewer {
 public:
  static constexpr uint32_t kMinIntervalMs = 250;
  static constexpr uint32_t kMaxIntervalMs = 2'000;
  static constexpr uint32_t kMaxBytes = 64 * 1024;
  static constexpr uint32_t kMaxUntilMs = 10'000;

  // `tap` must outlive this object.
  explicit BoxViewer(ViewTap& tap) : tap_(tap) {}

  // Replaces the previous request. Values out of range are clamped.
  void OnRequest(const protocol::BoxRequest& request, uint64_t now_ns);
  // Ends the current request.
  void Stop() { until_ns_ = 0; }
  // Requests and encodes the next view if it is due. Returns whether there is a message to send.
  // Call it every few milliseconds.
  bool Advance(uint64_t now_ns);
  // Returns the encoded message. REQUIRES: Advance returned true.
  std::string_view message() const { return message_; }
  // Drops the message after it was sent.
  void MarkSent() { message_.clear(); }

 private:
  void Begin();
  void End();

  ViewTap& tap_;
  uint32_t max_bytes_ = 0;
  uint64_t interval_ns_ = 0;
  uint64_t until_ns_ = 0;  // end of the current request
  uint64_t next_ns_ = 0;   // time of the next view
  bool asked_ = false;     // the tap holds memory until Release
  bool waits_ = false;     // the tap waits for a frame
  std::string message_;    // empty: none
};

// Returns the view of the frame's boxes, in at most `max_bytes` bytes of boxes and pairs. Omits
// invalid boxes, and pairs that do not fit.
protocol::BoxView ViewOf(const ViewedFrame& frame, uint32_t max_bytes);

}  // namespace sweepstake
