// Stored evidence, in the form in which stores, priors files and the command line exchange it.
// Plain values.
#pragma once

#include <compare>
#include <cstdint>
#include <string>
#include <tuple>

#include "engine_client/math/saturating_sum.h"

namespace sweepstake {

// Identifies the subject of evidence. Evidence with different keys is never merged. Names have 1 to
// 128 bytes, with the exceptions stated below.
struct EvidenceKey {
  std::string project;
  std::string scene;
  std::string measured_by;  // empty for the frame thread, else "lane"
  std::string arm;
  uint32_t backend_version = 1;  // >= 1
  std::string machine_class;     // may be empty: the unknown class
  uint32_t reward_version = 1;   // >= 1
  // The regime in which it was measured: a bucket (policy/regime_bucket.h). Empty: unknown.
  std::string regime = {};

  // Written out, because libc++ before version 16 cannot order strings by <=>.
  friend std::strong_ordering operator<=>(const EvidenceKey& a, const EvidenceKey& b) {
    for (const auto field : {&EvidenceKey::project, &EvidenceKey::scene, &EvidenceKey::regime,
                             &EvidenceKey::measured_by, &EvidenceKey::arm}) {
      if (const int order = (a.*field).compare(b.*field); order != 0) return order <=> 0;
    }
    if (a.backend_version != b.backend_version) return a.backend_version <=> b.backend_version;
    if (const int order = a.machine_class.compare(b.machine_class); order != 0) return order <=> 0;
    return a.reward_version <=> b.reward_version;
  }
  friend bool operator==(const EvidenceKey&, const EvidenceKey&) = default;
};

// An amount of evidence. It does not include a prior such as Beta(1,1).
struct Evidence {
  double alpha = 0;           // finite, 0 to < 1e15
  double beta = 0;            // finite, 0 to < 1e15
  uint64_t window_count = 0;  // windows, or visits of the lane
  uint64_t bail_out_count = 0;

  Evidence& operator+=(const Evidence& other) {
    alpha += other.alpha;
    beta += other.beta;
    window_count = decision::SaturatingSum(window_count, other.window_count);
    bail_out_count = decision::SaturatingSum(bail_out_count, other.bail_out_count);
    return *this;
  }
  friend bool operator==(const Evidence&, const Evidence&) = default;
};

// The evidence of one source about one key.
struct PriorRecord {
  EvidenceKey key;
  std::string source_id;         // a session, or '*' and a build for a sum (priors_sums.h)
  uint64_t source_sequence = 0;  // number of the source's latest commit that is included, from 1
  Evidence evidence;
  std::string build = {};         // build of the source; empty if unknown
  uint64_t last_seen_unix_s = 0;  // when the source last learnt; below 2^63; 0 if unknown
  // A daemon sets these on export; imports ignore them. Priors files do not contain is_imported.
  bool is_imported = false;     // the source is not a session of the exporting store
  bool is_quarantined = false;  // waits for promotion and does not count until then

  friend bool operator==(const PriorRecord&, const PriorRecord&) = default;
};

// Returns the identity of the record. Two records with the same identity are versions of the same
// evidence. A source may have two records of one key: an older one that counts and one in
// quarantine.
inline auto KeyOf(const PriorRecord& record) {
  return std::tie(record.key, record.source_id, record.is_quarantined);
}

}  // namespace sweepstake
