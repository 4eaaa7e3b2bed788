#include "engine_client/decider/pooling/prior.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "engine_client/decider/pooling/source_prior.h"
#include "engine_client/decider/session/session_setup.h"

namespace sweepstake::decision {
namespace {

using Name = std::pair<std::string_view, std::string_view>;

// A regime of a scene. Stands for the whole scene if the prior is about all regimes together.
struct Place {
  std::string_view scene;
  std::string_view regime;

  bool operator==(const Place&) const = default;
  friend bool operator<(const Place& a, const Place& b) {
    return std::tie(a.scene, a.regime) < std::tie(b.scene, b.regime);
  }
};

// The evidence of a place on one class of machines. Includes only evidence of the arm versions that
// the session uses.
struct Scene {
  std::vector<ArmEvidence> arms;
  std::set<std::string_view> sources;
  uint64_t summed_count = 0;

  uint64_t source_count() const { return std::max<uint64_t>(sources.size(), summed_count); }
};

// The evidence of one source about the session's place, on one class of machines.
struct Source {
  std::string_view build;
  std::vector<ArmEvidence> arms;
  std::vector<uint32_t> versions;  // one per arm; 0: no evidence
};

// The evidence of a project's records, grouped by place and by source. The groups are ordered maps,
// so the order of the records does not change the results.
class ProjectEvidence {
 public:
  // With a regime, each regime of a scene is a place of its own. Otherwise each scene is one place.
  ProjectEvidence(const PriorKey& key, std::optional<std::string_view> regime)
      : key_(key), has_regime_(regime), own_{key.scene, regime.value_or(std::string_view())} {}

  void Add(const ArmRecord& record) {
    const Place place{record.scene, has_regime_ ? record.regime : std::string_view()};
    Scene& scene = scenes_[{place, record.machine_class}];
    scene.arms.resize(key_.arms.size());
    scene.sources.insert(record.source);
    scene.summed_count = std::max(scene.summed_count, record.source_count);
    const auto arm = static_cast<size_t>(std::find(key_.arms.begin(), key_.arms.end(), record.arm) -
                                         key_.arms.begin());
    if (arm < key_.arms.size() && record.backend_version == key_.backend_versions[arm])
      scene.arms[arm] += record.evidence;
    if (place == own_) AddToSource(record, arm);
  }

  // Returns the sum over the sources of the scene and machine class.
  Prior Sum() const {
    Prior prior{.evidence = std::vector<EvidenceSum>(key_.arms.size()), .groups = {}};
    const auto scene = scenes_.find({own_, key_.machine_class});
    if (scene == scenes_.end()) return prior;
    prior.evidence = PoolEvidence(scene->second.arms);
    prior.source_count = scene->second.source_count();
    return prior;
  }

  // Returns the prior that the place's sources give. Arms without evidence are filled in from the
  // other places.
  Prior Compare() const {
    Prior prior = CompareSources();
    CompareScenes(prior);
    return prior;
  }

 private:
  void AddToSource(const ArmRecord& record, size_t arm) {
    Source& source = sources_[{record.source, record.machine_class}];
    source.build = record.build;
    source.arms.resize(key_.arms.size());
    source.versions.resize(key_.arms.size());
    if (arm == key_.arms.size()) return;
    uint32_t& version = source.versions[arm];
    const uint32_t best = BestVersion(record.backend_version, version, key_.backend_versions[arm]);
    if (best != std::exchange(version, best)) source.arms[arm] = {};
    if (record.backend_version == version) source.arms[arm] += record.evidence;
  }

  // Returns the prior from the scene's sources. The session's own evidence is added in full and is
  // not one of the compared sources. It counts only in the session's arm versions, scene and
  // machine class.
  Prior CompareSources() const {
    std::vector<EvidenceSum> own(key_.arms.size());
    std::vector<SourceEvidence> others;
    std::map<std::tuple<double, std::string_view, std::string_view>, uint64_t, std::greater<>>
        groups;
    for (const auto& [name, source] : sources_) {
      SourceRelation relation{.same_build = source.build == key_.build,
                              .same_machine_class = name.second == key_.machine_class};
      ++groups[{PowerPriorWeight(relation), source.build, name.second}];
      if (!key_.source.empty() && name.first == key_.source) {
        if (relation.same_machine_class) own = PoolOwn(source);
        continue;
      }
      const std::vector<EvidenceSum> pooled = PoolEvidence(source.arms);
      SourceEvidence& other = others.emplace_back();
      for (size_t arm = 0; arm < pooled.size(); ++arm) {
        relation.same_backend_version = source.versions[arm] == key_.backend_versions[arm];
        other.push_back({pooled[arm], PowerPriorWeight(relation)});
      }
    }
    Prior prior{
        .evidence = CombineSources(others, own), .source_count = sources_.size(), .groups = {}};
    for (const auto& [group, count] : groups) {
      const auto& [weight, build, machine_class] = group;
      prior.groups.push_back({weight, std::string(build), std::string(machine_class), count});
    }
    return prior;
  }

  std::vector<EvidenceSum> PoolOwn(const Source& source) const {
    std::vector<ArmEvidence> arms = source.arms;
    for (size_t arm = 0; arm < arms.size(); ++arm) {
      if (source.versions[arm] != key_.backend_versions[arm]) arms[arm] = {};
    }
    return PoolEvidence(arms);
  }

  // Fills in arms from other places on this machine class or, if there are none, from other places
  // on all classes.
  void CompareScenes(Prior& prior) const {
    const auto is_of_class = [&](const auto& named) {
      return named.first.first != own_ && named.first.second == key_.machine_class;
    };
    const bool takes_all = std::none_of(scenes_.begin(), scenes_.end(), is_of_class);
    std::vector<std::vector<EvidenceSum>> others;
    uint64_t source_count = 0;
    for (const auto& named : scenes_) {
      if (named.first.first == own_ || !(takes_all || is_of_class(named))) continue;
      others.push_back(PoolEvidence(named.second.arms));
      source_count += named.second.source_count();
    }
    const bool is_known = prior.is_known();
    prior.evidence = WithOtherScenes(std::move(prior.evidence), others);
    prior.other_scene_count = others.size();
    if (!is_known) prior.source_count = source_count;
  }

  const PriorKey& key_;
  const bool has_regime_;
  const Place own_;                                             // the session's
  std::map<std::pair<Place, std::string_view>, Scene> scenes_;  // by place and machine class
  std::map<Name, Source> sources_;                              // by source and machine class
};

bool IsOfProject(const ArmRecord& record, const PriorKey& key) {
  return record.project == key.project && record.reward_version == key.reward_version;
}

std::vector<BetaPosterior> PosteriorsOf(std::span<const EvidenceSum> evidence) {
  constexpr double kHalfOfMax = kMaxPriorEvidence / 2;
  std::vector<BetaPosterior> posteriors;
  if (!IsAnythingKnown(evidence)) return posteriors;
  for (const EvidenceSum& sum : evidence) {
    const double largest = std::max(sum.alpha, sum.beta);
    const double scale = largest > kHalfOfMax ? kHalfOfMax / largest : 1;
    posteriors.push_back({1 + sum.alpha * scale, 1 + sum.beta * scale});
  }
  return posteriors;
}

Prior Compare(std::span<const ArmRecord> records, const PriorKey& key) {
  ProjectEvidence evidence(key, /*regime=*/std::nullopt);
  for (const ArmRecord& record : records) {
    if (IsOfProject(record, key)) evidence.Add(record);
  }
  return evidence.Compare();
}

// Returns the buckets of the records, those of the scene itself first. Of both kinds, buckets with
// more evidence come first.
std::vector<std::pair<bool, std::string_view>> BucketsOf(std::span<const ArmRecord> records,
                                                         const PriorKey& key) {
  std::map<std::string_view, std::pair<bool, uint64_t>> sizes;
  for (const ArmRecord& record : records) {
    if (record.regime.empty() || !IsOfProject(record, key)) continue;
    auto& [is_own, count] = sizes[record.regime];
    if (record.scene == key.scene && !std::exchange(is_own, true)) count = 0;
    if (is_own == (record.scene == key.scene))
      count += record.evidence.window_count + record.evidence.visit_count;
  }
  std::vector<std::tuple<bool, uint64_t, std::string_view>> order;
  for (const auto& [bucket, size] : sizes) order.emplace_back(size.first, size.second, bucket);
  std::sort(order.begin(), order.end(), std::greater<>());
  std::vector<std::pair<bool, std::string_view>> buckets;
  for (const auto& [is_own, count, bucket] : order) buckets.emplace_back(is_own, bucket);
  return buckets;
}

// Returns the prior of a session in one regime. Other places are added only if some arm has no
// evidence in the regime, because most of the records may be of other regimes.
std::vector<EvidenceSum> EvidenceIn(std::string_view regime, std::span<const ArmRecord> records,
                                    const PriorKey& key) {
  ProjectEvidence evidence(key, regime);
  std::vector<EvidenceSum> arms(key.arms.size());
  for (const bool adds_own : {true, false}) {
    if (std::all_of(arms.begin(), arms.end(), [](auto& arm) { return arm.evidence() > 0; })) break;
    for (const ArmRecord& record : records) {
      const bool is_of_scene = record.scene == key.scene, is_of_regime = record.regime == regime;
      const bool is_own = is_of_scene && is_of_regime;
      if (is_own == adds_own && (is_of_scene || is_of_regime) && IsOfProject(record, key))
        evidence.Add(record);
    }
    arms = evidence.Compare().evidence;
  }
  return arms;
}

RegimePriors RegimesOf(std::span<const ArmRecord> records, const PriorKey& key) {
  RegimePriors priors;
  for (const auto& [is_own, bucket] : BucketsOf(records, key)) {
    if (priors.buckets.size() == (is_own ? kMaxStoredRegimes : kMaxRegimePriors)) continue;
    std::vector<BetaPosterior> posteriors = PosteriorsOf(EvidenceIn(bucket, records, key));
    if (posteriors.empty()) posteriors.resize(key.arms.size());
    priors.buckets.emplace_back(bucket);
    priors.posteriors.insert(priors.posteriors.end(), posteriors.begin(), posteriors.end());
    if (is_own) ++priors.stored_count;
  }
  return priors;
}

}  // namespace

std::vector<BetaPosterior> Prior::posteriors() const { return PosteriorsOf(evidence); }

bool Prior::lacks_arms() const {
  return std::any_of(evidence.begin(), evidence.end(),
                     [](const EvidenceSum& arm) { return !(arm.evidence() > 0); });
}

Prior PriorFor(std::span<const ArmRecord> records, const PriorKey& key) {
  Prior prior;
  if (key.compares_sources) {
    std::vector<ArmRecord> own;
    std::copy_if(records.begin(), records.end(), std::back_inserter(own),
                 [&](const ArmRecord& record) { return record.scene == key.scene; });
    prior = Compare(own, key);
    const bool uses_others = prior.lacks_arms() && own.size() < records.size();
    if (uses_others) prior = Compare(records, key);
    prior.regimes = RegimesOf(uses_others ? records : own, key);
  } else {
    ProjectEvidence evidence(key, /*regime=*/std::nullopt);
    for (const ArmRecord& record : records) {
      if (IsOfProject(record, key)) evidence.Add(record);
    }
    prior = evidence.Sum();
  }
  if (!prior.is_known()) prior.source_count = 0;
  return prior;
}

}  // namespace sweepstake::decision
