#include "server/decision/baselines/ucb1_policy.h"

#include <algorithm>
#include <cmath>  // std::sqrt, exactly rounded by IEEE 754
#include <utility>

#include "server/decision/math/portable_math.h"
#include "server/decision/policy/choice.h"

namespace sweepstake::decision {
namespace {

constexpr double kLeastEvidence = 1e-6;  // a bound stays finite, whatever the priors

}  // namespace

Choice Ucb1Policy::Choose(const ChoiceInput& /*input*/) const {
  double window_count = 0;
  for (const BetaPosterior& posterior : posteriors()) window_count += posterior.evidence();
  const double log_count = math::Log(std::max(window_count, 1.0));
  std::vector<double> bounds;
  for (const BetaPosterior& posterior : posteriors()) {
    bounds.push_back(posterior.mean() +
                     std::sqrt(2 * log_count / std::max(posterior.evidence(), kLeastEvidence)));
  }
  return HighestOf(std::move(bounds));
}

}  // namespace sweepstake::decision
