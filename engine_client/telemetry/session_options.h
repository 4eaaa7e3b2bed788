// Checks the options of a session before anything is started.
#pragma once

#include "sweepstake/session.h"

namespace sweepstake {

// kInvalidArgument names the option and its bounds.
Status ValidateSessionOptions(const SessionOptions& options);

}  // namespace sweepstake
