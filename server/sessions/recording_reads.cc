#include "server/sessions/recording_reads.h"

#include "server/rpc/common/error_reasons.h"
#include "server/rpc/common/options.h"
#include "server/sessions/game_session.h"

namespace sweepstake::rpc {

void RecordingReads::Connect(SessionLink& link, bool gives) {
  link_ = &link;
  gives_ = gives;
}

void RecordingReads::Disconnect() {
  link_ = nullptr;
  RefuseAll(Refused(v1::ERROR_REASON_GAME_AWAY, "the game was lost before it answered; try again"));
}

void RecordingReads::Read(uint64_t recording_id, uint64_t offset, Answer answer) {
  if (link_ == nullptr) {
    return answer(Refused(v1::ERROR_REASON_GAME_AWAY,
                          "the game is not connected; try again when it has come back"));
  }
  if (!gives_) {
    return answer(Refused(v1::ERROR_REASON_RECORDINGS_NOT_SHOWN,
                          "this game gives no flight recordings; build it with a flight recorder "
                          "and allow_recording_download"));
  }
  if (waiting_.size() >= kMaxWaiting) {
    return answer(Refused(v1::ERROR_REASON_TOO_MANY_READS,
                          "as many as may read this session's recordings do so already; try again "
                          "when one of them is done"));
  }
  waiting_.push_back({recording_id, offset, std::move(answer)});
  if (waiting_.size() == 1) Ask();
}

void RecordingReads::Ask() {
  ++*request_id_;
  // The game's time begins before it hears of the request.
  loop_.PostAt(loop_.clock().NowNs() + kPatienceNs,
               [this, weak = std::weak_ptr(request_id_), id = *request_id_] {
                 const auto present = weak.lock();  // as long as this lives
                 if (!present || *present != id) return;
                 RefuseAll(Refused(v1::ERROR_REASON_GAME_AWAY,
                                   "the game has not answered for five seconds; try again"));
               });
  link_->SendRecordingRequest(*request_id_, waiting_.front().recording_id, waiting_.front().offset);
}

void RecordingReads::OnPart(const v1::RecordingPart& part) {
  if (!Awaits(part)) return;
  const Answer answer = std::move(waiting_.front().answer);
  waiting_.pop_front();
  if (!waiting_.empty()) Ask();
  answer(part);
}

bool RecordingReads::Begins(const std::string& reader, uint64_t recording_id, uint64_t offset) {
  if (readers_.size() >= kMaxReaders) readers_.clear();
  const bool is_new = readers_.emplace(reader, recording_id).second;
  return is_new || offset == 0;
}

void RecordingReads::RefuseAll(const absl::Status& why) {
  for (const Waiting& each : std::exchange(waiting_, {})) each.answer(why);
}

}  // namespace sweepstake::rpc
