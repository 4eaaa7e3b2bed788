// Who looks at the boxes of a session's objects, and what its game is asked for meanwhile.
//
// The game is asked again and again while somebody looks, and stops by itself when it is not. Views
// go to those who look and are kept nowhere else. Used on the decision loop only.
#pragma once

#include <grpcpp/support/byte_buffer.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "server/sessions/decision_loop.h"
#include "server/watch/watch_hub.h"
#include "sweepstake/v1/telemetry.pb.h"

namespace sweepstake::rpc {

class ClientStream;

// One who looks.
class BoxViewer {
 public:
  virtual ~BoxViewer() = default;

  // The newest view, as an encoded WatchBoxesResponse.
  virtual void OnView(const grpc::ByteBuffer& message) = 0;
  // There will be no more views. It is not a viewer any more.
  virtual void OnEnd(const absl::Status& status) = 0;
};

class BoxViews {
 public:
  static constexpr size_t kMaxViewers = 2;
  static constexpr uint32_t kIntervalMs = 250;
  static constexpr uint32_t kUntilMs = 5'000;

  BoxViews(DecisionLoop& loop, watch::WatchHub& hub) : loop_(loop), hub_(hub) {}
  ~BoxViews() { End(); }
  BoxViews(const BoxViews&) = delete;
  BoxViews& operator=(const BoxViews&) = delete;

  // The game has connected; the link lives until Disconnect. `shows` says whether it shows boxes.
  void Connect(ClientStream& link, bool shows);
  void Disconnect();
  // The session has ended.
  void End();

  // Errors: FAILED_PRECONDITION (the game does not show its boxes), RESOURCE_EXHAUSTED (kMaxViewers
  // look already).
  absl::Status Add(BoxViewer& viewer);
  // Does nothing if it is not one of them.
  void Remove(BoxViewer& viewer);
  // A view that passed CheckRequest; dropped if nobody looks.
  void OnView(const v1::BoxView& view);

 private:
  // Asks the game, and again before that has run out.
  void Ask();

  DecisionLoop& loop_;
  watch::WatchHub& hub_;
  ClientStream* link_ = nullptr;  // null: the game is away
  bool shows_ = false;
  std::vector<BoxViewer*> viewers_;
  std::shared_ptr<uint64_t> turn_ = std::make_shared<uint64_t>(0);  // timers of others are ignored
};

}  // namespace sweepstake::rpc
