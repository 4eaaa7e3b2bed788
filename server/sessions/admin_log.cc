#include "server/sessions/admin_log.h"

#include <span>
#include <utility>

#include "server/sessions/common/unix_time.h"

namespace sweepstake::sessions {
namespace {

// Stored as the project and the scene of the administrators' log, because it covers all projects.
constexpr const char* kAll = "*";

}  // namespace

void AdminLog::Record(std::string who, std::string action) {
  loop_.Post([this, who = std::move(who), action = std::move(action)]() mutable {
    if (waiting_.size() >= kMaxWaiting) {
      ++counters_.lost_audit_row_count;
      return;
    }
    waiting_.push_back(
        {std::move(who), std::move(action), loop_.clock().NowNs(), priors::UnixNowMs()});
    Write();
  });
}

void AdminLog::Write() {
  if (ledger_ == nullptr) return Load();
  std::erase_if(offered_, [durable = ledger_->durable_sequence()](const Action& action) {
    return action.sequence <= durable;
  });
  for (Action& action : waiting_) {
    ledger_->AddAuditRow(options_.encode_audit_row(
        rows_->Next(action.now_ns, action.unix_ms, action.who, action.action)));
    action.sequence = ++sequence_;
    if (offered_.size() < kMaxWaiting) offered_.push_back(std::move(action));
  }
  waiting_.clear();
  ledger_->Checkpoint({.message_sequence = sequence_});
}

void AdminLog::Load() {
  if (loading_) return;
  loading_ = store_.Submit([this](priors::PriorStore& store) {
    loop_.Post([this, state = store.LoadSource(std::string(decision::kAdminSession))] {
      loading_ = false;
      OnLoaded(state);
    });
  });
}

void AdminLog::OnLoaded(const absl::StatusOr<std::optional<priors::SourceState>>& state) {
  if (!state.ok()) return;  // the next Retry reads again
  const priors::SourceState before = state->value_or(priors::SourceState{});
  priors::SourceProgress progress = before.progress;
  progress.source_id = decision::kAdminSession;
  sequence_ = progress.message_sequence;
  ledger_ = std::make_shared<SessionLedger>(
      store_, loop_, counters_, std::move(progress),
      [this](const absl::Status& status, std::span<const priors::KeyedEvidence>) {
        if (absl::IsFailedPrecondition(status)) loop_.Post([this] { StartAgain(); });
      });
  const uint32_t segment = before.audit_segment + 1;
  ledger_->StartAudit({.segment = segment,
                       .project = kAll,
                       .scene = kAll,
                       .unix_start_ms = priors::UnixNowMs(),
                       .rows = {}});
  rows_.emplace(segment);
  Write();
}

void AdminLog::StartAgain() {
  for (; !offered_.empty(); offered_.pop_back()) {
    if (offered_.back().sequence > ledger_->durable_sequence())
      waiting_.push_front(std::move(offered_.back()));
  }
  ledger_.reset();
  if (!waiting_.empty()) Load();
}

void AdminLog::Retry() {
  if (ledger_ != nullptr) return ledger_->Retry();
  if (!waiting_.empty()) Load();
}

}  // namespace sweepstake::sessions
