#include "server/storage/memory/memory_audit_log.h"

#include <algorithm>

#include "engine_client/decider/audit/audit_log.h"

namespace sweepstake::storage {

using priors::AuditRow;
using priors::AuditRows;
using priors::AuditSegment;

uint64_t MemoryAuditLog::Append(const priors::SourceUpdate& update) {
  uint64_t lost = 0;
  Chunk* chunk = nullptr;
  for (const AuditRow& row : update.audit.rows) {
    if (!IsStorable(update.audit, row)) {
      ++lost;
      continue;
    }
    Segment& segment = Find(update.progress.source_id, update.audit);
    if (!segment.rows.empty() && row.number <= segment.rows.rbegin()->first) continue;
    segment.rows.emplace(row.number, row.text);
    if (segment.head.session_id == decision::kAdminSession) {
      admin_rows_.emplace_back(segment.head.id, row.number);
      continue;
    }
    if (chunk == nullptr) chunk = &LatestChunk(update.unix_time_s);
    chunk->rows.emplace_back(segment.head.id, row.number);
    chunk->byte_count += row.text.size();
    byte_count_ += row.text.size();
  }
  Trim(update.unix_time_s);
  return lost;
}

MemoryAuditLog::Segment& MemoryAuditLog::Find(const std::string& session_id,
                                              const AuditRows& rows) {
  for (auto& [id, segment] : segments_) {
    if (segment.head.session_id == session_id && segment.head.segment == rows.segment)
      return segment;
  }
  AuditSegment head{.id = ++last_id_,
                    .session_id = session_id,
                    .segment = rows.segment,
                    .project = rows.project,
                    .scene = rows.scene,
                    .unix_start_ms = rows.unix_start_ms};
  return segments_.emplace(last_id_, Segment{std::move(head), {}}).first->second;
}

MemoryAuditLog::Chunk& MemoryAuditLog::LatestChunk(uint64_t unix_now_s) {
  if (chunks_.empty() || IsFull(chunks_.back(), limits_, unix_now_s))
    chunks_.emplace_back().unix_start_s = unix_now_s;
  return chunks_.back();
}

void MemoryAuditLog::Trim(uint64_t unix_now_s) {
  while (!chunks_.empty() && IsBeyond(chunks_.front(), byte_count_, limits_, unix_now_s)) {
    for (const auto& [id, number] : chunks_.front().rows) Remove(id, number);
    byte_count_ -= chunks_.front().byte_count;
    chunks_.pop_front();
  }
  for (; admin_rows_.size() > limits_.admin_row_count; admin_rows_.pop_front())
    Remove(admin_rows_.front().first, admin_rows_.front().second);
}

void MemoryAuditLog::Remove(uint64_t segment_id, uint64_t number) {
  const auto segment = segments_.find(segment_id);
  segment->second.rows.erase(number);
  if (segment->second.rows.empty()) segments_.erase(segment);
}

uint32_t MemoryAuditLog::LastSegment(const std::string& session_id) const {
  uint32_t last = 0;
  for (const auto& [id, segment] : segments_) {
    if (segment.head.session_id == session_id) last = std::max(last, segment.head.segment);
  }
  return last;
}

std::vector<AuditSegment> MemoryAuditLog::List(const priors::AuditFilter& filter, uint64_t after,
                                               uint32_t limit) const {
  std::vector<AuditSegment> list;
  for (auto at = segments_.upper_bound(after); at != segments_.end() && list.size() < limit; ++at) {
    const auto& [head, rows] = at->second;
    const priors::SceneFilter scenes{filter.project, filter.scene, filter.projects};
    if (!filter.session_id.empty() && filter.session_id != head.session_id) continue;
    if (!scenes.Matches(head.project, head.scene)) continue;
    AuditSegment& segment = list.emplace_back(head);
    segment.first_row = rows.begin()->first;
    segment.row_count = rows.size();
    segment.lost_row_count = rows.rbegin()->first - segment.first_row + 1 - segment.row_count;
  }
  return list;
}

std::vector<AuditRow> MemoryAuditLog::Load(uint64_t segment_id, uint64_t first_row, uint32_t limit,
                                           size_t max_bytes) const {
  const auto segment = segments_.find(segment_id);
  if (segment == segments_.end()) return {};
  const auto& stored = segment->second.rows;
  std::vector<AuditRow> rows;
  size_t bytes = 0;
  for (auto at = stored.lower_bound(first_row);
       at != stored.end() && rows.size() < limit && bytes < max_bytes; ++at) {
    rows.push_back({.number = at->first, .text = at->second});
    bytes += at->second.size();
  }
  return rows;
}

}  // namespace sweepstake::storage
