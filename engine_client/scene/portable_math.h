// Elementary functions whose results are the same bits on every platform: only + - * / and bit
// moves on IEEE doubles, never the C library, whose last bits differ between systems. Within 2 ulp
// of the exact value unless stated.
//
// Pure functions, safe from any thread. Compile with -ffp-contract=off.
#pragma once

namespace sweepstake::portable {

// Radians. Beyond ±1e6 the error grows with |x| (about |x| * 1e-16); beyond ±1e15 or not finite:
// NaN.
double Sin(double x);
double Cos(double x);

// Overflows to infinity, underflows to 0 (results below the smallest normal double are 0).
double Exp(double x);

// Natural logarithm. Log(0) is -infinity, of a negative number NaN.
double Log(double x);

// base >= 0; Pow(0, y) is 0 for y > 0 and 1 for y = 0. Relative error about |y ln(base)| ulp.
double Pow(double base, double exponent);

// x >= 0.
double CubeRoot(double x);

}  // namespace sweepstake::portable
