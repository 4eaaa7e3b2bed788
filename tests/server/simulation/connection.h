// A stream between a game and the daemon over a simulated network: in order, delayed, and lost at
// any moment. Each end notices the loss at its own time. A daemon may therefore still read old
// messages when the game has already reconnected.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <string>

#include "server/rpc/services/telemetry_stream.h"
#include "tests/server/simulation/world.h"

namespace sweepstake::simulation {

// The game's end of the connection.
class ConnectionUser {
 public:
  virtual ~ConnectionUser() = default;
  virtual void OnResponse(const v1::StreamTelemetryResponse& response) = 0;
  // Called when the connection has ended. No more calls follow.
  virtual void OnClosed(const absl::Status& status) = 0;
};

class Connection final : public rpc::TelemetryTransport,
                         public std::enable_shared_from_this<Connection> {
 public:
  Connection(World& world, ConnectionUser& user) : world_(world), user_(&user) {}

  // The game's side. Dial is called first; `answer` opens or refuses the stream when the call
  // arrives.
  void Dial(std::function<void(Connection&)> answer);
  void Send(const v1::StreamTelemetryRequest& request);
  void HalfClose();
  // Breaks the connection. The game is notified unless it has left; the daemon notices it later.
  void Break();
  // Breaks the connection. The game is notified at once, and receives nothing more.
  void Cut();
  void Leave() { user_ = nullptr; }

  // The daemon's side. After Open there is a stream, until the daemon has finished it or has died.
  void Open(rpc::ServiceContext& context, rpc::TelemetryStreams& streams, auth::Principal caller);
  bool open() const { return stream_ != nullptr; }
  void Refuse(const absl::Status& status);
  void Die();

  void Read() override;
  void Write(const v1::StreamTelemetryResponse& response) override;
  void Finish(const absl::Status& status) override;
  void Cancel(const absl::Status& status) override;
  // An address of the daemon's own machine, so that the per-address quotas do not apply.
  std::string peer() const override { return "ipv4:127.0.0.1:1"; }

 private:
  using StreamEvent = std::function<void(Connection&)>;

  // Runs `event` later, after all earlier events in the same direction.
  void ToDaemon(StreamEvent event);
  void ToGame(StreamEvent event);
  void Later(int64_t delay_ns, StreamEvent event);
  // Runs `event` on the daemon's loop, as gRPC's threads do.
  void Post(StreamEvent event);
  void Deliver();
  void Lose();
  void Close(const absl::Status& status);

  World& world_;
  ConnectionUser* user_;  // null after the game was notified of the end, or has left
  int64_t last_to_daemon_ns_ = 0;
  int64_t last_to_game_ns_ = 0;

  sessions::DecisionLoop* loop_ = nullptr;
  std::shared_ptr<rpc::TelemetryStream> stream_;
  std::deque<v1::StreamTelemetryRequest> arrived_;
  uint32_t pending_reads_ = 0;
  bool writing_ = false;
  bool ended_ = false;  // the daemon can read only what has already arrived
  bool told_end_ = false;
  bool lost_ = false;  // the daemon has noticed that the connection is lost
};

}  // namespace sweepstake::simulation
