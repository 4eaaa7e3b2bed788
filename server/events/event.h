// Events for watchers, encoded once however many watchers there are, and what encodes them.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "server/sessions/prior_store.h"
#include "server/sessions/session_observer.h"
#include "server/sessions/session_table.h"

namespace sweepstake::events {

enum class Kind : uint8_t { kPosteriors, kSessions, kBoxes };

// Identifies an event of a daemon and states when it was made.
struct EventStamp {
  uint64_t boot = 0;      // a random number of the daemon's run
  uint64_t sequence = 0;  // counts the events of the run, from 1
  int64_t unix_ms = 0;
};

// A message in the encoding of protobuf: the bytes of `body` followed by those of `tail`.
struct Event {
  EventStamp stamp;
  std::shared_ptr<const std::string> body;
  std::string tail;       // the stamp, and for a scene the number of its active sessions
  bool all_told = false;  // the mark: the whole initial state has been sent
  // The message as JSON, made at its first use. Only the thread of the HTTP server uses it.
  mutable std::string json = {};
};
using EventPtr = std::shared_ptr<const Event>;

// Encodes parts of messages. Protobuf merges the parts of a message that stand one after another.
// Thread-safe.
class Encoder {
 public:
  virtual ~Encoder() = default;

  // Computes the scene's figures, which takes 0.3 to 3 ms.
  virtual std::string Scene(const priors::SceneEvidence& scene) const = 0;
  // The part of a scene's message that is not in the store.
  virtual std::string ActiveSessions(uint32_t count) const = 0;
  virtual std::string Decision(const sessions::DecisionEvent& decision) const = 0;
  virtual std::string Session(const sessions::SessionView& session) const = 0;
  virtual std::string SessionEnd(const std::string& session_id, sessions::SessionEnd end) const = 0;
  // `view` is an encoded message sweepstake.v1.BoxView.
  virtual std::string Boxes(const std::string& view) const = 0;
  // `all_told` makes the message a mark.
  virtual std::string Stamp(Kind kind, const EventStamp& stamp, bool all_told) const = 0;
};

}  // namespace sweepstake::events
