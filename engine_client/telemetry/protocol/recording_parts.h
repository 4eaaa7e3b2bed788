// Gives a flight recorder's files to a daemon that asks: one part for each request, and nothing
// unasked. A part is no evidence: one waits at most, and is lost with the connection.
//
// Not thread-safe. Memory: one part.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>

#include "engine_client/telemetry/common/flight_recorder.h"
#include "engine_client/telemetry/protocol/messages.h"
#include "engine_client/telemetry/protocol/wire.h"

namespace sweepstake {

class RecordingParts {
 public:
  static constexpr uint32_t kMaxBytes = 64 * 1024;

  // The recorder is borrowed; null: there are no recordings.
  explicit RecordingParts(const FlightRecorder* recorder) : recorder_(recorder) {}

  // Makes the answer, in place of one that was not sent. The time is that of SteadyClock().
  void OnRequest(const protocol::RecordingRequest& request, uint64_t now_ns) {
    protocol::RecordingPart part{.request_id = request.request_id, .recordings = {}, .data = {}};
    if (recorder_ != nullptr && request.recording_id != 0) {
      part.data = recorder_->Read(request.recording_id, request.offset,
                                  std::min(request.max_bytes, kMaxBytes));
    } else if (recorder_ != nullptr) {
      for (const FlightRecording& recording : recorder_->recordings())
        part.recordings.push_back({.recording_id = recording.recording_id,
                                   .age_ms = AgeMs(recording, now_ns),
                                   .size_bytes = recording.bytes,
                                   .worst_frame_ns = recording.worst_frame_ns});
    }
    message_ = protocol::Encode(part);
  }
  // Nobody waits for an answer any more.
  void Stop() { message_.clear(); }
  bool has_message() const { return !message_.empty(); }
  // The message, whole. REQUIRES: has_message().
  std::string_view message() const { return message_; }
  // The message was sent.
  void MarkSent() { message_.clear(); }

 private:
  static uint64_t AgeMs(const FlightRecording& recording, uint64_t now_ns) {
    return (now_ns - std::min(recording.recorded_ns, now_ns)) / 1'000'000;
  }

  const FlightRecorder* const recorder_;
  std::string message_;  // empty: none
};

}  // namespace sweepstake
