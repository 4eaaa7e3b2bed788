// exp and ln that give the same bits on every platform: the C library's differ between systems in
// the last place.
//
// Only IEEE-754 operations that are exactly rounded (+, −, ×, ÷) and moves of bits, so the result
// depends on nothing but the argument. Within 2 ulp of the true value. Special values as in C:
// exp(NaN) and ln(NaN) are NaN, ln(0) is −inf, ln of a negative number NaN. Cost: some 20 ns.
// Thread-safe.
#pragma once

namespace sweepstake::decision {

double PortableExp(double x);
double PortableLog(double x);

}  // namespace sweepstake::decision
