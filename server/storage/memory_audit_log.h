// The audit log of the store in memory, for tests. Not thread-safe; bounded by its limits.
#pragma once

#include <deque>
#include <string>
#include <vector>

#include "server/priors/prior_store.h"

namespace sweepstake::storage {

class MemoryAuditLog {
 public:
  explicit MemoryAuditLog(const priors::AuditLimits& limits) : limits_(limits) {}

  void Append(const std::string& session_id, const priors::AuditRows& rows);
  // 0: none.
  uint32_t LastSegment(const std::string& session_id) const;
  std::vector<priors::AuditSegment> List(const priors::AuditFilter& filter, uint64_t after,
                                         uint32_t limit) const;
  std::vector<std::string> Load(uint64_t segment_id, uint64_t first_row, uint32_t limit,
                                size_t max_bytes) const;

 private:
  struct Segment {
    priors::AuditSegment head;
    std::vector<std::string> rows;
  };

  // Null: the rows do not go on from anything.
  Segment* Find(const std::string& session_id, const priors::AuditRows& rows);
  uint64_t RowCount(const std::string& session_id) const;
  void Trim();

  const priors::AuditLimits limits_;
  std::deque<Segment> segments_;  // as they began
  uint64_t last_id_ = 0;
  uint64_t row_count_ = 0;
};

}  // namespace sweepstake::storage
