// Connects an AdaptiveBroadPhase to its decider, which is a daemon (over gRPC) or the embedded
// decider. Steps 6, 7 and 11.
//
// A Session owns one sender thread. The frame thread only pushes into a bounded lock-free queue
// (full: the oldest sample is dropped and counted) and takes commands from the mailbox; it never
// waits for the sender, whether the daemon is absent at the start, slow, killed or restarted. A
// lost connection is opened again with exponential back-off and jitter. Messages that were not
// acknowledged are sent again under the same numbers, so that nothing is counted twice.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/embedded_decider.h"
#include "sweepstake/status.h"

#include "sweepstake/names/begin.h"

namespace sweepstake {

enum class ConnectionState : uint32_t {
  kOffline = 0,
  kConnecting = 1,
  kOnline = 2,
  kEmbedded = 3,
  kClosed = 4
};

// A file that the flight recorder has written.
struct FlightRecording {
  uint64_t recording_id = 0;  // numbers those of the session from 1 on
  std::string path;           // UTF-8
  int64_t recorded_unix_ms = 0;
  uint64_t recorded_ns = 0;  // the same, by SteadyClock()
  uint64_t bytes = 0;
  uint64_t worst_frame_ns = 0;  // the longest frame in it
};

// The statistics of a session since it began; a consistent copy.
struct SessionStats {
  ConnectionState state = ConnectionState::kOffline;
  std::string last_error;  // what went wrong most recently and what to do; empty: nothing
  // The daemon's reason when it refused the latest attempt, for example an unknown policy or a
  // token that was revoked. Trying again does not help; it is tried once in a while all the same.
  // Empty: the daemon did not refuse.
  std::string refusal;
  std::string session_id;  // empty before the first welcome
  uint64_t sent_frame_count = 0;
  uint64_t dropped_frame_count = 0;  // because the queue was full, or the daemon refused them
  uint64_t acknowledged_sequence = 0;
  uint64_t sent_sequence = 0;
  // Nothing more is sent until the daemon acknowledges: SessionOptions::unacknowledged_messages are
  // with it. After Stop: it was so to the end.
  bool awaits_acknowledgement = false;
  uint64_t connection_count = 0;  // welcomes received
  uint64_t resumed_count = 0;     // of those, resumed
  uint64_t resent_message_count = 0;
  uint64_t command_count = 0;          // switch commands received
  uint64_t unknown_message_count = 0;  // of a newer protocol, not acted on
  uint64_t prior_source_count = 0;     // sources in the priors the session started from
  bool priors_unavailable = false;     // the daemon could not read all of its priors
  // What the daemon decides with; empty and 0 before the first welcome, and without a daemon. The
  // same seed and policy make the same draws.
  std::string daemon_version;
  std::string policy;
  uint64_t seed = 0;
  // The sender thread's time with an embedded decider; 0 with a daemon, which decides elsewhere.
  uint64_t intake_time_ns = 0;    // to empty the queue and hand it to the decider
  uint64_t decision_time_ns = 0;  // to decide, summed over all decisions
  uint64_t longest_decision_ns = 0;
  std::vector<ArmBelief> beliefs;  // the latest posterior snapshot; empty: none yet
  // What the flight recorder has written and is still there, the oldest first; at most 8.
  std::vector<FlightRecording> recordings;
  std::string recording_error;  // why the latest one was not written, and what to do; empty: it was
  // The verdict of the same snapshot; the frame thread reads AdaptiveBroadPhase::verdict().
  SceneVerdict verdict;
};

// TLS 1.2 or newer of a connection to a daemon. The files are PEM, of at most 1 MiB, and their
// paths have at most 4096 bytes. They are read for every connection, so that they may be replaced
// while the game runs.
struct TlsOptions {
  std::string ca_file;      // authorities of the daemon's certificate; empty: the system's
  std::string cert_file;    // the client's certificate, where the daemon asks for one
  std::string key_file;     // its private key, without a passphrase; with cert_file only
  std::string server_name;  // the host in the daemon's certificate; empty: that of the address
};

// The token that a daemon may ask for. It is sent with TLS, or to a daemon on this machine, and
// shown nowhere. At most one of the two is given.
struct ClientToken {
  std::string file;  // of at most 4096 bytes, with the token alone; read for every connection
  std::string text;  // the token itself
};

// Keeps the latest five seconds, and writes them to a file after a frame that took too long: the
// boxes, the figures of all frames, and the decisions, for `sweepstake replay --recording` on any
// machine. At most one file in 30 s of frame time, none in the first second, the newest 8 of a
// session. Cost: README.md, Flight recorder.
struct FlightRecorderOptions {
  // Of boxes, 24 bytes each, at most 1024; 0: off. Where the boxes of five seconds need more, those
  // of fewer frames are kept, at equal intervals.
  uint32_t memory_mb = 0;
  // A longer frame is recorded, unless it was paused or loading; over 0.
  double frame_budget_ms = 50;
  std::string directory = {};  // an existing folder, in UTF-8, for files of memory_mb × 4/3 at most
};

struct SessionOptions {
  std::string project = "default";
  std::string scene = "default";
  std::string build;          // empty: unknown
  std::string machine_class;  // machines whose timings compare; empty: MachineClass() says it
  std::string policy;         // empty: the decider's default
  double time_scale = 1;      // 1–1000; above 1 a daemon refuses unless it is set to allow it
  bool ignore_priors = false;
  uint64_t seed = 0;  // 0: the decider chooses
  // Whether operators of the daemon may choose the mode and the arm; of no use to an embedded
  // decider. Leave it off in a game that players get.
  bool allow_operator_orders = false;
  // Whether operators of the daemon may look at the boxes of the game's objects: some thousands of
  // them, at most four times a second, and none while nobody looks. Of no use to an embedded
  // decider. Leave it off in a game that players get.
  bool allow_box_view = false;
  FlightRecorderOptions flight_recorder;
  // Whether operators of the daemon may download what the flight recorder has written. Nothing is
  // sent unless they ask. Of no use to an embedded decider. Leave it off in a game that players
  // get.
  bool allow_recording_download = false;

  uint32_t queue_frames = 4096;  // power of two, 2 to 1,048,576; 80 bytes each
  // A batch is sent when the first of these three limits is reached. The daemon's welcome replaces
  // the interval and may lower the other two.
  uint32_t batch_interval_ms = 250;  // 1–10,000
  uint32_t batch_frames = 240;       // 1–240
  uint32_t batch_bytes = 16 * 1024;  // 512–262,144
  // 1–4096. At the bound sending pauses, and the queue drops its oldest samples. A daemon
  // acknowledges every two seconds, so that 1024 full batches of about 1.5 kB allow 15,000
  // frames/s.
  uint32_t unacknowledged_messages = 1024;
  uint32_t backoff_min_ms = 100;  // doubles with each attempt up to the maximum, with full jitter
  uint32_t backoff_max_ms = 10'000;

  std::optional<TlsOptions> tls;  // absent: plain text; of no use to an embedded decider
  ClientToken token;              // empty: none; of no use to an embedded decider
};

class Session {
 public:
  // Returns the sink to give to AdaptiveBroadPhase::Create. The session is therefore created first
  // and learns the arms in Start.
  virtual FrameSink& sink() = 0;
  // Starts the sender thread; to be called once. `adaptive` must outlive Stop.
  virtual Status Start(AdaptiveBroadPhase& adaptive) = 0;
  // Tells the decider about a mode change that was made with AdaptiveBroadPhase::SetMode. Called on
  // the frame thread; it does not wait.
  virtual void OnModeChange() = 0;
  // Sends the content of the queue and a goodbye within `deadline_ms`, and ends the thread. If the
  // daemon could not put the last evidence on disk, or did not say in time that it has,
  // stats().last_error says so. Idempotent.
  virtual void Stop(uint32_t deadline_ms = 500) = 0;
  virtual SessionStats stats() const = 0;
  // Returns what EmbeddedDecider::ExportPriors does, from Start on and after Stop. Any thread; the
  // frame thread does not wait for it, but should not call it: it waits for a decision under way.
  // kFailedPrecondition before Start, and with a daemon, which keeps what it learns itself.
  virtual Result<std::string> ExportPriors() const = 0;
  virtual ~Session() = default;
};

// `address` is HOST:PORT. Start connects to it in the background. Error: kInvalidArgument (the
// address, an option, or a file of `tls` that cannot be used).
Result<std::unique_ptr<Session>> MakeDaemonSession(std::string address,
                                                   const SessionOptions& options);
// Makes a session without a daemon: the embedded decider runs on the sender thread.
Result<std::unique_ptr<Session>> MakeEmbeddedSession(const EmbeddedOptions& embedded,
                                                     const SessionOptions& options);

}  // namespace sweepstake

#include "sweepstake/names/end.h"
