#include "server/sessions/session_start.h"

#include <openssl/crypto.h>
#include <openssl/hmac.h>
#include <openssl/sha.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <map>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "engine_client/decider/pooling/scene_prior.h"
#include "engine_client/decider/pooling/source_prior.h"
#include "engine_client/decider/session/policy_registry.h"
#include "server/rpc/common/error_reasons.h"
#include "server/rpc/common/proto_conversion.h"
#include "server/sessions/scene_quota.h"

namespace sweepstake::rpc {
namespace {

using decision::BetaPosterior;
using priors::EvidenceKey;

// Of a project's other scenes so many are used, of so many pages of as many.
constexpr uint32_t kMaxOtherScenes = 200;
constexpr int kMaxOtherPages = 5;

std::string NewSessionId(const RpcOptions& options) {
  const uint64_t first = options.random_bits();
  return absl::StrFormat("%016x%016x", first, options.random_bits());
}

// The id of the token is in the clear behind the HMAC; 0 leaves it out.
std::string ResumeTokenOf(const std::string& session_id, int64_t token_id,
                          const RpcOptions& options) {
  const std::string suffix = token_id == 0 ? "" : absl::StrCat("/", token_id);
  const std::string ids = session_id + suffix;
  std::string token(EVP_MAX_MD_SIZE, '\0');
  unsigned int size = 0;
  HMAC(EVP_sha256(), options.resume_secret.data(), static_cast<int>(options.resume_secret.size()),
       reinterpret_cast<const unsigned char*>(ids.data()), ids.size(),
       reinterpret_cast<unsigned char*>(token.data()), &size);
  token.resize(size);
  return token + suffix;
}

std::vector<EvidenceKey> KeysOf(const v1::Hello& hello) {
  std::vector<EvidenceKey> keys;
  for (const v1::Arm& arm : hello.arms()) {
    for (const std::string_view by : {std::string_view(), decision::kLaneName})
      keys.push_back(EvidenceKeyOf(FromProto(hello), arm.name(), arm.backend_version(), by));
  }
  return keys;
}

using Arm = priors::SceneEvidence::Arm;

// Returns what the evidence has of the arm in Hello's version, or else in the latest other one;
// nothing if it has neither.
const Arm* FindArm(const priors::SceneEvidence& evidence, const v1::Arm& wanted) {
  const Arm* found = nullptr;
  for (const Arm& arm : evidence.arms) {  // ordered by version
    if (arm.name != wanted.name()) continue;
    found = &arm;
    if (arm.backend_version == wanted.backend_version()) break;
  }
  return found;
}

// Returns what it says of each of Hello's arms in Hello's version.
std::vector<decision::EvidenceSum> PooledFor(const v1::Hello& hello,
                                             const priors::SceneEvidence& evidence) {
  std::vector<Arm> arms;
  for (const v1::Arm& wanted : hello.arms()) {
    const Arm* const found = FindArm(evidence, wanted);
    const bool same = found != nullptr && found->backend_version == wanted.backend_version();
    arms.push_back(same ? *found : Arm());
  }
  return Pool(arms);
}

std::vector<decision::EvidenceSum> OwnEvidence(const v1::Hello& hello,
                                               const std::optional<priors::SourceState>& source) {
  priors::SceneEvidence own;
  if (source) {
    for (const auto& [key, evidence] : source->evidence)
      own.ArmOf(key.arm, key.backend_version).of(key.measured_by) += evidence;
  }
  return PooledFor(hello, own);
}

decision::SourceRelation RelationOf(const v1::Hello& hello, const priors::SceneSource& source) {
  return {.same_build = source.build == hello.build(),
          .same_machine_class = source.evidence.key.machine_class == hello.machine_class()};
}

decision::SourceEvidence SourceEvidenceFor(const v1::Hello& hello,
                                           const priors::SceneSource& source) {
  const decision::SourceRelation relation = RelationOf(hello, source);
  std::vector<Arm> arms;
  decision::SourceEvidence result;
  for (const v1::Arm& wanted : hello.arms()) {
    const Arm* const found = FindArm(source.evidence, wanted);
    arms.push_back(found != nullptr ? *found : Arm());
    const bool same = arms.back().backend_version == wanted.backend_version();
    result.push_back({.weight = decision::PowerPriorWeight(relation, same)});
  }
  const std::vector<decision::EvidenceSum> pooled = Pool(arms);
  for (size_t arm = 0; arm < result.size(); ++arm) result[arm].sum = pooled[arm];
  return result;
}

// Returns how many sources of each build and class of machines count how much, the heaviest first.
std::vector<std::string> Describe(const v1::Hello& hello,
                                  const std::vector<priors::SceneSource>& sources) {
  constexpr size_t kMaxLines = 8;
  using Group = std::tuple<double, std::string, std::string>;  // weight, build, class
  std::map<Group, size_t, std::greater<>> counts;
  for (const priors::SceneSource& source : sources) {
    const double weight = decision::PowerPriorWeight(RelationOf(hello, source), true);
    ++counts[{weight, source.build, source.evidence.key.machine_class}];
  }
  std::vector<std::string> lines;
  for (const auto& [group, count] : counts) {
    const auto& [weight, build, machine_class] = group;
    if (lines.size() == kMaxLines) {
      lines.push_back(absl::StrCat("and ", counts.size() - kMaxLines, " more groups"));
      break;
    }
    const auto named = [](const std::string& name) { return name.empty() ? "unknown" : name; };
    lines.push_back(absl::StrFormat("%d of build %s on %s at %g", count, named(build),
                                    named(machine_class), weight));
  }
  return lines;
}

// Adds what the sources of the scene say of it.
absl::Status AddSources(priors::PriorReader& store, const v1::Hello& hello, StoredStart& start) {
  const auto stored = store.LoadSources(FromProto(hello));
  if (!stored.ok()) return stored.status();
  std::vector<decision::SourceEvidence> sources;
  for (const priors::SceneSource& source : *stored) {
    if (source.id == hello.session_id() && start.source) continue;  // is the session's own
    sources.push_back(SourceEvidenceFor(hello, source));
  }
  start.prior_source_count = stored->size();
  start.prior_sources = Describe(hello, *stored);
  start.priors = decision::CombineSources(sources, start.priors);
  return absl::OkStatus();
}

// The sums of all sources, for policies whose rewards cannot be compared between sources.
absl::Status AddSums(priors::PriorReader& store, const v1::Hello& hello, StoredStart& start) {
  const auto scene = store.LoadScene(FromProto(hello));
  if (!scene.ok()) return scene.status();
  if (!scene->has_value()) return absl::OkStatus();
  start.prior_source_count = (*scene)->source_count;
  start.prior_sources = {absl::StrCat("the sums of ", start.prior_source_count, " sources")};
  start.priors = PooledFor(hello, **scene);
  return absl::OkStatus();
}

// Fills in what the project's other scenes say of arms of which the scene's evidence says nothing:
// those of this machine class, or of all classes where it has none.
absl::Status AddOtherScenes(priors::PriorReader& store, const v1::Hello& hello,
                            StoredStart& start) {
  const priors::SceneKey scene = FromProto(hello);
  struct Others {
    std::vector<std::vector<decision::EvidenceSum>> scenes;
    uint64_t source_count = 0;
  };
  Others of_class;
  Others of_all;
  std::optional<priors::SceneKey> after;
  for (int page = 0; page < kMaxOtherPages && of_class.scenes.size() < kMaxOtherScenes; ++page) {
    auto listed = store.List({.project = scene.project, .scene = {}}, after, kMaxOtherScenes);
    if (!listed.ok()) return listed.status();
    if (listed->empty()) break;
    after = listed->back().key;
    for (const priors::SceneEvidence& other : *listed) {
      if (other.key.scene == scene.scene || other.key.reward_version != scene.reward_version)
        continue;
      const bool is_of_class = other.key.machine_class == scene.machine_class;
      for (Others* const others : {&of_all, is_of_class ? &of_class : nullptr}) {
        if (others == nullptr) continue;
        others->source_count += other.source_count;
        others->scenes.push_back(PooledFor(hello, other));
      }
    }
  }
  const Others& others = of_class.scenes.empty() ? of_all : of_class;
  start.priors = decision::WithOtherScenes(std::move(start.priors), others.scenes);
  if (!others.scenes.empty())
    start.prior_sources.push_back(
        absl::StrCat("what ", others.scenes.size(), " other scenes have in common"));
  if (start.prior_source_count == 0 && decision::IsAnythingKnown(start.priors))
    start.prior_source_count = others.source_count;
  return absl::OkStatus();
}

// Whether other scenes could tell something that the store's own evidence does not.
bool LacksArms(const v1::Hello& hello, const StoredStart& start) {
  return decision::PolicyKindOf(hello.policy(), decision::ShippedPolicies()).starts_from_priors &&
         std::any_of(start.priors.begin(), start.priors.end(),
                     [](const auto& arm) { return !(arm.evidence() > 0); });
}

bool BelongsTo(const priors::SourceState& source, const std::vector<EvidenceKey>& keys) {
  return std::all_of(source.evidence.begin(), source.evidence.end(), [&](const auto& stored) {
    return std::find(keys.begin(), keys.end(), stored.key) != keys.end();
  });
}

decision::DecisionOptions OptionsOf(const v1::Hello& hello, const RpcOptions& options) {
  decision::DecisionOptions scaled = options.decision;
  scaled.policy = hello.policy();
  return hello.time_scale() > 1 ? scaled.Scaled(hello.time_scale()) : scaled;
}

SessionIdentity IdentityOf(const v1::Hello& hello, const StoredStart& start, int64_t token_id,
                           const RpcOptions& options) {
  SessionIdentity identity;
  identity.token_id = token_id;
  identity.build = hello.build();
  identity.prior_sources = start.prior_sources;
  identity.id = start.source             ? start.source->progress.source_id
                : !start.kept_id.empty() ? start.kept_id
                                         : NewSessionId(options);
  identity.scene = FromProto(hello);
  for (const v1::Arm& arm : hello.arms()) {
    identity.arms.push_back(arm.name());
    identity.backend_versions.push_back(arm.backend_version());
  }
  // The seed determines the order of exploration, so a resumed session keeps its seed.
  identity.seed = hello.seed() != 0 ? hello.seed() : options.random_bits();
  if (start.source) {
    identity.seed = start.source->progress.seed;
    identity.audit_segment = start.source->audit_segment + 1;
  }
  identity.decision = OptionsOf(hello, options);
  return identity;
}

// Returns Beta(1,1) plus the evidence. If imports have made the evidence larger than a session
// accepts, it is scaled down in proportion.
BetaPosterior PriorOf(const decision::EvidenceSum& evidence) {
  constexpr double kMaxEvidence = decision::kMaxPriorEvidence / 2;
  const double largest = std::max(evidence.alpha, evidence.beta);
  const double scale = largest > kMaxEvidence ? kMaxEvidence / largest : 1;
  return {1 + evidence.alpha * scale, 1 + evidence.beta * scale};
}

decision::SessionSetup SetupOf(const v1::Hello& hello, const SessionIdentity& identity,
                               const StoredStart& start, int64_t now_ns) {
  decision::SessionSetup setup;
  setup.options = identity.decision;
  setup.arms = identity.arms;
  // Flat priors are not passed on, because a policy that starts from priors would take them for
  // knowledge.
  if (decision::IsAnythingKnown(start.priors)) {
    std::transform(start.priors.begin(), start.priors.end(), std::back_inserter(setup.priors),
                   PriorOf);
  }
  setup.seed = identity.seed;
  setup.mode = FromProto(hello.mode());
  setup.active_arm = hello.active_arm();
  setup.switch_epoch = hello.switch_epoch();
  setup.start_ns = now_ns;
  if (start.source) {
    const auto arm_count = static_cast<uint32_t>(setup.arms.size());
    setup.explored_arm_count = std::min(start.source->progress.explored_arm_count, arm_count);
    setup.decision_count = start.source->progress.decision_count;
  }
  return setup;
}

}  // namespace

StoredStart LoadStart(priors::PriorReader& store, const v1::Hello& hello, const RpcOptions& options,
                      bool counts) {
  StoredStart start;
  SceneQuota quota(store, options, counts);
  for (const v1::Arm& arm : hello.arms()) {
    start.refusal = quota.Add(FromProto(hello), {arm.name(), arm.backend_version()});
    if (!start.refusal.ok()) return start;
  }
  start.new_scene = quota.unstored();
  if (!hello.session_id().empty()) {
    auto source = store.LoadSource(hello.session_id());
    if (!source.ok()) {
      start.status = source.status();
    } else if (!source->has_value()) {
      if (options.shares_store) start.kept_id = hello.session_id();
    } else if (BelongsTo(**source, KeysOf(hello))) {
      start.source = *std::move(source);
    }
  }
  start.priors = OwnEvidence(hello, start.source);
  if (hello.ignore_priors()) return start;
  const bool compares =
      decision::PolicyKindOf(hello.policy(), decision::ShippedPolicies()).starts_from_priors;
  const absl::Status added =
      compares ? AddSources(store, hello, start) : AddSums(store, hello, start);
  start.status.Update(added);
  if (!added.ok()) return start;
  // Not where commits wait for it.
  if (!counts && LacksArms(hello, start)) {
    if (absl::Status status = AddOtherScenes(store, hello, start); !status.ok())
      start.status = status;
  }
  return start;
}

absl::StatusOr<std::shared_ptr<GameSession>> MakeSession(SessionContext& context,
                                                         const v1::Hello& hello,
                                                         const StoredStart& start,
                                                         int64_t token_id) {
  SessionIdentity identity = IdentityOf(hello, start, token_id, context.options);
  const decision::SessionSetup setup =
      SetupOf(hello, identity, start, context.loop.clock().NowNs());
  if (const auto problem = decision::Validate(setup, decision::ShippedPolicies()))
    return Refused(v1::ERROR_REASON_INVALID_MESSAGE, *problem);
  StoredSession stored;
  if (start.source) {
    stored.progress = start.source->progress;
    stored.has_evidence = !start.source->evidence.empty();
  }
  stored.progress.source_id = identity.id;
  stored.progress.seed = identity.seed;
  if (start.status.ok()) stored.prior_source_count = start.prior_source_count;
  return GameSession::Create(context, std::move(identity), setup, stored);
}

std::optional<int64_t> TokenOfSession(const v1::Hello& hello, const RpcOptions& options) {
  const std::string& given = hello.resume_token();
  int64_t token_id = 0;
  if (given.size() > SHA256_DIGEST_LENGTH &&
      !absl::SimpleAtoi(given.substr(SHA256_DIGEST_LENGTH + 1), &token_id)) {
    return std::nullopt;
  }
  const std::string token = ResumeTokenOf(hello.session_id(), token_id, options);
  if (given.size() != token.size() ||
      CRYPTO_memcmp(given.data(), token.data(), token.size()) != 0) {
    return std::nullopt;
  }
  return token_id;
}

bool CanResume(const GameSession& session, const v1::Hello& hello) {
  const SessionIdentity& identity = session.identity();
  bool same = !session.ended() && identity.scene == FromProto(hello) &&
              identity.arms.size() == static_cast<size_t>(hello.arms_size());
  for (int i = 0; same && i < hello.arms_size(); ++i) {
    same = identity.arms[static_cast<size_t>(i)] == hello.arms(i).name() &&
           identity.backend_versions[static_cast<size_t>(i)] == hello.arms(i).backend_version();
  }
  return same;
}

uint32_t BatchIntervalMs(uint32_t decision_interval_ms, uint64_t stream_count) {
  const uint32_t alone = std::clamp(decision_interval_ms / 8, 1u, 250u);
  const uint64_t shared = std::min<uint64_t>(stream_count / 10, decision_interval_ms / 2);
  return std::max(alone, static_cast<uint32_t>(shared));
}

v1::Welcome WelcomeOf(const GameSession& session, const v1::Hello& hello, bool resumed,
                      uint64_t stream_count, const RpcOptions& options) {
  v1::Welcome welcome;
  welcome.set_protocol_version(std::min(hello.protocol_version(), kMaxProtocolVersion));
  if (Has(hello, v1::CAPABILITY_OPERATOR_ORDERS))
    welcome.add_capabilities(v1::CAPABILITY_OPERATOR_ORDERS);
  if (Has(hello, v1::CAPABILITY_BOX_VIEW)) welcome.add_capabilities(v1::CAPABILITY_BOX_VIEW);
  ToProto(session.identity(), session.decisions().posteriors(), options, welcome);
  welcome.set_batch_interval_ms(BatchIntervalMs(welcome.decision_interval_ms(), stream_count));
  welcome.set_resume_token(
      ResumeTokenOf(session.identity().id, session.identity().token_id, options));
  welcome.set_resumed(resumed);
  welcome.set_acknowledged_sequence(session.durable_sequence());
  welcome.set_prior_source_count(session.prior_source_count().value_or(0));
  welcome.set_priors_unavailable(!session.prior_source_count());
  return welcome;
}

}  // namespace sweepstake::rpc
