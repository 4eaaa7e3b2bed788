// How sure one is of the choice (paper §7.1: posteriors as a diagnosis): the probability of each
// arm to be the best, what the choice may lose, and the verdict on that.
//
// Pure functions, deterministic, thread-safe; the same bits on every platform. The leader is the
// arm with the highest probability, the first of equal ones. The verdict here is never kDegraded:
// that takes the frame rate (frame_rate_floor.h).
//
// Cost, measured: see each function.
#pragma once

#include <cstdint>
#include <span>

#include "server/decision/types.h"

namespace sweepstake::decision {

inline constexpr double kStableProbability = 0.8;
inline constexpr double kTieLossRatio = 0.005;

// kStable where the leader's probability is kStableProbability or more, else kTie where the
// expected loss is kTieLossRatio or less, else kAmbiguous.
Verdict VerdictOf(double leader_probability, double expected_loss_ratio);

// Of independent rewards; the best is the highest. Integrated on the scale of logits. The expected
// loss is E[best reward − the leader's] ÷ E[best reward]: the share of the reward within reach that
// choosing the leader gives up. Unknown where every posterior is Beta(1,1), for want of anything
// learnt, or there is none. REQUIRES: parameters finite and > 0.
Diagnosis Diagnose(std::span<const BetaPosterior> posteriors);

// Of independent normal log-costs; the best is the lowest. The expected loss is exp(E[leader's
// log-cost − the best's]) − 1: the share by which the leader costs more than the best. Unknown
// where there is none. REQUIRES: as many variances as means, all finite, variances >= 0.
Diagnosis DiagnoseLogCosts(std::span<const double> means, std::span<const double> variances);

// The same for log-costs with this covariance, symmetric, row by row. Only the variances of
// differences matter; they are met by independent variances as well as these can (weighted least
// squares, the weight of a pair being how open it is which of the two is better): exactly where the
// covariance is a diagonal plus what all arms share, or there are two arms that matter.
// REQUIRES: means.size()² numbers, finite.
Diagnosis DiagnoseCorrelatedLogCosts(std::span<const double> means,
                                     std::span<const double> covariance);

}  // namespace sweepstake::decision
