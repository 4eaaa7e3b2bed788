// Which rows of the audit log a request selects, and the setups that the rows refer to.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"
#include "sweepstake/v1/audit.pb.h"

namespace sweepstake::rpc {

// Returns the time of a row by the daemon's wall clock. Returns nothing if the row has no time, or
// if `setup`, which is the setup of its segment, is null.
std::optional<int64_t> UnixMsOf(const v1::AuditRow& row, const v1::AuditSetup* setup);

// The setups of segments. Each is read once, and without fields that only a replay needs. Used on
// the store's reading thread.
class SegmentSetups {
 public:
  // Returns the setup of the segment; null if its first row was removed or does not parse. The
  // result is valid until this object is destroyed.
  absl::StatusOr<const v1::AuditSetup*> Load(priors::PriorReader& store, uint64_t segment_id);

 private:
  std::map<uint64_t, std::optional<v1::AuditSetup>> setups_;
};

// Adds the setup of the row's segment to a response.
template <typename Response>
void AddSetup(const v1::AuditRow& row, const v1::AuditSetup& setup, Response& response) {
  v1::SegmentSetup& added = *response.add_setups();
  added.set_session_id(row.session());
  added.set_segment(row.segment());
  *added.mutable_setup() = setup;
}

// The conditions of a DecisionFilter on a row itself. The store checks the others: session, project
// and scene.
class RowFilter {
 public:
  explicit RowFilter(const v1::DecisionFilter& filter) : filter_(filter) {}

  bool has_times() const { return filter_.unix_from_ms() != 0 || filter_.unix_until_ms() != 0; }
  int64_t unix_from_ms() const { return filter_.unix_from_ms(); }
  int64_t unix_until_ms() const { return filter_.unix_until_ms(); }
  // Returns whether the filter selects all rows.
  bool empty() const;
  // `setup` is the setup of the row's segment. It is used only if has_times().
  bool Matches(const v1::AuditRow& row, const v1::AuditSetup* setup) const;

 private:
  v1::DecisionFilter filter_;
};

}  // namespace sweepstake::rpc
