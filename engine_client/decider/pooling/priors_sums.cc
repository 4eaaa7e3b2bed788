#include "engine_client/decider/pooling/priors_sums.h"

#include <algorithm>
#include <cstdint>
#include <limits>

#include "engine_client/math/hash.h"

namespace sweepstake {

void BuildSums::Add(PriorRecord record) {
  if (record.is_quarantined) return;
  MarkAsSum(record);
  std::pair key(record.key, record.source_id);
  const auto found = sums_.find(key);
  if (found == sums_.end()) {
    sums_.emplace(std::move(key), std::move(record));
    return;
  }
  PriorRecord& sum = found->second;
  sum.evidence += record.evidence;
  sum.last_seen_unix_s = std::max(sum.last_seen_unix_s, record.last_seen_unix_s);
}

std::vector<PriorRecord> BuildSums::Take() {
  std::vector<PriorRecord> sums;
  sums.reserve(sums_.size());
  for (auto& [key, sum] : sums_) {
    MarkAsSum(sum);
    sums.push_back(std::move(sum));
  }
  return sums;
}

std::vector<PriorRecord> SumByBuild(std::vector<PriorRecord> records) {
  BuildSums sums;
  for (PriorRecord& record : records) sums.Add(std::move(record));
  return sums.Take();
}

bool IsSum(const PriorRecord& record) { return record.source_id.starts_with(kSumMark); }

void MarkAsSum(PriorRecord& record) {
  record.source_id = kSumMark + math::HexOf(math::Fnv1a(math::kFnv1aStart, record.build));
  record.source_sequence =
      std::clamp<uint64_t>(record.evidence.window_count, 1, std::numeric_limits<int64_t>::max());
}

}  // namespace sweepstake
