#include "server/rpc/sessions/session_ledger.h"

#include <utility>

#include "server/rpc/common/options.h"

namespace sweepstake::rpc {

SessionLedger::SessionLedger(priors::AsyncPriorStore& store, DecisionLoop& loop, Counters& counters,
                             priors::SourceProgress progress,
                             std::function<void(const absl::Status&)> on_committed)
    : store_(store),
      loop_(loop),
      counters_(counters),
      on_committed_(std::move(on_committed)),
      progress_(std::move(progress)),
      durable_sequence_(progress_.message_sequence) {}

void SessionLedger::Add(const priors::KeyedEvidence& increment) {
  waiting_[increment.key] += increment.evidence;
}

void SessionLedger::AddAuditRow(std::string_view row) {
  if (audit_cut_) return;
  if (audit_bytes_ + row.size() > kMaxWaitingAuditBytes) {
    audit_cut_ = true;
    ++counters_.cut_audit_log_count;
    return;
  }
  audit_.rows.emplace_back(row);
  audit_bytes_ += row.size();
}

void SessionLedger::Checkpoint(const Position& position) {
  const bool unknown_to_store = progress_.commit_sequence == 0 && !offered_;
  if (position.message_sequence > progress_.message_sequence || !waiting_.empty() ||
      !audit_.rows.empty() || unknown_to_store)
    checkpointed_ = true;
  progress_.message_sequence = position.message_sequence;
  progress_.explored_arm_count = position.explored_arm_count;
  progress_.decision_count = position.decision_count;
  progress_.frame_count = position.frame_count;
  CommitNext();
}

void SessionLedger::CommitNext() {
  if (in_flight_) return;
  if (!offered_) {
    if (!checkpointed_) return;
    ++progress_.commit_sequence;
    offered_ = priors::SourceUpdate{.progress = progress_, .increments = {}, .audit = audit_};
    audit_.first_row += audit_.rows.size();
    audit_.rows.clear();
    audit_bytes_ = 0;
    for (auto& [key, evidence] : waiting_) offered_->increments.push_back({key, evidence});
    waiting_.clear();
    checkpointed_ = false;
  }
  Offer();
}

void SessionLedger::Offer() {
  in_flight_ = true;
  store_.Commit(*offered_, [weak = weak_from_this(), &loop = loop_](const absl::Status& status) {
    loop.Post([weak, status] {
      if (const auto self = weak.lock()) self->OnCommitted(status);
    });
  });
}

void SessionLedger::OnCommitted(const absl::Status& status) {
  in_flight_ = false;
  if (status.ok()) {
    ++counters_.stored_commit_count;
    durable_sequence_ = offered_->progress.message_sequence;
    offered_.reset();
  } else {
    ++counters_.failed_commit_count;
    // An update that can never be stored must not block those after it.
    if (absl::IsInvalidArgument(status)) offered_.reset();
  }
  on_committed_(status);
  if (!offered_) CommitNext();
}

}  // namespace sweepstake::rpc
