// Shows a game's boxes to a daemon that asks: from time to time asks the frame thread for some of a
// frame's boxes (engine_client/adaptive/view_tap.h) and makes a message of them, for as long as the
// daemon wants them. What it shows is no evidence: one view waits at most, and is lost with the
// connection.
//
// Time: as SessionLink. Not thread-safe. Memory: while views are wanted one message and the tap's.
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

  // The tap is borrowed.
  explicit BoxViewer(ViewTap& tap) : tap_(tap) {}

  // The latest request counts. What is out of its range is brought into it.
  void OnRequest(const protocol::BoxRequest& request, uint64_t now_ns);
  // No views are wanted any more.
  void Stop() { until_ns_ = 0; }
  // Goes on, and returns whether there is a message to send. Called every few milliseconds.
  bool Advance(uint64_t now_ns);
  // The message, whole. REQUIRES: Advance returned true.
  std::string_view message() const { return message_; }
  // The message was sent.
  void MarkSent() { message_.clear(); }

 private:
  void Begin();
  void End();

  ViewTap& tap_;
  uint32_t max_bytes_ = 0;
  uint64_t interval_ns_ = 0;
  uint64_t until_ns_ = 0;  // views are wanted before it
  uint64_t next_ns_ = 0;   // of the next view
  bool asked_ = false;     // the tap holds memory, and may be asked for boxes
  bool waits_ = false;     // for a frame
  std::string message_;    // empty: none
};

// Returns the view of the frame's boxes, in at most `max_bytes` bytes of boxes and pairs.
// Invalid boxes are left out, as are pairs for which there is no room.
protocol::BoxView ViewOf(const ViewedFrame& frame, uint32_t max_bytes);

}  // namespace sweepstake
