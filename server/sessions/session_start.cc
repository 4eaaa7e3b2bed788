#include "server/sessions/session_start.h"

#include <algorithm>
#include <set>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "engine_client/decider/session/policy_registry.h"
#include "engine_client/text/counts.h"
#include "server/sessions/common/reasons.h"
#include "server/sessions/scene_quota.h"

namespace sweepstake::sessions {
namespace {

using decision::ArmRecord;
using priors::EvidenceKey;

// Limits of the other scenes that are read for a prior: up to kMaxOtherPages pages of
// kMaxOtherScenes scenes. Reading stops earlier once kMaxOtherScenes have the session's machine
// class.
constexpr uint32_t kMaxOtherScenes = 200;
constexpr int kMaxOtherPages = 5;

std::string NewSessionId(const HostedSessionOptions& options) {
  const uint64_t first = options.random_bits();
  return absl::StrFormat("%016x%016x", first, options.random_bits());
}

std::vector<EvidenceKey> KeysOf(const SessionRequest& hello) {
  std::vector<EvidenceKey> keys;
  for (size_t i = 0; i < hello.arms.size(); ++i) {
    for (const std::string_view by : {std::string_view(), decision::kLaneName})
      keys.push_back(EvidenceKeyOf(hello.scene, hello.arms[i], hello.backend_versions[i], by));
  }
  return keys;
}

bool StartsFromPriors(const SessionRequest& hello) {
  return decision::PolicyKindOf(hello.policy, decision::ShippedPolicies()).starts_from_priors;
}

decision::PriorKey PriorKeyOf(const SessionRequest& hello, const StoredStart& start) {
  return {.project = hello.scene.project,
          .scene = hello.scene.scene,
          .machine_class = hello.scene.machine_class,
          .reward_version = hello.scene.reward_version,
          .build = hello.origin.build,
          .source = start.source ? start.source->progress.source_id : "",
          .arms = hello.arms,
          .backend_versions = hello.backend_versions,
          .compares_sources = StartsFromPriors(hello)};
}

// The evidence that was read from the store, and records for PriorFor that borrow its strings.
struct StoredEvidence {
  // Adds the session's own evidence. `source` must outlive the records.
  void AddOwn(const priors::SourceState& source, std::string_view build) {
    for (const auto& [key, evidence] : source.evidence) {
      records.push_back(
          RecordOf(key, source.progress.source_id, build, key.arm, key.backend_version));
      records.back().evidence = decision::EvidenceBy(key.measured_by, evidence);
      records.back().regime = key.regime;
    }
  }

  void Add(const priors::SceneEvidence& scene, std::string_view source, std::string_view build,
           uint64_t source_count) {
    for (const priors::SceneEvidence::Arm& arm : scene.arms) {
      for (const auto& [regime, measured] : arm.regimes) {
        ArmRecord& record =
            records.emplace_back(RecordOf(scene.key, source, build, arm.name, arm.backend_version));
        record.evidence = EvidenceOf(measured);
        record.source_count = source_count;
        record.regime = regime;
      }
    }
  }

  // Reads the scene from `key`, a SceneKey or an EvidenceKey.
  template <typename Key>
  static ArmRecord RecordOf(const Key& key, std::string_view source, std::string_view build,
                            std::string_view arm, uint32_t backend_version) {
    return {.project = key.project,
            .scene = key.scene,
            .machine_class = key.machine_class,
            .reward_version = key.reward_version,
            .source = source,
            .build = build,
            .arm = arm,
            .backend_version = backend_version};
  }

  std::vector<ArmRecord> records;
  std::vector<priors::SceneSource> sources;
  std::vector<std::vector<priors::SceneEvidence>> other_scenes;  // pages
};

// Adds the evidence of the scene's sources, except the session's own, which has already been added.
absl::Status AddSources(priors::PriorReader& store, const SessionRequest& hello,
                        const StoredStart& start, StoredEvidence& stored) {
  auto sources = store.LoadSources(hello.scene);
  if (!sources.ok()) return sources.status();
  stored.sources = *std::move(sources);
  for (const priors::SceneSource& source : stored.sources) {
    if (!start.source || source.id != hello.session_id)
      stored.Add(source.evidence, source.id, source.build, /*source_count=*/1);
  }
  return absl::OkStatus();
}

absl::Status AddOtherScenes(priors::PriorReader& store, const SessionRequest& hello,
                            StoredEvidence& stored) {
  const priors::SceneKey& scene = hello.scene;
  uint32_t of_class_count = 0;
  std::optional<priors::SceneKey> after;
  for (int page = 0; page < kMaxOtherPages && of_class_count < kMaxOtherScenes; ++page) {
    auto listed = store.List({.project = scene.project, .scene = {}}, after, kMaxOtherScenes);
    if (!listed.ok()) return listed.status();
    if (listed->empty()) break;
    after = listed->back().key;
    stored.other_scenes.push_back(*std::move(listed));
    for (const priors::SceneEvidence& other : stored.other_scenes.back()) {
      if (other.key.scene == scene.scene || other.key.reward_version != scene.reward_version)
        continue;
      if (other.key.machine_class == scene.machine_class) ++of_class_count;
      stored.Add(other, /*source=*/{}, /*build=*/{}, other.source_count);
    }
  }
  return absl::OkStatus();
}

// Returns lines for the audit log that state the weights of the sources, the heaviest first.
std::vector<std::string> Describe(const decision::Prior& prior, bool compares_sources) {
  constexpr size_t kMaxLines = 8;
  std::vector<std::string> lines;
  if (!compares_sources && prior.source_count > 0)
    lines.push_back(
        absl::StrCat("the summed evidence of ", text::Counted(prior.source_count, "source")));
  for (const decision::SourceGroup& group : prior.groups) {
    if (lines.size() == kMaxLines) {
      lines.push_back(
          absl::StrCat("and ", text::Counted(prior.groups.size() - kMaxLines, "more group")));
      break;
    }
    const auto named = [](const std::string& name) { return name.empty() ? "unknown" : name; };
    lines.push_back(absl::StrFormat("%s of build %s on %s with weight %g",
                                    text::Counted(group.source_count, "source"), named(group.build),
                                    named(group.machine_class), group.weight));
  }
  if (prior.other_scene_count > 0)
    lines.push_back(absl::StrCat("the evidence in common of ",
                                 text::Counted(prior.other_scene_count, "other scene")));
  return lines;
}

// Sets the prior, which includes the session's own evidence. Other scenes are read only if some arm
// lacks evidence, and not on the writing thread, where reading them would delay commits.
absl::Status LoadPrior(priors::PriorReader& store, const SessionRequest& hello,
                       bool is_writing_thread, StoredStart& start) {
  const decision::PriorKey key = PriorKeyOf(hello, start);
  StoredEvidence stored;
  if (start.source) stored.AddOwn(*start.source, hello.origin.build);
  absl::Status status;
  if (!hello.ignores_priors) status = AddSources(store, hello, start, stored);
  start.prior = decision::PriorFor(stored.records, key);
  const bool reads_others = status.ok() && !hello.ignores_priors && !is_writing_thread;
  if (reads_others && key.compares_sources && start.prior.lacks_arms()) {
    status = AddOtherScenes(store, hello, stored);
    if (status.ok()) start.prior = decision::PriorFor(stored.records, key);
  }
  start.prior_sources = Describe(start.prior, key.compares_sources);
  return status;
}

bool BelongsTo(const priors::SourceState& source, const std::vector<EvidenceKey>& keys) {
  return std::all_of(source.evidence.begin(), source.evidence.end(), [&](const auto& stored) {
    EvidenceKey key = stored.key;
    key.regime.clear();
    return std::find(keys.begin(), keys.end(), key) != keys.end();
  });
}

// Adds the regimes in which the scene has evidence, without priors, if they are missing. The
// session files its evidence into them, so that a scene has few regimes also if priors are ignored.
void AddStoredRegimes(const std::set<std::string>& names, size_t arm_count,
                      decision::RegimePriors& regimes) {
  for (const std::string& name : names) {
    if (regimes.stored_count == decision::kMaxStoredRegimes) return;
    const auto end = regimes.buckets.end();
    if (std::find(regimes.buckets.begin(), end, name) != end) continue;
    regimes.buckets.insert(regimes.buckets.begin() + regimes.stored_count, name);
    regimes.posteriors.insert(
        regimes.posteriors.begin() + static_cast<ptrdiff_t>(regimes.stored_count * arm_count),
        arm_count, decision::BetaPosterior());
    ++regimes.stored_count;
    if (regimes.buckets.size() <= decision::kMaxRegimePriors) continue;
    regimes.buckets.pop_back();
    regimes.posteriors.resize(regimes.buckets.size() * arm_count);
  }
}

bool Keeps(const SessionRequest& hello, const StoredStart& start, size_t arm) {
  return !hello.is_of_player || (arm < start.kept_arms.size() && start.kept_arms[arm]);
}

bool KeepsAny(const SessionRequest& hello, const StoredStart& start) {
  for (size_t i = 0; i < hello.arms.size(); ++i) {
    if (Keeps(hello, start, i)) return true;
  }
  return false;
}

// Checks the scene and its arms against the quotas. Sets start.refusal and start.new_scene. Returns
// the buckets of the scene's stored regimes.
std::set<std::string> CheckQuota(priors::PriorReader& store, const SessionRequest& hello,
                                 const HostedSessionOptions& options, bool counts,
                                 StoredStart& start) {
  SceneQuota quota(store, options, counts);
  for (size_t i = 0; i < hello.arms.size(); ++i) {
    if (!Keeps(hello, start, i)) continue;
    start.refusal = quota.Add(hello.scene, hello.arms[i], hello.backend_versions[i]);
    if (start.refusal.ok()) continue;
    // The session of a player can begin, but stores nothing.
    if (hello.is_of_player) start.refusal = absl::OkStatus();
    start.kept_arms.clear();
    return {};
  }
  if (!KeepsAny(hello, start)) return {};
  start.new_scene = quota.unstored();
  return quota.regimes(hello.scene);
}

// Sets start.kept_arms for a session of a player.
absl::Status LimitToKnownArms(priors::PriorReader& store, const SessionRequest& hello,
                              StoredStart& start) {
  const priors::SceneKey& scene = hello.scene;
  const auto known = store.LoadKnownArms(scene.project, scene.scene);
  if (!known.ok()) return known.status();
  for (size_t i = 0; i < hello.arms.size(); ++i)
    start.kept_arms.push_back(known->contains({hello.arms[i], hello.backend_versions[i]}));
  return absl::OkStatus();
}

decision::DecisionOptions OptionsOf(const SessionRequest& hello,
                                    const HostedSessionOptions& options) {
  decision::DecisionOptions chosen = options.decision.With(hello.rules);
  chosen.policy = hello.policy;
  return chosen.Scaled(hello.time_scale);
}

SessionIdentity IdentityOf(const SessionRequest& hello, const StoredStart& start,
                           const HostedSessionOptions& options) {
  SessionIdentity identity;
  identity.origin = hello.origin;
  identity.prior_sources = start.prior_sources;
  identity.id = start.source             ? start.source->progress.source_id
                : !start.kept_id.empty() ? start.kept_id
                                         : NewSessionId(options);
  identity.scene = hello.scene;
  identity.arms = hello.arms;
  identity.backend_versions = hello.backend_versions;
  identity.is_of_player = hello.is_of_player;
  for (size_t i = 0; i < hello.arms.size(); ++i)
    identity.kept_arms.push_back(Keeps(hello, start, i));
  // The seed determines the order of exploration, so a resumed session keeps its seed.
  identity.seed = hello.seed != 0 ? hello.seed : options.random_bits();
  if (start.source) {
    identity.seed = start.source->progress.seed;
    identity.audit_segment = start.source->audit_segment + 1;
  }
  identity.policy = decision::PolicyKindOf(hello.policy, decision::ShippedPolicies()).name;
  return identity;
}

decision::SessionSetup SetupOf(const SessionRequest& hello, const SessionIdentity& identity,
                               const StoredStart& start, const HostedSessionOptions& options,
                               int64_t now_ns) {
  decision::SessionSetup setup;
  setup.options = OptionsOf(hello, options);
  setup.arms = identity.arms;
  setup.priors = start.prior.posteriors();
  setup.regime_priors = start.prior.regimes;
  setup.seed = identity.seed;
  setup.mode = hello.mode;
  setup.active_arm = hello.active_arm;
  setup.initial_arm = hello.initial_arm;
  setup.switch_epoch = hello.switch_epoch;
  setup.start_ns = now_ns;
  setup.stops_trials = hello.stops_trials;
  if (start.source) {
    const auto arm_count = static_cast<uint32_t>(setup.arms.size());
    setup.explored_arm_count = std::min(start.source->progress.explored_arm_count, arm_count);
    setup.decision_count = start.source->progress.decision_count;
  }
  return setup;
}

}  // namespace

StoredStart LoadStart(priors::PriorReader& store, const SessionRequest& hello,
                      const HostedSessionOptions& options, bool is_writing_thread) {
  StoredStart start;
  if (hello.is_of_player) {
    start.status = LimitToKnownArms(store, hello, start);
    if (!start.status.ok()) start.kept_arms.clear();
  }
  const std::set<std::string> regimes = CheckQuota(store, hello, options, /*counts=*/false, start);
  if (!start.refusal.ok()) return start;
  if (!hello.session_id.empty()) {
    auto source = store.LoadSource(hello.session_id);
    if (!source.ok()) {
      start.status.Update(source.status());
    } else if (!source->has_value()) {
      if (options.shares_store) start.kept_id = hello.session_id;
    } else if (BelongsTo(**source, KeysOf(hello))) {
      start.source = *std::move(source);
    }
  }
  start.status.Update(LoadPrior(store, hello, is_writing_thread, start));
  AddStoredRegimes(regimes, hello.arms.size(), start.prior.regimes);
  return start;
}

void CountScene(priors::PriorReader& store, const SessionRequest& hello,
                const HostedSessionOptions& options, StoredStart& start) {
  if (start.new_scene) CheckQuota(store, hello, options, /*counts=*/true, start);
}

absl::StatusOr<std::shared_ptr<GameSession>> MakeSession(const SessionContext& context,
                                                         const SessionRequest& hello,
                                                         const StoredStart& start) {
  SessionIdentity identity = IdentityOf(hello, start, context.options);
  const decision::SessionSetup setup =
      SetupOf(hello, identity, start, context.options, context.loop.clock().NowNs());
  if (const auto problem = decision::Validate(setup, decision::ShippedPolicies()))
    return Refused(reasons::kInvalidMessage, *problem);
  StoredSession stored;
  if (start.source) {
    stored.progress = start.source->progress;
    stored.has_evidence = !start.source->evidence.empty();
  }
  stored.progress.source_id = identity.id;
  stored.progress.seed = identity.seed;
  if (start.status.ok()) stored.prior_source_count = start.prior.source_count;
  return GameSession::Create(context, std::move(identity), setup, stored);
}

}  // namespace sweepstake::sessions
