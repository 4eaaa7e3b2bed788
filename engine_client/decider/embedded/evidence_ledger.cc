#include "engine_client/decider/embedded/evidence_ledger.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

namespace sweepstake {
namespace {

decision::ArmRecord ArmRecordOf(const PriorRecord& record) {
  return {.project = record.key.project,
          .scene = record.key.scene,
          .machine_class = record.key.machine_class,
          .reward_version = record.key.reward_version,
          .source = record.source_id,
          .build = record.build,
          .arm = record.key.arm,
          .backend_version = record.key.backend_version,
          .evidence = decision::EvidenceBy(record.key.measured_by, record.evidence),
          .regime = record.key.regime};
}

decision::Prior PriorOf(std::span<const PriorRecord> records, const decision::PriorKey& key) {
  std::vector<decision::ArmRecord> arms;
  arms.reserve(records.size());
  for (const PriorRecord& record : records) arms.push_back(ArmRecordOf(record));
  return decision::PriorFor(arms, key);
}

}  // namespace

std::vector<PriorRecord> Unite(std::vector<PriorRecord> records, std::vector<PriorRecord> others) {
  std::set<PriorRecord*, bool (*)(const PriorRecord*, const PriorRecord*)> known(
      [](const PriorRecord* a, const PriorRecord* b) { return KeyOf(*a) < KeyOf(*b); });
  for (PriorRecord& record : records) known.insert(&record);
  std::vector<PriorRecord> fresh;
  for (PriorRecord& other : others) {
    const auto found = known.find(&other);
    if (found == known.end()) {
      fresh.push_back(std::move(other));
    } else if (other.source_sequence > (*found)->source_sequence) {
      **found = std::move(other);
    }
  }
  std::move(fresh.begin(), fresh.end(), std::back_inserter(records));
  return records;
}

EvidenceLedger::EvidenceLedger(std::vector<PriorRecord> given, decision::PriorKey key)
    : key_(std::move(key)), records_(std::move(given)), prior_(PriorOf(records_, key_)) {
  for (const PriorRecord& record : records_) {
    if (record.source_id == key_.source) sequence_ = std::max(sequence_, record.source_sequence);
  }
}

void EvidenceLedger::Add(const decision::Decision& decision) {
  if (decision.increment) Add(*decision.increment, {}, decision.regime);
  for (const decision::Increment& increment : decision.lane_increments)
    Add(increment, decision::kLaneName, decision.regime);
}

void EvidenceLedger::Add(const decision::Increment& increment, std::string_view measured_by,
                         std::string_view regime) {
  PriorRecord& record = OwnRecord(increment.arm, measured_by, regime);
  record.source_sequence = ++sequence_;
  record.evidence.alpha += increment.alpha;
  record.evidence.beta += increment.beta;
  record.evidence.window_count += increment.window_count;
  record.evidence.bail_out_count += increment.bail_out_count;
}

PriorRecord& EvidenceLedger::OwnRecord(size_t arm, std::string_view measured_by,
                                       std::string_view regime) {
  const auto found = std::find_if(records_.begin(), records_.end(), [&](const PriorRecord& record) {
    return record.source_id == key_.source && record.key.measured_by == measured_by &&
           record.key.regime == regime && record.key.project == key_.project &&
           record.key.scene == key_.scene && record.key.machine_class == key_.machine_class &&
           record.key.reward_version == key_.reward_version && record.key.arm == key_.arms[arm] &&
           record.key.backend_version == key_.backend_versions[arm];
  });
  if (found != records_.end()) return *found;
  PriorRecord& record = records_.emplace_back();
  record.key.project = key_.project;
  record.key.scene = key_.scene;
  record.key.measured_by = measured_by;
  record.key.arm = key_.arms[arm];
  record.key.backend_version = key_.backend_versions[arm];
  record.key.machine_class = key_.machine_class;
  record.key.reward_version = key_.reward_version;
  record.key.regime = regime;
  record.source_id = key_.source;
  record.build = key_.build;
  return record;
}

}  // namespace sweepstake
