// The evidence of an embedded decider: the records that it was given, and what its session learns,
// which is added to records of the session's own source.
//
// A source that the given records already contain is continued: its records grow and their sequence
// numbers rise, so a store replaces an earlier export with a later one. Not thread-safe. Memory:
// that of the given records, and two records per arm.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "engine_client/decider/embedded/priors_file.h"
#include "engine_client/decider/pooling/prior.h"
#include "engine_client/decider/types.h"

namespace sweepstake {

// Returns all records of both. If both have a record with the same KeyOf, the one with the higher
// sequence number is kept.
std::vector<PriorRecord> Unite(std::vector<PriorRecord> records, std::vector<PriorRecord> others);

class EvidenceLedger {
 public:
  // REQUIRES: no two records of `given` have the same KeyOf; ParsePriors and Unite ensure that.
  // `key` names the session and its own source.
  EvidenceLedger(std::vector<PriorRecord> given, decision::PriorKey key);

  // Returns the prior that follows from the given records.
  const decision::Prior& prior() const { return prior_; }

  // Adds what the decision learnt. REQUIRES: increments are of the key's arms.
  void Add(const decision::Decision& decision);

  // Returns the given records together with the added evidence.
  const std::vector<PriorRecord>& records() const { return records_; }

 private:
  void Add(const decision::Increment& increment, std::string_view measured_by);
  PriorRecord& OwnRecord(size_t arm, std::string_view measured_by);

  const decision::PriorKey key_;
  std::vector<PriorRecord> records_;
  uint64_t sequence_ = 0;  // the highest of the own source
  const decision::Prior prior_;
};

}  // namespace sweepstake
