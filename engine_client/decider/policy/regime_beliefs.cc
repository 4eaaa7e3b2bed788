#include "engine_client/decider/policy/regime_beliefs.h"

#include <utility>

namespace sweepstake::decision {

bool RegimeBeliefs::Observe(const SceneDescriptor& descriptor) {
  const auto [regime, is_new] = memory_.Observe(descriptor);
  is_new_ = is_new;
  if (is_new && regime != regime_) {
    RelativeCostFilter beliefs = filter();
    beliefs.Widen(kTransferVariance);
    if (regime == filters_.size()) filters_.push_back(beliefs);
    filters_[regime] = std::move(beliefs);
  }
  const bool has_changed = regime != std::exchange(regime_, regime);
  if (has_changed) ++change_count_;
  return has_changed;
}

}  // namespace sweepstake::decision
