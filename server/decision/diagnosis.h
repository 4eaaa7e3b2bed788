// How sure one is of the choice (paper §7.1: posteriors as a diagnosis): the probability of each
// arm to be the best, what the choice may lose, and the verdict on that.
//
// Pure functions, deterministic, thread-safe; the same bits on every platform. The leader is the
// arm with the highest probability, the first of equal ones. The verdict here is never kDegraded:
// that takes the frame rate (frame_rate_floor.h).
//
// Cost, measured: 11 µs for 7 arms and 30–60 µs for 32; 250 µs for 32 of the most extreme widths.
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
// choosing the leader gives up; the value remaining is the same for the arm with the highest mean,
// the least that any choice gives up (expected value of perfect information). Unknown where every
// posterior is Beta(1,1), for want of anything learnt, or there is none. REQUIRES: parameters
// finite and > 0.
Diagnosis Diagnose(std::span<const BetaPosterior> posteriors);

// Of independent normal log-costs; the best is the lowest. The expected loss is exp(E[leader's
// log-cost − the best's]) − 1: the share by which the leader costs more than the best. Unknown
// where there is none. REQUIRES: as many variances as means, all finite, variances >= 0.
Diagnosis DiagnoseLogCosts(std::span<const double> means, std::span<const double> variances);

// The same for log-costs with this covariance, symmetric, row by row. Only the variances of
// differences matter; they are met by independent variances as well as these can
// (difference_variances.h). Where that is not exact, the probabilities are off by some 0.01 for a
// common part that weighs on the arms alike but for a tenth, and by 0.04 on average and 0.09 at
// worst for random covariances of 7 arms. REQUIRES: means.size()² numbers, finite.
Diagnosis DiagnoseCorrelatedLogCosts(std::span<const double> means,
                                     std::span<const double> covariance);

}  // namespace sweepstake::decision
