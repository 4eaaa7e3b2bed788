// Makes an embedded session whose decider a StudyMaker makes, for the laboratory's experiments.
// This header is not installed, so games can choose only shipped policies.
#pragma once

#include "engine_client/decider/embedded/study_maker.h"
#include "sweepstake/session.h"

namespace sweepstake {

// Works like MakeEmbeddedSession with the policies of `maker`. Its registry must outlive the
// sessions.
Result<std::unique_ptr<Session>> MakeStudySession(const StudyMaker& maker,
                                                  const EmbeddedOptions& embedded,
                                                  const SessionOptions& options);

}  // namespace sweepstake
