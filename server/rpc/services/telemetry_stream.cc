#include "server/rpc/services/telemetry_stream.h"

#include <spdlog/logger.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine_client/text/counts.h"
#include "server/net/peer_address.h"
#include "server/rpc/common/error_reasons.h"
#include "server/rpc/common/message_validation.h"
#include "server/rpc/common/proto_conversion.h"
#include "server/sessions/session_table.h"

namespace sweepstake::rpc {
namespace {

constexpr int64_t kNoteIntervalNs = 60'000'000'000;

}  // namespace

void TelemetryStream::Accept() {
  number_ = ++streams_.last_number;
  streams_.all.emplace(number_, this);
  context_.counters.open_stream_count = streams_.all.size();
  if (streams_.draining) return Drain(context_.options.reconnect_delay_ms);
  if (streams_.all.size() > size_t{context_.options.max_sessions} + kMaxStreamsWithoutSession) {
    return Reject(Refused(
        v1::ERROR_REASON_TOO_MANY_STREAMS,
        "this daemon has the maximum number of streams; try again later, or use another daemon"));
  }
  if (absl::Status status = CountAddress(); !status.ok()) return Reject(status);
  transport_.Read();
}

absl::Status TelemetryStream::CountAddress() {
  const std::string address = net::AddressOf(transport_.peer());
  if (address.empty() || net::IsLoopbackAddress(address)) return absl::OkStatus();
  uint32_t& count = streams_.address_counts[address];
  if (count >= context_.options.max_streams_per_address) {
    return Refused(v1::ERROR_REASON_TOO_MANY_STREAMS,
                   absl::StrCat("this address has ", count,
                                " streams, the maximum (max_streams_per_address); end some, or "
                                "raise the limit on the daemon"));
  }
  ++count;
  address_ = address;
  return absl::OkStatus();
}

void TelemetryStream::OnCancelled() {
  ClearOutbox();
  if (!end_) end_ = absl::CancelledError("the connection was lost");
  LeaveSession();
  WriteNext();
}

void TelemetryStream::OnDone() {
  LeaveSession();
  if (const auto count = streams_.address_counts.find(address_);
      count != streams_.address_counts.end() && --count->second == 0) {
    streams_.address_counts.erase(count);
  }
  streams_.all.erase(number_);
  context_.counters.open_stream_count = streams_.all.size();
}

void TelemetryStream::OnMessage(v1::StreamTelemetryRequest* request) {
  if (end_ || SaidGoodbye()) return;
  if (request == nullptr) {
    ++context_.counters.malformed_message_count;
    return Reject(Refused(v1::ERROR_REASON_MALFORMED_MESSAGE,
                          "a message does not parse as sweepstake.v1.StreamTelemetryRequest"));
  }
  if (const absl::Status status = CountMessage(*request); !status.ok()) return Reject(status);
  const bool opens = session_ == nullptr;
  const absl::Status status = Dispatch(*request);
  if (!status.ok()) {
    ++context_.counters.invalid_message_count;
    return Reject(status);
  }
  // Request the next message, with two exceptions. After a Hello, Enter requests it. After a
  // Goodbye no message is needed: the session closes the stream once its evidence is on disk.
  if (!opens && session_ && !SaidGoodbye() && !end_) transport_.Read();
}

bool TelemetryStream::SaidGoodbye() const { return session_ && session_->ended(); }

absl::Status TelemetryStream::CountMessage(const v1::StreamTelemetryRequest& request) {
  const uint32_t per_s = context_.options.max_messages_per_s;
  if (messages_.Take(per_s * time_scale_, context_.loop.clock().NowNs())) {
    return request.has_hello() ? context_.access.BeginHello(caller_, transport_.peer())
                               : absl::OkStatus();
  }
  return Refused(v1::ERROR_REASON_TOO_MANY_MESSAGES,
                 absl::StrCat("the game sent too many messages: max_messages_per_s allows ", per_s,
                              " messages per second of game time, and a burst of ten times as "
                              "many; send batches at the interval of the Welcome, and connect "
                              "again in ten seconds"));
}

absl::Status TelemetryStream::Dispatch(v1::StreamTelemetryRequest& request) {
  if (!session_) {
    if (!request.has_hello())
      return Refused(v1::ERROR_REASON_MESSAGE_ORDER, "the first request of a stream must be Hello");
    return Open(*request.mutable_hello());
  }
  const absl::Status status =
      CheckRequest(request, static_cast<uint32_t>(session_->identity().arms.size()));
  if (!status.ok()) return status;
  // This copy keeps the session alive, because ending it clears session_.
  const std::shared_ptr<sessions::GameSession> session = session_;
  if (request.has_goodbye()) {
    session->End();
  } else if (request.has_box_view()) {
    request.mutable_box_view()->DiscardUnknownFields();
    session->boxes().OnView(request.box_view().SerializeAsString());
  } else {
    FromProto(request, telemetry_);
    const uint64_t suspended_count = context_.counters.suspended_frame_count;
    const uint64_t invalid_count = context_.counters.invalid_box_batch_count;
    session->Apply(telemetry_);
    if (context_.counters.suspended_frame_count != suspended_count) ReportSuspension(*session);
    if (context_.counters.invalid_box_batch_count != invalid_count)
      ReportInvalidBoxes(*session, request.frame_batch().invalid_box_count());
  }
  return absl::OkStatus();
}

absl::Status TelemetryStream::Open(v1::Hello& hello) {
  time_scale_ = std::max(1.0, hello.time_scale());
  const decision::DecisionOptions& defaults = context_.options.decision;
  if (hello.policy().empty()) hello.set_policy(defaults.policy);
  if (!hello.has_weights()) *hello.mutable_weights() = ToProto(defaults.weights);
  if (absl::Status status = CheckHello(hello, context_.options); !status.ok()) return status;
  if (absl::Status status = CheckProject(caller_, hello.project()); !status.ok()) return status;
  sessions::SessionRequest request = FromProto(hello);
  request.origin.token_id = caller_.token_id;
  request.origin.player = caller_.player;
  request.origin.network = net::NetworkOf(transport_.peer());
  request.is_of_player = caller_.role == auth::Role::kPlayer;
  opening_ = std::make_shared<sessions::SessionOpening>(
      context_.sessions, std::move(request),
      [this](const absl::StatusOr<sessions::OpenedSession>& opened) { OnOpened(opened); });
  opening_->Run();
  return absl::OkStatus();
}

void TelemetryStream::OnOpened(const absl::StatusOr<sessions::OpenedSession>& opened) {
  if (!opened.ok()) return Reject(opened.status());
  if (!opened->missing.ok()) ReportMissingEvidence(opened->missing);
  Enter(*opened);
}

bool TelemetryStream::NoteIsDue(int64_t& next_ns) const {
  const int64_t now_ns = context_.loop.clock().NowNs();
  if (now_ns < next_ns) return false;
  next_ns = now_ns + kNoteIntervalNs;
  return true;
}

void TelemetryStream::ReportMissingEvidence(const absl::Status& status) {
  const uint64_t count = ++context_.counters.degraded_start_count;
  if (!NoteIsDue(streams_.next_store_warning_ns)) return;
  context_.log.warn(
      "the prior store cannot be read ({}): sessions begin without its evidence, {} so far; check "
      "the disk, and restore a backup if the database is damaged",
      std::string(status.message()), count);
}

void TelemetryStream::ReportUnknownArms(const sessions::SessionIdentity& identity) {
  const auto unknown = std::find(identity.kept_arms.begin(), identity.kept_arms.end(), false);
  if (unknown == identity.kept_arms.end()) return;
  const uint64_t count = ++context_.counters.unknown_arm_session_count;
  if (!NoteIsDue(streams_.next_unknown_arms_note_ns)) return;
  const auto arm = static_cast<size_t>(unknown - identity.kept_arms.begin());
  context_.log.warn(
      "session {}: evidence of players about {} of {} arms, such as {} (version {}), of scene {} "
      "of "
      "project {} is not stored, because they are not known there, or the project has too many "
      "machine classes; run the game once with a token of the role ingest, or import and promote "
      "evidence; such sessions so far: {} (at most one line per minute)",
      identity.id, std::count(identity.kept_arms.begin(), identity.kept_arms.end(), false),
      identity.kept_arms.size(), identity.arms[arm], identity.backend_versions[arm],
      identity.scene.scene, identity.scene.project, count);
}

void TelemetryStream::Enter(const sessions::OpenedSession& opened) {
  session_ = opened.session;
  // If the store could not be read, the reason has been reported.
  if (!opened.resumed && opened.missing.ok()) ReportUnknownArms(session_->identity());
  const std::shared_ptr<sessions::SessionOpening> opening = std::exchange(opening_, nullptr);
  const sessions::SessionRequest& hello = opening->hello();
  context_.sessions.Attach(*session_, *this,
                           {.address = transport_.peer(), .build = hello.origin.build});
  ++context_.counters.connected_stream_count;
  if (opened.resumed) ++context_.counters.resumed_count;
  v1::Welcome& welcome = *Outbox().mutable_welcome();
  ToProto(*session_, hello, context_.options, welcome);
  welcome.set_resumed(opened.resumed);
  decision_interval_ms_ = welcome.decision_interval_ms();
  batch_interval_ms_ = BatchIntervalMs(decision_interval_ms_, streams_.all.size());
  welcome.set_batch_interval_ms(batch_interval_ms_);
  WriteNext();
  session_->Start(hello);
  // The Hello is not needed any more, so both request buffers are free: read into both.
  for (size_t i = 0; i < TelemetryTransport::kMaxReads; ++i) transport_.Read();
  context_.log.debug("session {} {}", session_->identity().id,
                     opened.resumed ? "resumed" : "began");
}

void TelemetryStream::ReportSuspension(const sessions::GameSession& session) {
  if (!NoteIsDue(streams_.next_suspension_note_ns)) return;
  context_.log.info(
      "session {}: its system suspended the game in a frame, which is therefore not evidence; "
      "suspended frames of all games so far: {}",
      session.identity().id, context_.counters.suspended_frame_count.load());
}

void TelemetryStream::ReportInvalidBoxes(const sessions::GameSession& session, uint32_t count) {
  if (!NoteIsDue(streams_.next_invalid_boxes_note_ns)) return;
  context_.log.warn(
      "session {}: invalid boxes (infinite, NaN or min > max), which collide with nothing: {}",
      session.identity().id, text::Counted(count, "object"));
}

void TelemetryStream::OnHalfClose() {
  if (SaidGoodbye()) return;
  LeaveSession();
  if (!end_) Close(absl::OkStatus());
}

void TelemetryStream::EndIfRefused() {
  if (end_) return;
  if (const absl::Status still = context_.access.CheckStill(caller_); !still.ok()) Reject(still);
}

void TelemetryStream::Drain(uint32_t delay_ms) {
  if (end_) return;
  if (const std::shared_ptr<sessions::GameSession> session = session_)
    return session->Drain(delay_ms);
  SendReconnect(delay_ms);
  Close(Refused(v1::ERROR_REASON_DRAINING, "the daemon is draining; connect again"));
}

v1::StreamTelemetryResponse& TelemetryStream::Outbox() {
  has_outbox_ = true;
  return outbox_;
}

v1::StreamTelemetryResponse TelemetryStream::TakeOutbox() {
  has_outbox_ = false;
  return std::exchange(outbox_, {});
}

void TelemetryStream::ClearOutbox() {
  if (std::exchange(has_outbox_, false)) outbox_.Clear();
}

void TelemetryStream::SendSwitch(const SwitchCommand& command) {
  ToProto(command, *Outbox().mutable_switch_command());
  WriteNext();
}

void TelemetryStream::SendAcknowledgement(uint64_t sequence) {
  v1::Acknowledgement& message = *Outbox().mutable_acknowledgement();
  message.set_sequence(sequence);
  const uint32_t interval_ms = BatchIntervalMs(decision_interval_ms_, streams_.all.size());
  if (std::exchange(batch_interval_ms_, interval_ms) != interval_ms)
    message.set_batch_interval_ms(interval_ms);
  WriteNext();
}

void TelemetryStream::PutSnapshot(const decision::DecisionRecord& record) {
  Outbox().clear_posterior_snapshot();
  ToProto(record, *outbox_.mutable_posterior_snapshot());
}

void TelemetryStream::SendReconnect(uint32_t delay_ms) {
  Outbox().mutable_reconnect()->set_delay_ms(delay_ms);
  WriteNext();
}

void TelemetryStream::SendOrder(uint64_t order_id, const decision::OrderReport& order) {
  Outbox().clear_operator_order();
  ToProto(order, *outbox_.mutable_operator_order());
  outbox_.mutable_operator_order()->set_order_id(order_id);
  WriteNext();
}

void TelemetryStream::SendBoxRequest(uint32_t interval_ms, uint32_t max_bytes, uint32_t until_ms) {
  v1::BoxRequest& message = *Outbox().mutable_box_request();
  message.set_interval_ms(interval_ms);
  message.set_max_bytes(max_bytes);
  message.set_until_ms(until_ms);
  WriteNext();
}

bool TelemetryStream::SpendBailOut() {
  return context_.access.SpendBailOut(caller_, transport_.peer());
}

void TelemetryStream::WriteNext() {
  if (writing_ || finished_) return;
  if (has_outbox_) {
    writing_ = true;
    transport_.Write(TakeOutbox());
  } else if (end_) {
    finished_ = true;
    transport_.Finish(*end_);
  }
}

void TelemetryStream::OnWritten(bool ok) {
  writing_ = false;
  if (!ok) ClearOutbox();
  WriteNext();
}

void TelemetryStream::Reject(const absl::Status& status) {
  context_.access.refusals().Tell(transport_.peer(), status);
  ClearOutbox();
  Close(status);
}

void TelemetryStream::Close(const absl::Status& status) {
  if (end_) return;
  end_ = status;
  LeaveSession();
  WriteNext();
  if (finished_) return;
  const int64_t deadline_ns = context_.loop.clock().NowNs() + context_.options.close_patience_ns;
  context_.loop.PostAt(deadline_ns, [weak = weak_from_this(), status] {
    if (const auto self = weak.lock()) self->Abort(status);
  });
}

void TelemetryStream::Abort(const absl::Status& status) {
  if (finished_) return;
  end_ = status;
  ClearOutbox();
  LeaveSession();
  if (writing_) {
    // The pending write waits for a client that does not read. Cancel makes it fail. OnWritten then
    // finishes the stream.
    transport_.Cancel(status);
    end_ = absl::CancelledError("the call was cut off");
  }
  WriteNext();
}

void TelemetryStream::LeaveSession() {
  opening_.reset();
  if (const std::shared_ptr<sessions::GameSession> session = std::exchange(session_, nullptr))
    context_.sessions.Detach(*session, *this);
}

uint32_t ReconnectDelayMs(const RpcOptions& options, uint64_t rank) {
  const uint64_t later_ms = rank * 1'000 / options.reconnects_per_s;
  return options.reconnect_delay_ms + static_cast<uint32_t>(later_ms);
}

uint32_t BatchIntervalMs(uint32_t decision_interval_ms, uint64_t stream_count) {
  const uint32_t alone = std::clamp(decision_interval_ms / 8, 1u, 250u);
  const uint64_t shared = std::min<uint64_t>(stream_count / 10, decision_interval_ms / 2);
  return std::max(alone, static_cast<uint32_t>(shared));
}

void TelemetryStreams::EndRefused() {
  // The loop over `all` is safe, because a stream that ends leaves `all` in a later task.
  for (const auto& [number, stream] : all) stream->EndIfRefused();
}

void TelemetryStreams::Drain(const RpcOptions& options) {
  draining = true;
  const std::map<uint64_t, TelemetryStream*> told = all;
  uint64_t rank = 0;
  for (const auto& [number, stream] : told) stream->Drain(ReconnectDelayMs(options, rank++));
}

}  // namespace sweepstake::rpc
