// Sends a game's boxes to a daemon on request, so that an operator can view them. While a request
// is valid, this class regularly requests some of a frame's boxes from the frame thread
// (engine_client/adaptive/view_tap.h) and encodes them as a message, called a view. Views are not
// evidence: at most one waits to be sent, and it is dropped if the connection is lost.
//
// Time: `now_ns` as in SessionLink. Not thread-safe. Memory while views are requested: one message
// and the tap's memory.
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

  // Starts a request, which replaces the current one. Values out of range are clamped.
  void OnRequest(const protocol::BoxRequest& request, uint64_t now_ns);
  // Ends the current request.
  void Stop() { until_ns_ = 0; }
  // Requests the next view from the frame thread if it is due, and encodes it when it is there.
  // Returns whether there is a message to send. Call it every few milliseconds.
  bool Advance(uint64_t now_ns);
  // Returns the encoded message. REQUIRES: Advance returned true.
  std::string_view message() const { return message_; }
  // Drops the message. Call it after sending the message.
  void MarkSent() { message_.clear(); }

 private:
  void Begin();
  void End();

  ViewTap& tap_;
  uint32_t max_bytes_ = 0;
  uint64_t interval_ns_ = 0;
  uint64_t until_ns_ = 0;  // end of the current request
  uint64_t next_ns_ = 0;   // time of the next view
  bool asked_ = false;     // a frame was requested, so the tap holds memory
  bool waits_ = false;     // the frame thread has not copied the requested frame yet
  std::string message_;    // empty: nothing to send
};

// Returns a view of the frame's boxes. Boxes and pairs together take at most `max_bytes` bytes.
// Invalid boxes are left out, and so are pairs that do not fit.
protocol::BoxView ViewOf(const ViewedFrame& frame, uint32_t max_bytes);

}  // namespace sweepstake
