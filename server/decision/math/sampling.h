// Draws from the normal, gamma and Beta distributions, the same bits on every platform
// (portable_math.h, random.h).
//
// Pure functions of the stream's state. Cost: a Beta draw takes some 200 ns.
#pragma once

#include "server/decision/math/random.h"
#include "server/decision/types.h"

namespace sweepstake::decision {

// Standard normal, by Marsaglia's polar method (SIAM Review 6, 1964).
double DrawNormal(RandomStream& stream);

// Natural logarithm of a Gamma(shape, 1) draw (G. Marsaglia, W. W. Tsang, "A simple method for
// generating gamma variables", ACM TOMS 26, 2000). In logarithms, since for small shapes the value
// itself underflows. REQUIRES: shape > 0; a shape below 1e-300 is taken as that.
double DrawLogGamma(double shape, RandomStream& stream);

// Beta(alpha, beta), as X / (X + Y) of two gamma draws; in [0, 1], never NaN. REQUIRES: both finite
// and > 0.
double DrawBeta(const BetaPosterior& posterior, RandomStream& stream);

}  // namespace sweepstake::decision
