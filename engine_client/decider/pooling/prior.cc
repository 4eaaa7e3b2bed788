#include "engine_client/decider/pooling/prior.h"

#include <algorithm>
#include <functional>
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

// The evidence of a scene on one class of machines. Includes only evidence of the arm versions that
// the session uses.
struct Scene {
  std::vector<ArmEvidence> arms;
  std::set<std::string_view> sources;
  uint64_t summed_count = 0;

  uint64_t source_count() const { return std::max<uint64_t>(sources.size(), summed_count); }
};

// The evidence of one source about the session's scene, on one class of machines.
struct Source {
  std::string_view build;
  std::vector<ArmEvidence> arms;
  std::vector<uint32_t> versions;  // one per arm; 0: no evidence
};

// The evidence of a project's records, grouped by scene and by source. The groups are ordered maps,
// so the order of the records does not change the results.
class ProjectEvidence {
 public:
  ProjectEvidence(std::span<const ArmRecord> records, const PriorKey& key) : key_(key) {
    for (const ArmRecord& record : records) {
      if (record.project == key.project && record.reward_version == key.reward_version) Add(record);
    }
  }

  // Returns the sum over the sources of the scene and machine class.
  Prior Sum() const {
    Prior prior{.evidence = std::vector<EvidenceSum>(key_.arms.size()), .groups = {}};
    const auto scene = scenes_.find({key_.scene, key_.machine_class});
    if (scene == scenes_.end()) return prior;
    prior.evidence = PoolEvidence(scene->second.arms);
    prior.source_count = scene->second.source_count();
    return prior;
  }

  // Returns the prior that the scene's sources give. Arms without evidence are filled in from the
  // other scenes.
  Prior Compare() const {
    Prior prior = CompareSources();
    CompareScenes(prior);
    return prior;
  }

 private:
  void Add(const ArmRecord& record) {
    Scene& scene = scenes_[{record.scene, record.machine_class}];
    scene.arms.resize(key_.arms.size());
    scene.sources.insert(record.source);
    scene.summed_count = std::max(scene.summed_count, record.source_count);
    const auto arm = static_cast<size_t>(std::find(key_.arms.begin(), key_.arms.end(), record.arm) -
                                         key_.arms.begin());
    if (arm < key_.arms.size() && record.backend_version == key_.backend_versions[arm])
      scene.arms[arm] += record.evidence;
    if (record.scene == key_.scene) AddToSource(record, arm);
  }

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

  // Fills in arms from other scenes on this machine class or, if there are none, from other scenes
  // on all classes.
  void CompareScenes(Prior& prior) const {
    const auto is_of_class = [&](const auto& named) {
      return named.first.first != key_.scene && named.first.second == key_.machine_class;
    };
    const bool takes_all = std::none_of(scenes_.begin(), scenes_.end(), is_of_class);
    std::vector<std::vector<EvidenceSum>> others;
    uint64_t source_count = 0;
    for (const auto& named : scenes_) {
      if (named.first.first == key_.scene || !(takes_all || is_of_class(named))) continue;
      others.push_back(PoolEvidence(named.second.arms));
      source_count += named.second.source_count();
    }
    const bool is_known = prior.is_known();
    prior.evidence = WithOtherScenes(std::move(prior.evidence), others);
    prior.other_scene_count = others.size();
    if (!is_known) prior.source_count = source_count;
  }

  const PriorKey& key_;
  std::map<Name, Scene> scenes_;    // by scene and machine class
  std::map<Name, Source> sources_;  // by source and machine class
};

}  // namespace

std::vector<BetaPosterior> Prior::posteriors() const {
  constexpr double kHalfOfMax = kMaxPriorEvidence / 2;
  std::vector<BetaPosterior> posteriors;
  if (!is_known()) return posteriors;
  for (const EvidenceSum& sum : evidence) {
    const double largest = std::max(sum.alpha, sum.beta);
    const double scale = largest > kHalfOfMax ? kHalfOfMax / largest : 1;
    posteriors.push_back({1 + sum.alpha * scale, 1 + sum.beta * scale});
  }
  return posteriors;
}

Prior PriorFor(std::span<const ArmRecord> records, const PriorKey& key) {
  const ProjectEvidence evidence(records, key);
  Prior prior = key.compares_sources ? evidence.Compare() : evidence.Sum();
  if (!prior.is_known()) prior.source_count = 0;
  return prior;
}

}  // namespace sweepstake::decision
