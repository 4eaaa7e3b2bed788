// How certain the choice of an arm is: the probability that each arm is the best, the expected loss
// of choosing the leader, and a verdict on both. Paper §7.1 uses posteriors in this way.
//
// Pure functions, deterministic and thread-safe, with the same bits on every platform. The leader
// is the arm with the highest probability; the first one if several have it. The verdict here is
// never kDegraded, because that depends on frame times (FrameRateFloor in session/safeguards.h).
#pragma once

#include <cstdint>
#include <span>

#include "engine_client/decider/types.h"

namespace sweepstake::decision {

inline constexpr double kStableProbability = 0.8;
inline constexpr double kTieLossRatio = 0.005;

// Returns
// - kStable if the leader's probability is at least kStableProbability,
// - else kTie if the expected loss is at most kTieLossRatio,
// - else kAmbiguous.
Verdict VerdictOf(double leader_probability, double expected_loss_ratio);

// Diagnoses independent rewards, of which the highest is the best, by integration on the logit
// scale.
// - Expected loss: E[best reward − leader's reward] ÷ E[best reward], the share of the achievable
//   reward that is lost by choosing the leader.
// - Value remaining: the expected loss of choosing the arm with the highest mean, which is the
//   smallest. It is the expected value of perfect information.
// - Verdict: kUnknown if there is no posterior, or if all are Beta(1,1), which means that nothing
//   was learnt. REQUIRES: parameters finite and > 0.
Diagnosis Diagnose(std::span<const BetaPosterior> posteriors);

// Diagnoses independent normal log-costs, of which the lowest is the best. The expected loss is
// exp(E[leader's log-cost − best log-cost]) − 1: the share by which the leader costs more than the
// best arm. The verdict is kUnknown if there is no arm. REQUIRES: as many variances as means, all
// finite, variances >= 0.
Diagnosis DiagnoseLogCosts(std::span<const double> means, std::span<const double> variances);

// Works like DiagnoseLogCosts, with a symmetric covariance matrix (row by row). Only the variances
// of differences between arms matter; independent variances (math/difference_variances.h)
// approximate them. If one disturbance moves all log-costs by the same amount, within 10 %,
// the probabilities are wrong by about 0.01. For random covariances of 7 arms they are wrong by
// 0.04 on average, at times by over 0.1. REQUIRES: `covariance` has means.size()² finite numbers.
Diagnosis DiagnoseCorrelatedLogCosts(std::span<const double> means,
                                     std::span<const double> covariance);

}  // namespace sweepstake::decision
