// The people who look at the boxes of a session's objects, and the requests to its game meanwhile.
//
// The game is asked again and again while somebody looks, and stops by itself otherwise. A view is
// passed on and not kept. Used on the decision loop only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "server/sessions/client_messages.h"
#include "server/sessions/common/decision_loop.h"

namespace sweepstake::sessions {

class ClientStream;

// Somebody who looks.
class BoxViewer {
 public:
  virtual ~BoxViewer() = default;

  // The newest view.
  virtual void OnView(const BoxView& view) = 0;
  // No more views follow. The viewer has been removed.
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

  // The game has connected; the link lives until Disconnect. `shows` says whether it shows boxes.
  void Connect(ClientStream& link, bool shows);
  void Disconnect();
  // The session has ended.
  void End();

  // Errors: FAILED_PRECONDITION (the game does not show its boxes), RESOURCE_EXHAUSTED (there are
  // kMaxViewers already).
  absl::Status Add(BoxViewer& viewer);
  // Does nothing if it was not added.
  void Remove(BoxViewer& viewer);
  // Drops the view if nobody looks.
  void OnView(const BoxView& view);

 private:
  // Asks the game, and again before the request runs out.
  void Ask();

  DecisionLoop& loop_;
  ClientStream* link_ = nullptr;  // null: the game is away
  bool shows_ = false;
  std::vector<BoxViewer*> viewers_;
  // The number of the latest request. Timers of earlier ones do nothing.
  std::shared_ptr<uint64_t> turn_ = std::make_shared<uint64_t>(0);
};

}  // namespace sweepstake::sessions
