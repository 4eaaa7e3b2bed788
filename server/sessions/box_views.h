// Requests the boxes (AABBs) of a session's objects from its game while somebody views them, and
// passes the game's answers to the viewers.
//
// A request is valid for kUntilMs and is renewed before that time is over. Without renewal the game
// stops sending boxes by itself. Views are not stored. Used on the decision loop only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "server/sessions/common/decision_loop.h"

namespace sweepstake::sessions {

class ClientStream;

// A viewer of a session's boxes.
class BoxViewListener {
 public:
  virtual ~BoxViewListener() = default;

  // Receives the newest view, an encoded message sweepstake.v1.BoxView.
  virtual void OnView(const std::string& view) = 0;
  // Called when no more views follow. The viewer has been removed before the call.
  virtual void OnEnd(const absl::Status& status) = 0;
};

class BoxViews {
 public:
  static constexpr size_t kMaxViewers = 2;
  static constexpr uint32_t kIntervalMs = 250;
  static constexpr uint32_t kUntilMs = 5'000;

  explicit BoxViews(DecisionLoop& loop) : loop_(loop) {}
  ~BoxViews() { End(); }
  BoxViews(const BoxViews&) = delete;
  BoxViews& operator=(const BoxViews&) = delete;

  // Called when the game has connected. `link` must live until Disconnect. `shows` is true if the
  // game was built to show boxes.
  void Connect(ClientStream& link, bool shows);
  void Disconnect();
  // Called when the session has ended. Ends all viewers.
  void End();

  // Returns whether the game shows its boxes, according to the latest Connect.
  bool shows() const { return shows_; }

  // Adds a viewer. Errors: FAILED_PRECONDITION (the game does not show its boxes),
  // RESOURCE_EXHAUSTED (there are already kMaxViewers viewers).
  absl::Status Add(BoxViewListener& viewer);
  // Does nothing if the viewer was not added.
  void Remove(BoxViewListener& viewer);
  // Passes the view to all viewers; drops it if there are none.
  void OnView(const std::string& view);

 private:
  // Sends a box request to the game, and schedules the next one before this one expires.
  void Ask();

  DecisionLoop& loop_;
  ClientStream* link_ = nullptr;  // null while the game is not connected
  bool shows_ = false;
  std::vector<BoxViewListener*> viewers_;
  // The number of the latest request. Timers of earlier requests do nothing.
  std::shared_ptr<uint64_t> turn_ = std::make_shared<uint64_t>(0);
};

}  // namespace sweepstake::sessions
