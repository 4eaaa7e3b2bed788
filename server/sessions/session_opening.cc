#include "server/sessions/session_opening.h"

#include <optional>

#include "server/sessions/common/reasons.h"
#include "server/sessions/resume_token.h"

namespace sweepstake::sessions {
namespace {

absl::Status StoreBusy() {
  return Refused(reasons::kStoreBusy, "the prior store is overloaded; connect again later");
}

// Returns whether the Hello, whose token has been checked, may resume this session in memory.
bool CanResume(const GameSession& session, const SessionRequest& hello) {
  const SessionIdentity& identity = session.identity();
  return !session.ended() && identity.scene == hello.scene && identity.arms == hello.arms &&
         identity.backend_versions == hello.backend_versions &&
         session.decisions().setup().stops_trials == hello.stops_trials;
}

}  // namespace

void SessionOpening::Run() {
  if (absl::Status status = CheckResumption(); !status.ok()) return Finish(status);
  if (std::shared_ptr<GameSession> session = FindInMemory())
    return Finish(OpenedSession{std::move(session), /*resumed=*/true, absl::OkStatus()});
  ReadStore();
}

absl::Status SessionOpening::CheckResumption() {
  const auto token_id =
      TokenOfSession(hello_.session_id, hello_.resume_token, context().options.resume_secret);
  if (!token_id) hello_.session_id.clear();
  if (token_id && *token_id != hello_.origin.token_id) {
    return Refused(reasons::kForeignSession,
                   "this session was started with another token; start a new session");
  }
  return table_.CheckKicked(hello_.session_id);
}

std::shared_ptr<GameSession> SessionOpening::FindInMemory() {
  std::shared_ptr<GameSession> session = table_.Find(hello_.session_id);
  if (session && session->superseded()) {
    table_.Forget(*session);
    return nullptr;  // read the session from the store, where the other daemon wrote it
  }
  if (!session || CanResume(*session, hello_)) return session;
  hello_.session_id.clear();
  return nullptr;
}

void SessionOpening::ReadStore() {
  DecisionLoop& loop = context().loop;
  // The deadline is computed before the read, so that it covers the whole read.
  const int64_t deadline_ns = loop.clock().NowNs() + context().options.load_patience_ns;
  if (!SubmitRead()) return Finish(StoreBusy());
  loop.PostAt(deadline_ns, [weak = weak_from_this()] {
    const auto self = weak.lock();
    if (!self) return;
    StoredStart nothing;
    if (!self->hello_.is_of_player) nothing.new_scene = UnstoredScene{.project_count = 0};
    nothing.status = Refused(reasons::kStoreBusy, "no answer");
    self->OnRead(nothing);
  });
}

bool SessionOpening::SubmitRead() {
  const auto deliver = [weak = weak_from_this(), &loop = context().loop](StoredStart start) {
    // PostLater keeps the order with the results of commits, which use it too. When this task runs,
    // the results of all commits that the read includes have already been applied.
    loop.PostLater([weak, start = std::move(start)] {
      if (const auto self = weak.lock()) self->OnRead(start);
    });
  };
  priors::AsyncPriorStore& store = context().store;
  const HostedSessionOptions& options = context().options;
  if (!hello_.session_id.empty()) {
    return store.Submit([deliver, hello = hello_, &options](priors::PriorStore& writer) {
      StoredStart start = LoadStart(writer, hello, options, /*is_writing_thread=*/true);
      CountScene(writer, hello, options, start);
      deliver(std::move(start));
    });
  }
  return store.Read([weak = weak_from_this(), deliver, hello = hello_, &options,
                     &store](priors::PriorReader& reader) {
    if (weak.expired()) return;  // the stream has ended
    StoredStart start = LoadStart(reader, hello, options, /*is_writing_thread=*/false);
    if (!start.new_scene) return deliver(std::move(start));
    const auto count = [deliver, hello, &options, start](priors::PriorStore& writer) mutable {
      CountScene(writer, hello, options, start);
      deliver(std::move(start));
    };
    if (store.Submit(count)) return;
    start.refusal = StoreBusy();
    deliver(std::move(start));
  });
}

void SessionOpening::OnRead(const StoredStart& start) {
  // This is the second of two results: the store's answer, or the end of the time limit. The first
  // one has already been used.
  if (!done_) return;
  // During the read, an operator may have kicked the session, or another connection may have
  // resumed it.
  if (absl::Status kicked = table_.CheckKicked(hello_.session_id); !kicked.ok())
    return Finish(kicked);
  if (std::shared_ptr<GameSession> session = FindInMemory())
    return Finish(OpenedSession{std::move(session), /*resumed=*/true, absl::OkStatus()});
  // During the read, another connection has resumed the session with other arms. The evidence that
  // was read includes that session's own evidence, so a new session must not start from it. The
  // game connects again by itself.
  if (start.source && hello_.session_id.empty()) {
    return Finish(Refused(reasons::kStoreBusy,
                          "another connection has just resumed this session; connect again"));
  }
  Finish(Begin(start));
}

absl::StatusOr<OpenedSession> SessionOpening::Begin(const StoredStart& start) {
  if (context().options.shares_store && !hello_.session_id.empty() && !start.status.ok()) {
    return Refused(reasons::kStoreFailed,
                   "the session cannot be read from the store; connect again later");
  }
  if (!start.refusal.ok()) return start.refusal;
  std::optional<NewScenes::Hold> hold;
  if (start.new_scene) {
    auto taken = table_.new_scenes().Take(hello_.scene, *start.new_scene);
    if (!taken.ok() && !hello_.is_of_player) return taken.status();
    if (!taken.ok()) {
      StoredStart unkept = start;
      unkept.kept_arms.clear();
      unkept.new_scene.reset();
      return Begin(unkept);
    }
    // A player's session must not use up the quota before it has evidence.
    if (!hello_.is_of_player) hold.emplace(*std::move(taken));
  }
  auto session = MakeSession(context(), hello_, start);
  if (!session.ok()) return session.status();
  if (hold) (*session)->Keep(*std::move(hold));
  if (absl::Status status = table_.Add(*session); !status.ok()) return status;
  return OpenedSession{*std::move(session), /*resumed=*/start.source.has_value(), start.status};
}

void SessionOpening::Finish(absl::StatusOr<OpenedSession> result) {
  const auto self = shared_from_this();  // the owner may release *this in the callback
  std::exchange(done_, nullptr)(std::move(result));
}

}  // namespace sweepstake::sessions
