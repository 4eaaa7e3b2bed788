// The rule that a game developer would write by hand (`thresholds`), from the scene's object count
// and density, with arms by their names:
//
//   fewer than 128 objects              BruteForce
//   up to 2,500, density up to 0.5      AxisSweep, else SAP
//   otherwise                           KDTree, else DBVT
//
// Why: testing all pairs of a hundred boxes costs less than keeping any structure. Sweeping one
// axis makes some 2 n^(2/3) ρ^(1/3) checks per object (n objects in a cube, ρ the density), so that
// it pays until n or ρ grows; the paper found it ahead up to 2,000 objects and the tree ahead at
// 3,000 and where objects crowd (Table 3, §7), as the KD-tree's authors had (Y. Serpa,
// M. Rodrigues, CGF 38, 2019). A density of ½ is a scene whose objects touch wherever they are. The
// numbers were written down before any recorded scene was looked at, and are not tuned to any.
//
// Where an arm of a row is not there, its second is taken, and where none is, the active arm stays;
// also before the first descriptor. An arm that bailed out is taken no more. Rewards are recorded
// as the paper's policy does, and not used.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "server/decision/policy/reward_policy.h"

namespace sweepstake::decision {

class ThresholdsPolicy : public RewardPolicy {
 public:
  static constexpr double kFewObjects = 128;
  static constexpr double kManyObjects = 2'500;
  static constexpr double kDense = 0.5;

  explicit ThresholdsPolicy(const PolicySetup& setup)
      : RewardPolicy(setup), arms_(setup.arms), bailed_out_(setup.arms.size()) {}

  Increment LearnBailOut(uint32_t arm) override;
  void LearnDescriptor(const SceneDescriptor& descriptor, int64_t now_ns) override;
  Choice Choose(const ChoiceInput& input) const override;

 private:
  std::optional<uint32_t> Find(std::string_view name) const;

  std::vector<std::string> arms_;
  std::vector<bool> bailed_out_;
  std::optional<double> object_count_;
  double density_ratio_ = 0;  // until one is measured, a sparse scene
};

}  // namespace sweepstake::decision
