// Writes the actions of administrators into the audit log: who ended a session, gave an order,
// imported, and made or revoked a token, and when.
//
// The rows belong to the session kAdminSession; each run of the daemon has one segment. They go to
// disk with the store's next commit. Rows that the disk refuses wait and are offered again. Any
// thread may call Record, only the decision loop the rest. The object lives until the loop has run
// its last task.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "engine_client/decider/audit/audit_log.h"
#include "server/sessions/common/decision_loop.h"
#include "server/sessions/common/options.h"
#include "server/sessions/prior_store.h"
#include "server/sessions/session_ledger.h"

namespace sweepstake::sessions {

class AdminLog {
 public:
  // The maximum number of rows that wait while the store cannot be read. More are lost and counted.
  static constexpr size_t kMaxWaiting = 1'000;

  AdminLog(DecisionLoop& loop, priors::AsyncPriorStore& store, SessionCounters& counters)
      : loop_(loop), store_(store), counters_(counters) {}

  // `action` and `who` are lines of text.
  void Record(std::string action, std::string who);

  // Repeats a read or write that the store failed.
  void Retry();
  // Appends the updates that are not on disk.
  void AppendWaiting(std::vector<priors::SourceUpdate>& updates) const {
    if (ledger_ != nullptr) ledger_->AppendWaiting(updates);
  }
  // Returns whether a read or commit is under way.
  bool committing() const { return loading_ || (ledger_ != nullptr && ledger_->committing()); }

 private:
  struct Action {
    std::string action;
    std::string who;
    int64_t now_ns = 0;
    int64_t unix_ms = 0;
    uint64_t sequence = 0;  // of its row; 0 before the ledger has it
  };

  void Write();
  void Load();
  void OnLoaded(const absl::StatusOr<std::optional<priors::SourceState>>& state);
  // Begins a new segment after another daemon's, with the rows that were not written.
  void StartAgain();

  DecisionLoop& loop_;
  priors::AsyncPriorStore& store_;
  SessionCounters& counters_;
  std::deque<Action> waiting_;  // for the ledger
  std::deque<Action> offered_;  // in the ledger, perhaps not in the store
  bool loading_ = false;
  std::shared_ptr<SessionLedger> ledger_;  // null before the store has been read
  std::optional<decision::AdminRows> rows_;
  uint64_t sequence_ = 0;  // of the latest row, over all segments
};

}  // namespace sweepstake::sessions
