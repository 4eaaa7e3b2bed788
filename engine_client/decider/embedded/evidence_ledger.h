// The evidence of an embedded decider: the records that it started with, and records of its own
// source, to which it adds what its session learns.
//
// If the given records already contain the session's own source, the ledger continues that source:
// its records grow and their sequence numbers rise. A store therefore replaces an earlier export
// with a later one. Not thread-safe. Memory: the given records plus two records per arm and
// regime.
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

// Returns the records of both lists. If both have a record with the same KeyOf, keeps the record
// with the higher sequence number.
std::vector<PriorRecord> Unite(std::vector<PriorRecord> records, std::vector<PriorRecord> others);

class EvidenceLedger {
 public:
  // `given` are the records to start with. `key` names the session and its own source. REQUIRES: no
  // two records of `given` have the same KeyOf; ParsePriors and Unite ensure that.
  EvidenceLedger(std::vector<PriorRecord> given, decision::PriorKey key);

  // Returns the prior that follows from the given records.
  const decision::Prior& prior() const { return prior_; }

  // Adds the decision's increments to the records of the own source. REQUIRES: increments refer to
  // arms of the key.
  void Add(const decision::Decision& decision);

  // Returns the given records together with the added evidence.
  const std::vector<PriorRecord>& records() const { return records_; }

 private:
  void Add(const decision::Increment& increment, std::string_view measured_by,
           std::string_view regime);
  PriorRecord& OwnRecord(size_t arm, std::string_view measured_by, std::string_view regime);

  const decision::PriorKey key_;
  std::vector<PriorRecord> records_;
  uint64_t sequence_ = 0;  // highest sequence number of the own source
  const decision::Prior prior_;
};

}  // namespace sweepstake
