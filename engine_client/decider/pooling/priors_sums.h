// Sums of builds. A sum is one record per key and build that adds up all sources of that build,
// without their names. Games ship sums (priors_file.h).
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "engine_client/decider/pooling/prior_record.h"

namespace sweepstake {

// A sum's source_id begins with this character. No session's source_id does.
inline constexpr char kSumMark = '*';

// Adds up records, which may come in any order. Records in quarantine are left out. Holds one
// record per key and build.
class BuildSums {
 public:
  void Add(PriorRecord record);

  // Returns the sums, ordered by KeyOf. Call it once. A sum's sequence number is its number of
  // windows or visits, so when two sums of a build are merged, the sum with more evidence is kept.
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
