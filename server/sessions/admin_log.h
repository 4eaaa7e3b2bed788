// What administrators do, in the audit log: who ended a session, ordered, imported, made or revoked
// a token, and when.
//
// The rows are under the session kAdminSession, in a segment of each run of the daemon, and go to
// disk at once, as the store commits. Those that the disk refuses wait, and are offered again.
// Record may be called by any thread, the rest by the decision loop; the object lives until the
// loop has run its last task.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "engine_client/decider/audit/audit_log.h"
#include "server/rpc/common/options.h"
#include "server/sessions/decision_loop.h"
#include "server/sessions/prior_store.h"
#include "server/sessions/session_ledger.h"

namespace sweepstake::rpc {

class AdminLog {
 public:
  // Rows that wait while the store cannot be read; the next ones are lost, and counted.
  static constexpr size_t kMaxWaiting = 1'000;

  AdminLog(DecisionLoop& loop, priors::AsyncPriorStore& store, Counters& counters)
      : loop_(loop), store_(store), counters_(counters) {}

  // `action` and `who` are lines of text.
  void Record(std::string action, std::string who);

  // Offers the store again what it has failed to read or write.
  void Retry();
  // Appends what waits for the disk, as it is to be committed.
  void AppendWaiting(std::vector<priors::SourceUpdate>& updates) const {
    if (ledger_ != nullptr) ledger_->AppendWaiting(updates);
  }
  // Returns whether the store has yet to answer.
  bool committing() const { return loading_ || (ledger_ != nullptr && ledger_->committing()); }

 private:
  struct Action {
    std::string action;
    std::string who;
    int64_t now_ns = 0;
    int64_t unix_ms = 0;
    uint64_t sequence = 0;  // once it is written, of its row
  };

  void Write();
  void Load();
  void OnLoaded(const absl::StatusOr<std::optional<priors::SourceState>>& state);
  // Begins a segment behind another daemon's, with what of this one's was not written.
  void StartAgain();

  DecisionLoop& loop_;
  priors::AsyncPriorStore& store_;
  Counters& counters_;
  std::deque<Action> waiting_;  // for the ledger
  std::deque<Action> offered_;  // that the ledger has, and the store maybe not
  bool loading_ = false;
  std::shared_ptr<SessionLedger> ledger_;  // null before the store has said what it has
  std::optional<decision::AdminRows> rows_;
  uint64_t sequence_ = 0;  // of the latest row, over all segments
};

}  // namespace sweepstake::rpc
