// The way from a session to its client: what a session says, without knowing how it travels.
#pragma once

#include <cstdint>
#include <span>

#include "absl/status/status.h"
#include "server/decision/types.h"

namespace sweepstake::rpc {

// On the decision loop only. Nothing here waits: of each kind only the latest message is kept until
// it can be written.
class SessionLink {
 public:
  virtual ~SessionLink() = default;

  virtual void SendSwitch(const decision::SwitchCommand& command) = 0;
  virtual void SendAcknowledgement(uint64_t sequence) = 0;
  virtual void SendSnapshot(std::span<const decision::BetaPosterior> posteriors,
                            const decision::Diagnosis& diagnosis) = 0;
  virtual void SendReconnect(uint32_t delay_ms) = 0;
  // Ends the stream when what was said has been written. The session has let go of the link before.
  virtual void Close(const absl::Status& status) = 0;
  // Ends the stream at once.
  virtual void Abort(const absl::Status& status) = 0;
};

}  // namespace sweepstake::rpc
