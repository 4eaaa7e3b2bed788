#include "engine_client/decider/embedded/evidence_ledger.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

namespace sweepstake {
namespace {

void Add(const PriorRecord& record, decision::ArmEvidence& evidence) {
  const bool by_lane = record.measured_by == decision::kLaneName;
  decision::EvidenceSum& sum = by_lane ? evidence.lane : evidence.live;
  sum.alpha += record.alpha_increment;
  sum.beta += record.beta_increment;
  if (!by_lane) evidence.bail_out_count += record.bail_out_count;
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

EvidenceLedger::EvidenceLedger(std::vector<PriorRecord> given, Key key,
                               std::span<const std::string> arms,
                               std::span<const uint32_t> arm_versions)
    : key_(std::move(key)),
      arms_(arms.begin(), arms.end()),
      arm_versions_(arm_versions.begin(), arm_versions.end()),
      records_(std::move(given)) {
  for (const PriorRecord& record : records_) {
    if (record.source_id == key_.source_id) sequence_ = std::max(sequence_, record.source_sequence);
  }
  TakeGiven();
}

bool EvidenceLedger::Applies(const PriorRecord& record, size_t arm) const {
  return record.project == key_.project && record.reward_version == key_.reward_version &&
         record.arm == arms_[arm] && record.backend_version == arm_versions_[arm];
}

EvidenceLedger::Scenes EvidenceLedger::ScenesOfProject() const {
  Scenes scenes;
  for (const PriorRecord& record : records_) {
    for (size_t arm = 0; arm < arms_.size(); ++arm) {
      if (!Applies(record, arm)) continue;
      Scene& scene = scenes[{record.scene, record.machine_class}];
      scene.arms.resize(arms_.size());
      scene.sources.insert(record.source_id);
      sweepstake::Add(record, scene.arms[arm]);
    }
  }
  return scenes;
}

// Of an arm that a source knows in several versions, the session's counts, or else the latest.
EvidenceLedger::Sources EvidenceLedger::SourcesOfScene() const {
  Sources sources;
  for (const PriorRecord& record : records_) {
    if (record.project != key_.project || record.scene != key_.scene ||
        record.reward_version != key_.reward_version)
      continue;
    const auto named = std::find(arms_.begin(), arms_.end(), record.arm);
    if (named == arms_.end()) continue;
    const auto arm = static_cast<size_t>(named - arms_.begin());
    Source& source = sources[{record.source_id, record.machine_class}];
    source.relation = {.same_build = record.build == key_.build,
                       .same_machine_class = record.machine_class == key_.machine_class};
    source.arms.resize(arms_.size());
    source.versions.resize(arms_.size());
    uint32_t& version = source.versions[arm];
    const bool is_wanted = record.backend_version == arm_versions_[arm];
    if (record.backend_version != version) {
      if (version == arm_versions_[arm] || (!is_wanted && record.backend_version < version))
        continue;
      version = record.backend_version;
      source.arms[arm] = {};
    }
    sweepstake::Add(record, source.arms[arm]);
  }
  return sources;
}

void EvidenceLedger::TakeSources() {
  std::vector<decision::SourceEvidence> others;
  const Sources sources = SourcesOfScene();
  for (const auto& [name, source] : sources) {
    const std::vector<decision::EvidenceSum> pooled = decision::PoolEvidence(source.arms);
    if (name == std::pair(key_.source_id, key_.machine_class)) {
      given_ = pooled;
      continue;
    }
    decision::SourceEvidence& other = others.emplace_back();
    for (size_t arm = 0; arm < arms_.size(); ++arm) {
      const bool same = source.versions[arm] == arm_versions_[arm];
      other.push_back({pooled[arm], decision::PowerPriorWeight(source.relation, same)});
    }
  }
  given_ = decision::CombineSources(others, given_);
  prior_source_count_ = sources.size();
}

// Those of this machine class, or of all classes where it has none.
void EvidenceLedger::TakeOtherScenes(const Scenes& scenes) {
  const auto is_of_class = [&](const auto& named) {
    return named.first.first != key_.scene && named.first.second == key_.machine_class;
  };
  const bool takes_all = std::none_of(scenes.begin(), scenes.end(), is_of_class);
  std::vector<std::vector<decision::EvidenceSum>> others;
  uint64_t source_count = 0;
  for (const auto& named : scenes) {
    if (named.first.first == key_.scene || !(takes_all || is_of_class(named))) continue;
    others.push_back(decision::PoolEvidence(named.second.arms));
    source_count += named.second.sources.size();
  }
  given_ = decision::WithOtherScenes(std::move(given_), others);
  if (prior_source_count_ == 0) prior_source_count_ = source_count;
}

void EvidenceLedger::TakeGiven() {
  const Scenes scenes = ScenesOfProject();
  given_.resize(arms_.size());
  if (key_.compares_sources) {
    TakeSources();
    TakeOtherScenes(scenes);
  } else if (const auto own = scenes.find({key_.scene, key_.machine_class}); own != scenes.end()) {
    given_ = decision::PoolEvidence(own->second.arms);
    prior_source_count_ = own->second.sources.size();
  }
  if (!decision::IsAnythingKnown(given_)) prior_source_count_ = 0;
}

std::vector<decision::BetaPosterior> EvidenceLedger::priors() const {
  std::vector<decision::BetaPosterior> priors;
  for (const decision::EvidenceSum& sum : given_) priors.push_back({1 + sum.alpha, 1 + sum.beta});
  return priors;
}

void EvidenceLedger::Add(const decision::Decision& decision) {
  if (decision.increment) Add(*decision.increment, {});
  for (const decision::Increment& increment : decision.lane_increments)
    Add(increment, decision::kLaneName);
}

void EvidenceLedger::Add(const decision::Increment& increment, std::string_view measured_by) {
  PriorRecord& record = OwnRecord(increment.arm, measured_by);
  record.source_sequence = ++sequence_;
  record.alpha_increment += increment.alpha;
  record.beta_increment += increment.beta;
  record.window_count += increment.window_count;
  record.bail_out_count += increment.bail_out_count;
}

PriorRecord& EvidenceLedger::OwnRecord(size_t arm, std::string_view measured_by) {
  const auto found = std::find_if(records_.begin(), records_.end(), [&](const PriorRecord& record) {
    return record.source_id == key_.source_id && record.measured_by == measured_by &&
           record.scene == key_.scene && record.machine_class == key_.machine_class &&
           Applies(record, arm);
  });
  if (found != records_.end()) return *found;
  PriorRecord& record = records_.emplace_back();
  record.project = key_.project;
  record.scene = key_.scene;
  record.measured_by = measured_by;
  record.arm = arms_[arm];
  record.backend_version = arm_versions_[arm];
  record.machine_class = key_.machine_class;
  record.reward_version = key_.reward_version;
  record.source_id = key_.source_id;
  record.build = key_.build;
  return record;
}

}  // namespace sweepstake
