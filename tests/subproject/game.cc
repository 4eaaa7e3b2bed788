#include "sweepstake/adaptive_broad_phase.h"
