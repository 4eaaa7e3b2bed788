// Tests that a C++ program can link the package's static libraries.
#include "sweepstake/adaptive_broad_phase.h"

int main() { return sweepstake::AdaptiveBroadPhase::Create({}, nullptr).ok() ? 0 : 1; }
