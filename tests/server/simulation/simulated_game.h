// A game as the daemon sees it, with the client's own protocol (ResumableSession). It sends batches
// of frames, bail-outs and results of switches. It loses its connection, also just before an
// acknowledgement or while it resumes, and resumes. It records every message with its number, and
// what was acknowledged.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine_client/telemetry/protocol/resumable_session.h"
#include "tests/server/simulation/connection.h"
#include "tests/server/simulation/world.h"

namespace sweepstake::simulation {

// A sent message.
struct SentMessage {
  uint64_t first_frame = 0;  // number of its first frame, unique in the game; 0 if it has no frames
  uint64_t frame_count = 0;  // number of frames of a batch
  uint64_t bail_out_count = 0;
};

struct SentSession {
  std::vector<SentMessage> messages;  // messages[0] has the number 1
  // The daemon has acknowledged that the messages up to this number are on disk.
  uint64_t promised_sequence = 0;
};

class SimulatedGame final : public ConnectionUser {
 public:
  // Opens a connection; never returns null.
  using Network = std::function<std::shared_ptr<Connection>(ConnectionUser&)>;

  // The game starts at once. `complain` is called for each violation.
  SimulatedGame(World& world, v1::Hello hello, Network network,
                std::function<void(const std::string&)> complain);
  ~SimulatedGame() override;

  // Makes no more frames, and says goodbye when all messages are sent.
  void Finish() { finishing_ = true; }
  bool gone() const { return gone_; }
  void BreakConnection();

  // The sent messages of each session, by session id.
  const std::map<std::string, SentSession>& sessions() const { return sessions_; }
  const v1::Hello& hello() const { return hello_; }
  uint64_t resumed_count() const { return state_.counts().resumed_count; }
  uint64_t resent_count() const { return state_.counts().resent_message_count; }
  uint64_t lost_acknowledgement_count() const { return lost_acknowledgement_count_; }
  // The Hello that resumes the session of the latest welcome message, if there was one.
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
  ResumableSession state_;
  std::map<std::string, SentSession> sessions_;

  std::shared_ptr<Connection> connection_;  // null if not connected
  int64_t next_attempt_ns_ = 0;
  int64_t welcome_due_ns_ = 0;
  int64_t reconnect_delay_ns_ = 0;
  bool goodbye_sent_ = false;
  bool half_closed_ = false;
  bool finishing_ = false;
  bool gone_ = false;
  // If true, the game ignores which messages the welcome message acknowledges, and resends them
  // all.
  const bool stubborn_;
  uint64_t lost_acknowledgement_count_ = 0;
  std::optional<v1::Hello> resumption_;

  int64_t interval_ns_;  // time between two batches
  uint64_t next_frame_ = 1;
  uint64_t bail_out_count_ = 0;
  uint32_t arm_ = 0;
  uint32_t switch_epoch_ = 0;
  uint64_t last_command_id_ = 0;
  std::optional<v1::SwitchCommand> command_;  // not answered yet
};

}  // namespace sweepstake::simulation
