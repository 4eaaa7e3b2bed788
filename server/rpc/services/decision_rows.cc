#include "server/rpc/services/decision_rows.h"

#include <algorithm>

#include "server/rpc/common/options.h"

namespace sweepstake::rpc {
namespace {

template <typename List, typename Value>
bool Contains(const List& list, Value value) {
  return list.empty() || std::find(list.begin(), list.end(), value) != list.end();
}

}  // namespace

std::optional<int64_t> UnixMsOf(const v1::AuditRow& row, const v1::AuditSetup* setup) {
  if (row.has_unix_ms()) return row.unix_ms();
  if (setup == nullptr || !row.has_time_ns()) return std::nullopt;
  return setup->unix_start_ms() + (row.time_ns() - setup->start_ns()) / kNsPerMs;
}

absl::StatusOr<const v1::AuditSetup*> SegmentSetups::Load(priors::PriorReader& store,
                                                          uint64_t segment_id) {
  const auto [place, is_new] = setups_.try_emplace(segment_id);
  std::optional<v1::AuditSetup>& setup = place->second;
  if (is_new) {
    const auto rows = store.LoadAudit(segment_id, 1, 1, priors::kMaxAuditRowBytes);
    if (!rows.ok()) return rows.status();
    v1::AuditRow first;
    if (!rows->empty() && rows->front().number == 1 && first.ParseFromString(rows->front().bytes) &&
        first.has_setup()) {
      setup = std::move(*first.mutable_setup());
      setup->clear_prior_sources();
      setup->clear_regimes();
      setup->clear_regime_priors();
    }
  }
  return setup ? &*setup : nullptr;
}

bool RowFilter::empty() const {
  return filter_.kinds().empty() && filter_.outcomes().empty() && filter_.arm().empty() &&
         !has_times();
}

bool RowFilter::Matches(const v1::AuditRow& row, const v1::AuditSetup* setup) const {
  if (!Contains(filter_.kinds(), row.kind())) return false;
  if (!filter_.outcomes().empty() &&
      (!row.has_decision() || !Contains(filter_.outcomes(), row.decision().outcome())))
    return false;
  if (const std::string& arm = filter_.arm(); !arm.empty() && row.arm() != arm &&
                                              row.decision().active_arm() != arm &&
                                              row.decision().candidate() != arm)
    return false;
  if (!has_times()) return true;
  const std::optional<int64_t> time_ms = UnixMsOf(row, setup);
  return time_ms && *time_ms >= filter_.unix_from_ms() &&
         (filter_.unix_until_ms() == 0 || *time_ms < filter_.unix_until_ms());
}

}  // namespace sweepstake::rpc
