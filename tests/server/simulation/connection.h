// A stream between a game and the daemon as a network carries it: in order, late, and lost at any
// moment, which each end learns at a time of its own. A daemon may therefore still read what was
// under way when the game connects anew.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <string>

#include "server/rpc/services/telemetry_stream.h"
#include "tests/server/simulation/world.h"

namespace sweepstake::simulation {

// The game's end.
class ConnectionUser {
 public:
  virtual ~ConnectionUser() = default;
  virtual void OnResponse(const v1::StreamTelemetryResponse& response) = 0;
  // The connection has ended; nothing comes after it.
  virtual void OnClosed(const absl::Status& status) = 0;
};

class Connection final : public rpc::TelemetryTransport,
                         public std::enable_shared_from_this<Connection> {
 public:
  Connection(World& world, ConnectionUser& user) : world_(world), user_(&user) {}

  // The game's side. Dial is called first; `answer` opens or refuses, when the call has come.
  void Dial(std::function<void(Connection&)> answer);
  void Send(const v1::StreamTelemetryRequest& request);
  void HalfClose();
  // The connection breaks. The game is told unless it has left; the daemon learns it later.
  void Break();
  // The same, but the game is told at once, and nothing reaches it any more.
  void Cut();
  void Leave() { user_ = nullptr; }

  // The daemon's side. From Open on there is a stream, until the daemon is done with it or has
  // died.
  void Open(rpc::ServiceContext& context, rpc::TelemetryStreams& streams, auth::Principal caller);
  bool open() const { return stream_ != nullptr; }
  void Refuse(const absl::Status& status);
  void Die();

  void Read() override;
  void Write(const v1::StreamTelemetryResponse& response) override;
  void Finish(const absl::Status& status) override;
  void Cancel(const absl::Status& status) override;
  // Of the daemon's own machine, so that no game spends what the others may have.
  std::string peer() const override { return "ipv4:127.0.0.1:1"; }

 private:
  using StreamEvent = std::function<void(Connection&)>;

  // Runs `event` later, after all that was said earlier in the same direction.
  void ToDaemon(StreamEvent event);
  void ToGame(StreamEvent event);
  void Later(int64_t delay_ns, StreamEvent event);
  // Runs `event` on the daemon's loop, as gRPC's threads do.
  void Post(StreamEvent event);
  void Deliver();
  void Lose();
  void Close(const absl::Status& status);

  World& world_;
  ConnectionUser* user_;  // null once it was told of the end, or has left
  int64_t last_to_daemon_ns_ = 0;
  int64_t last_to_game_ns_ = 0;

  sessions::DecisionLoop* loop_ = nullptr;
  std::shared_ptr<rpc::TelemetryStream> stream_;
  std::deque<v1::StreamTelemetryRequest> arrived_;
  uint32_t pending_reads_ = 0;
  bool writing_ = false;
  bool ended_ = false;  // the daemon can read no more than has arrived
  bool told_end_ = false;
  bool lost_ = false;  // the daemon knows that the connection is lost
};

}  // namespace sweepstake::simulation
