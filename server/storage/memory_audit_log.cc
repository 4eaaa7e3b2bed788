#include "server/storage/memory_audit_log.h"

#include <algorithm>

#include "server/storage/record_limits.h"

namespace sweepstake::storage {

using priors::AuditRows;
using priors::AuditSegment;

void MemoryAuditLog::Append(const std::string& session_id, const AuditRows& rows) {
  const uint64_t room = AuditRoom(limits_, RowCount(session_id));
  const size_t count = StorableAuditRows(rows, room);
  if (count == 0) return;
  Segment* segment = Find(session_id, rows);
  if (segment == nullptr) return;
  segment->rows.insert(segment->rows.end(), rows.rows.begin(),
                       rows.rows.begin() + static_cast<std::ptrdiff_t>(count));
  segment->head.row_count += count;
  row_count_ += count;
  Trim();
}

MemoryAuditLog::Segment* MemoryAuditLog::Find(const std::string& session_id,
                                              const AuditRows& rows) {
  const auto found = std::find_if(segments_.begin(), segments_.end(), [&](const Segment& each) {
    return each.head.session_id == session_id && each.head.segment == rows.segment;
  });
  const uint64_t stored = found == segments_.end() ? 0 : found->head.row_count;
  if (rows.first_row != stored + 1) return nullptr;
  if (found != segments_.end()) return &*found;
  AuditSegment head{.id = ++last_id_,
                    .session_id = session_id,
                    .segment = rows.segment,
                    .project = rows.project,
                    .scene = rows.scene,
                    .unix_start_ms = rows.unix_start_ms,
                    .row_count = 0};
  return &segments_.emplace_back(Segment{std::move(head), {}});
}

uint64_t MemoryAuditLog::RowCount(const std::string& session_id) const {
  uint64_t count = 0;
  for (const Segment& each : segments_)
    count += each.head.session_id == session_id ? each.head.row_count : 0;
  return count;
}

void MemoryAuditLog::Trim() {
  while (row_count_ > limits_.rows) {
    row_count_ -= segments_.front().head.row_count;
    segments_.pop_front();
  }
}

uint32_t MemoryAuditLog::LastSegment(const std::string& session_id) const {
  uint32_t last = 0;
  for (const Segment& each : segments_) {
    if (each.head.session_id == session_id) last = std::max(last, each.head.segment);
  }
  return last;
}

std::vector<AuditSegment> MemoryAuditLog::List(const priors::AuditFilter& filter, uint64_t after,
                                               uint32_t limit) const {
  const auto matches = [](const std::string& wanted, const std::string& is) {
    return wanted.empty() || wanted == is;
  };
  std::vector<AuditSegment> list;
  for (const Segment& each : segments_) {
    const AuditSegment& head = each.head;
    if (list.size() == limit) break;
    if (head.id > after && matches(filter.session_id, head.session_id) &&
        matches(filter.project, head.project) && matches(filter.scene, head.scene)) {
      list.push_back(head);
    }
  }
  return list;
}

std::vector<std::string> MemoryAuditLog::Load(uint64_t segment_id, uint64_t first_row,
                                              uint32_t limit, size_t max_bytes) const {
  std::vector<std::string> rows;
  size_t bytes = 0;
  for (const Segment& each : segments_) {
    if (each.head.id != segment_id) continue;
    for (size_t i = first_row - 1; i < each.rows.size() && rows.size() < limit; ++i) {
      if (bytes >= max_bytes) break;
      bytes += rows.emplace_back(each.rows[i]).size();
    }
  }
  return rows;
}

}  // namespace sweepstake::storage
