#include "server/rpc/services/build_comparison.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "engine_client/decider/pooling/priors_diff.h"
#include "server/rpc/common/proto_conversion.h"

namespace sweepstake::rpc {
namespace {

using decision::PriorsGroups;
using decision::SceneComparison;

bool IsChosen(const v1::BuildChoice& choice, const std::string& build) {
  return !choice.has_build() || (choice.build() == build) != choice.others();
}

// Returns the evidence of the chosen builds as if it were that of one build.
PriorsGroups GroupsOf(const v1::BuildChoice& choice, const std::vector<PriorRecord>& sums) {
  std::vector<PriorRecord> chosen;
  for (const PriorRecord& sum : sums) {
    if (!IsChosen(choice, sum.build)) continue;
    chosen.push_back(sum);
    chosen.back().build.clear();
  }
  return decision::GroupPriors(chosen);
}

// Adds the builds with evidence of the scene, the latest one first.
void AddBuilds(const std::vector<PriorRecord>& sums, v1::SceneComparison& scene) {
  std::map<std::string, uint64_t> last_seen;  // by build
  for (const PriorRecord& sum : sums) {
    if (sum.key.machine_class != scene.machine_class() ||
        sum.key.reward_version != scene.reward_version())
      continue;
    uint64_t& seen = last_seen[sum.build];
    seen = std::max(seen, sum.last_seen_unix_s);
  }
  std::vector<std::pair<std::string, uint64_t>> builds(last_seen.begin(), last_seen.end());
  std::stable_sort(builds.begin(), builds.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  for (auto& [build, seen] : builds) scene.add_builds(std::move(build));
}

}  // namespace

void BuildComparison::Add(PriorRecord record, v1::CompareBuildsResponse& response) {
  if (record.key.scene != scene_.scene || record.key.project != scene_.project) {
    EndScene(response);
    scene_ = record.key;
  }
  sums_.Add(std::move(record));
}

void BuildComparison::EndScene(v1::CompareBuildsResponse& response) {
  const std::vector<PriorRecord> sums = std::exchange(sums_, {}).Take();
  const PriorsGroups before = GroupsOf(request_.before(), sums);
  const PriorsGroups after = GroupsOf(request_.after(), sums);
  for (const SceneComparison& scene : decision::ComparePriors(before, after)) {
    if (request_.changes_only() && !scene.changed()) continue;
    v1::SceneComparison& message = *response.add_scenes();
    ToProto(scene, message);
    AddBuilds(sums, message);
  }
}

}  // namespace sweepstake::rpc
