#include "engine_client/telemetry/evidence_intake.h"

#include <utility>

#include "engine_client/telemetry/wire.h"

namespace sweepstake {

bool EvidenceIntake::Pump(uint64_t now_ns) {
  TakeShadows();
  while (!state_.full()) {
    const std::optional<QueuedItem> item = queue_.Pop();
    if (!item) {
      if (batcher_.Due(now_ns)) Flush();
      return true;
    }
    Take(*item, now_ns);
  }
  return false;
}

void EvidenceIntake::TakeShadows() {
  while (batcher_.TakesShadow()) {
    const std::optional<ShadowSample> sample = queue_.PopShadow();
    if (!sample) return;
    batcher_.AddShadow(*sample);
  }
}

void EvidenceIntake::Take(const QueuedItem& item, uint64_t now_ns) {
  if (const auto* sample = std::get_if<FrameSample>(&item)) return TakeFrame(*sample, now_ns);
  if (const auto* descriptor = std::get_if<SceneDescriptor>(&item)) {
    return batcher_.SetDescriptor(*descriptor);
  }
  Flush();
  if (const auto* outcome = std::get_if<SwitchOutcome>(&item)) state_.Append(ToRequest(*outcome));
  if (const auto* change = std::get_if<ModeNote>(&item)) state_.Append(ToRequest(*change));
}

void EvidenceIntake::TakeFrame(const FrameSample& sample, uint64_t now_ns) {
  if (!batcher_.Fits(sample)) Flush();
  batcher_.Add(sample, now_ns);
  if ((sample.flags & kFrameBailOut) != 0) {
    Flush();
    state_.Append(BailOutRequest(sample));
  } else if (batcher_.Due(now_ns)) {
    Flush();
  }
}

void EvidenceIntake::Flush() {
  if (batcher_.empty()) return;
  v1::StreamTelemetryRequest request;
  *request.mutable_frame_batch() = batcher_.Take();
  state_.Append(std::move(request));
}

}  // namespace sweepstake
