// Elementary functions that give the same bits on every platform. The C library's functions differ
// between systems in the last place.
//
// They use only IEEE-754 operations that are exactly rounded (+, −, ×, ÷) and moves of bits, so
// that the result depends on nothing but the argument; compile with -ffp-contract=off. Results are
// within 2 ulp of the true value unless stated. Pure functions, safe from any thread.
#pragma once

namespace sweepstake::math {

// Exp and Log return the special values of C: Exp(NaN) and Log(NaN) are NaN, Log(0) is −inf, and
// Log of a negative number is NaN.
double Exp(double x);
double Log(double x);

// Returns exp(x) − 1 and ln(1 + x), within 6 ulp even if x is near 0.
double Expm1(double x);
double Log1p(double x);

// The argument is in radians. Beyond ±1e6 the error grows with |x| (about |x| · 1e-16). The result
// is NaN beyond ±1e15 and if x is not finite.
double Sin(double x);
double Cos(double x);

// REQUIRES: base >= 0. Pow(0, y) is 0 for y > 0 and 1 for y = 0. The relative error is about
// |y ln(base)| ulp.
double Pow(double base, double exponent);

// REQUIRES: x >= 0.
double CubeRoot(double x);

}  // namespace sweepstake::math
