#include "sweepstake/adaptive_session.h"

namespace sweepstake {

Result<AdaptiveSession> AdaptiveSession::Create(Result<std::unique_ptr<Session>> session,
                                                const AdaptiveOptions& options) {
  if (!session.ok()) return session.status();
  if (*session == nullptr) return Status(StatusCode::kInvalidArgument, "session is null");
  auto broad_phase = AdaptiveBroadPhase::Create(options, &(*session)->sink());
  if (!broad_phase.ok()) return broad_phase.status();
  if (Status status = (*session)->Start(**broad_phase); !status.ok()) return status;
  return AdaptiveSession(std::move(*session), std::move(*broad_phase));
}

}  // namespace sweepstake
