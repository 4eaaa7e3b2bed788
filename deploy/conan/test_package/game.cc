// Links the C++ libraries.
#include "sweepstake/adaptive_broad_phase.h"

int main() { return sweepstake::AdaptiveBroadPhase::Create({}, nullptr).ok() ? 0 : 1; }
