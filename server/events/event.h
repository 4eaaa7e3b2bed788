// An event for watchers (gRPC calls and browsers), and the interface that encodes it. An event is
// encoded once for all watchers.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "server/sessions/prior_store.h"
#include "server/sessions/session_observer.h"
#include "server/sessions/session_table.h"

namespace sweepstake::events {

enum class Kind : uint8_t { kPosteriors, kSessions, kBoxes };

// Identifies an event and says when the daemon made it.
struct EventStamp {
  uint64_t boot = 0;      // random number, drawn once per run of the daemon
  uint64_t sequence = 0;  // number of the event in this run, from 1
  int64_t unix_ms = 0;
};

// An event as an encoded protobuf message: the bytes of `body` followed by the bytes of `tail`.
struct Event {
  EventStamp stamp;
  std::shared_ptr<const std::string> body;
  std::string tail;             // the stamp; for a scene also the activity of its sessions
  sessions::SceneRun run = {};  // for a scene: what its sessions ran when `tail` was made
  // The message as JSON, made at its first use. Only the thread of the HTTP server uses it.
  mutable std::string json = {};
};
using EventPtr = std::shared_ptr<const Event>;

// Encodes the parts of an event as protobuf messages. Parts are joined by appending their bytes,
// because protobuf's parser merges messages that follow one another. Thread-safe.
class Encoder {
 public:
  virtual ~Encoder() = default;

  // Computes the scene's verdict and credible intervals, which takes 0.6 to 6 ms.
  virtual std::string Scene(const priors::SceneEvidence& scene) const = 0;
  // Encodes the part of a scene's message that is not in the store.
  virtual std::string Activity(const sessions::SceneActivity& activity) const = 0;
  virtual std::string Decision(const sessions::SessionDecision& decision) const = 0;
  virtual std::string Session(const sessions::SessionView& session) const = 0;
  virtual std::string SessionEnd(const std::string& session_id, sessions::SessionEnd end) const = 0;
  // `view` is an encoded message sweepstake.v1.BoxView.
  virtual std::string Boxes(const std::string& view) const = 0;
  virtual std::string Stamp(Kind kind, const EventStamp& stamp) const = 0;
};

}  // namespace sweepstake::events
