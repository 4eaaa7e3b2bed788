// Sums of builds: per key and build one record, the sum over all sources, without their names. A
// game ships them (priors_file.h).
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "engine_client/decider/pooling/prior_record.h"

namespace sweepstake {

// First character of the source of a sum. No session's source begins with it.
inline constexpr char kSumMark = '*';

// Adds records up, in any order. Records in quarantine are left out. It holds one record per key
// and build.
class BuildSums {
 public:
  void Add(PriorRecord record);

  // Returns the sums, ordered by KeyOf; call it once. A sum's sequence
  // number is its number of windows or visits. So of two sums of a build, the one with more
  // evidence counts.
  std::vector<PriorRecord> Take();

 private:
  std::map<std::pair<EvidenceKey, std::string>, PriorRecord> sums_;  // by key and source
};

// Returns the sums of all these records.
std::vector<PriorRecord> SumByBuild(std::vector<PriorRecord> records);

// Returns whether the record is a sum. Stores do not import sums, because they cannot detect how
// much of a sum they already contain.
bool IsSum(const PriorRecord& record);

// Makes a sum of the record's evidence: sets its source and its sequence number.
void MarkAsSum(PriorRecord& record);

}  // namespace sweepstake
