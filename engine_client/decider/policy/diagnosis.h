// How certain the choice of an arm is (paper §7.1 uses posteriors as a diagnosis): the probability
// that each arm is the best, the expected loss of choosing the leader, and a verdict on both.
//
// Pure functions: deterministic, thread-safe, and with the same bits on every platform. The leader
// is the arm with the highest probability, the first one of equals. The verdict here is never
// kDegraded, which needs the frame rate (FrameRateFloor in session/safeguards.h).
#pragma once

#include <cstdint>
#include <span>

#include "engine_client/decider/types.h"

namespace sweepstake::decision {

inline constexpr double kStableProbability = 0.8;
inline constexpr double kTieLossRatio = 0.005;

// Returns kStable if the leader's probability is kStableProbability or more, else kTie if the
// expected loss is kTieLossRatio or less, else kAmbiguous.
Verdict VerdictOf(double leader_probability, double expected_loss_ratio);

// Diagnoses independent rewards, of which the highest is the best, by integration on the logit
// scale. The expected loss is E[best reward − leader's reward] ÷ E[best reward], the share of the
// achievable reward that choosing the leader gives up. The value remaining is the same for the arm
// with the highest mean, which gives up the minimum (expected value of perfect information). The
// verdict is kUnknown if every posterior is Beta(1,1), since then nothing is learnt, or if there is
// none. REQUIRES: parameters finite and > 0.
Diagnosis Diagnose(std::span<const BetaPosterior> posteriors);

// Diagnoses independent normal log-costs, of which the lowest is the best. The expected loss is
// exp(E[leader's log-cost − the best's]) − 1, the share by which the leader costs more than the
// best. The verdict is kUnknown if there is no arm. REQUIRES: as many variances as means, all
// finite, variances >= 0.
Diagnosis DiagnoseLogCosts(std::span<const double> means, std::span<const double> variances);

// Diagnoses log-costs with this symmetric covariance matrix, given row by row, as DiagnoseLogCosts
// does for independent ones. Only the variances of differences matter; independent variances
// approximate them (math/difference_variances.h). The probabilities are off by some 0.01 if a
// common part has the same weight on all arms up to a tenth, and by 0.04 on average and at most
// 0.09 for random covariances of 7 arms. REQUIRES: means.size()² finite numbers.
Diagnosis DiagnoseCorrelatedLogCosts(std::span<const double> means,
                                     std::span<const double> covariance);

}  // namespace sweepstake::decision
