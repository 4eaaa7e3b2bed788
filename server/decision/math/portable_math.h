// exp and ln that give the same bits on every platform: the C library's differ between systems in
// the last place.
//
// Only IEEE-754 operations that are exactly rounded (+, −, ×, ÷) and moves of bits, so the result
// depends on nothing but the argument. Within 2 ulp of the true value; exp(x) − 1 and ln(1 + x)
// within 6, also around 0. Special values as in C: exp(NaN) and ln(NaN) are NaN, ln(0) is −inf, ln
// of a negative number NaN. Cost: some 20 ns. Thread-safe.
#pragma once

namespace sweepstake::decision {

double PortableExp(double x);
double PortableLog(double x);
double PortableExpm1(double x);  // exp(x) − 1
double PortableLog1p(double x);  // ln(1 + x)

}  // namespace sweepstake::decision
