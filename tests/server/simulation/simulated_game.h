// A game as the daemon sees it: it sends batches of frames, bail-outs and the outcomes of switches,
// loses its connection, also when an acknowledgement is about to come or while it resumes, and
// resumes, with the client's own protocol (SessionState). It remembers what it has sent under which
// number, and what it was promised.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine_client/telemetry/protocol/session_state.h"
#include "tests/server/simulation/connection.h"
#include "tests/server/simulation/world.h"

namespace sweepstake::simulation {

// A message as it was sent.
struct SentMessage {
  uint64_t first_frame = 0;  // 0 if it has no frames; otherwise no other message of the game has it
  uint64_t frame_count = 0;  // of a batch
  uint64_t bail_out_count = 0;
};

struct SentSession {
  std::vector<SentMessage> messages;  // number 1 is the first
  uint64_t promised_sequence = 0;     // messages up to this one are on disk, said the daemon
};

class SimulatedGame final : public ConnectionUser {
 public:
  // Dials; null is never returned.
  using Network = std::function<std::shared_ptr<Connection>(ConnectionUser&)>;

  // It begins at once. `complain` is told what must not happen.
  SimulatedGame(World& world, v1::Hello hello, Network network,
                std::function<void(const std::string&)> complain);
  ~SimulatedGame() override;

  // Makes no more frames, and says goodbye when all is sent.
  void Finish() { finishing_ = true; }
  bool gone() const { return gone_; }
  void BreakConnection();

  // By session id.
  const std::map<std::string, SentSession>& sessions() const { return sessions_; }
  const v1::Hello& hello() const { return hello_; }
  uint64_t resumed_count() const { return state_.counts().resumed_count; }
  uint64_t resent_count() const { return state_.counts().resent_message_count; }
  uint64_t lost_acknowledgement_count() const { return lost_acknowledgement_count_; }
  // The Hello that resumes the session of the latest welcome, if there was one.
  const std::optional<v1::Hello>& resumption() const { return resumption_; }

  void OnResponse(const v1::StreamTelemetryResponse& response) override;
  void OnClosed(const absl::Status& status) override;

 private:
  void Step();
  void Connect();
  void PlayFrames();
  void Sweep(v1::FrameBatch& batch);
  void AnswerCommand();
  void BailOut();
  void Append(const v1::StreamTelemetryRequest& evidence);
  void SendAll();
  void OnWelcome(const v1::Welcome& welcome);
  template <typename Posteriors>
  void Check(const Posteriors& posteriors);

  World& world_;
  const v1::Hello hello_;
  const Network network_;
  const std::function<void(const std::string&)> complain_;
  SessionState state_;
  std::map<std::string, SentSession> sessions_;

  std::shared_ptr<Connection> connection_;  // null while there is none
  int64_t next_attempt_ns_ = 0;
  int64_t welcome_due_ns_ = 0;
  int64_t reconnect_delay_ns_ = 0;
  bool goodbye_sent_ = false;
  bool half_closed_ = false;
  bool finishing_ = false;
  bool gone_ = false;
  // It believes only what it was told itself: what a welcome says is on disk, it sends again.
  const bool stubborn_;
  uint64_t lost_acknowledgement_count_ = 0;
  std::optional<v1::Hello> resumption_;

  int64_t interval_ns_;  // between two batches
  uint64_t next_frame_ = 1;
  uint64_t bail_out_count_ = 0;
  uint32_t arm_ = 0;
  uint32_t switch_epoch_ = 0;
  uint64_t last_command_id_ = 0;
  std::optional<v1::SwitchCommand> command_;  // to be answered
};

}  // namespace sweepstake::simulation
