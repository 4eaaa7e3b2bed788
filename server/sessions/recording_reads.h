// Reads the flight recordings of a session's game for operators, one part at a time: the game is
// asked, and its answer goes to the call that waits for it. Nothing is kept. Used on the decision
// loop only.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "server/sessions/decision_loop.h"
#include "sweepstake/v1/telemetry.pb.h"

namespace sweepstake::rpc {

class SessionLink;

class RecordingReads {
 public:
  using Answer = std::function<void(absl::StatusOr<v1::RecordingPart>)>;
  // The game has so long to answer; then all that wait are told that it does not.
  static constexpr int64_t kPatienceNs = 5'000'000'000;
  static constexpr size_t kMaxWaiting = 4;    // calls
  static constexpr size_t kMaxReaders = 100;  // that are remembered

  explicit RecordingReads(DecisionLoop& loop) : loop_(loop) {}
  ~RecordingReads() { Disconnect(); }
  RecordingReads(const RecordingReads&) = delete;
  RecordingReads& operator=(const RecordingReads&) = delete;

  // The game has connected; the link lives until Disconnect. `gives` says whether it gives
  // recordings away.
  void Connect(SessionLink& link, bool gives);
  // The game is gone: so is what waits for it.
  void Disconnect();

  // Calls `answer` exactly once. Errors: FAILED_PRECONDITION (the game gives none), UNAVAILABLE
  // (the game is not connected, is lost, or does not answer in time), RESOURCE_EXHAUSTED
  // (kMaxWaiting calls wait).
  void Read(uint64_t recording_id, uint64_t offset, Answer answer);
  // Returns whether this is what the game was asked for.
  bool Awaits(const v1::RecordingPart& part) const {
    return !waiting_.empty() && part.request_id() == *request_id_;
  }
  // An answer that passed CheckRequest; dropped if nobody waits for it.
  void OnPart(const v1::RecordingPart& part);
  // Returns whether `reader` begins with a recording: reads its start, or has not read it before as
  // far as is remembered.
  bool Begins(const std::string& reader, uint64_t recording_id, uint64_t offset);

 private:
  struct Waiting {
    uint64_t recording_id = 0;
    uint64_t offset = 0;
    Answer answer;
  };

  void Ask();
  void RefuseAll(const absl::Status& why);

  DecisionLoop& loop_;
  SessionLink* link_ = nullptr;  // null: the game is away
  bool gives_ = false;
  std::deque<Waiting> waiting_;  // the game has been asked for the first one
  // Of the latest request; others' answers and timers are ignored.
  std::shared_ptr<uint64_t> request_id_ = std::make_shared<uint64_t>(0);
  std::set<std::pair<std::string, uint64_t>> readers_;  // with the recordings that they read
};

}  // namespace sweepstake::rpc
