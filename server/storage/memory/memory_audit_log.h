// The audit log of the store in memory, bounded by its limits as those on disk are. Not
// thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "server/sessions/prior_store.h"
#include "server/storage/record_limits.h"

namespace sweepstake::storage {

class MemoryAuditLog {
 public:
  explicit MemoryAuditLog(const priors::AuditLimits& limits) : limits_(limits) {}

  // Returns how many of the rows cannot be stored.
  uint64_t Append(const priors::SourceUpdate& update);
  // Returns 0 if there is none.
  uint32_t LastSegment(const std::string& session_id) const;
  std::vector<priors::AuditSegment> List(const priors::AuditFilter& filter, uint64_t after,
                                         uint32_t limit) const;
  std::vector<priors::AuditRow> Load(uint64_t segment_id, uint64_t first_row, uint32_t limit,
                                     size_t max_bytes) const;

 private:
  struct Segment {
    priors::AuditSegment head;  // without the counts
    std::map<uint64_t, std::string> rows;
  };
  // The numbers of its rows, with their segments' ids.
  struct Chunk : AuditChunk {
    std::vector<std::pair<uint64_t, uint64_t>> rows;
  };

  // Adds the segment if there is none.
  Segment& Find(const std::string& session_id, const priors::AuditRows& rows);
  Chunk& LatestChunk(uint64_t unix_now_s);
  void Trim(uint64_t unix_now_s);
  void Remove(uint64_t segment_id, uint64_t number);

  const priors::AuditLimits limits_;
  std::map<uint64_t, Segment> segments_;  // by id
  std::deque<Chunk> chunks_;              // the oldest first
  // Those of kAdminSession, which are in no chunk, as in one.
  std::deque<std::pair<uint64_t, uint64_t>> admin_rows_;
  uint64_t last_id_ = 0;
  uint64_t byte_count_ = 0;
};

}  // namespace sweepstake::storage
