// Connects an AdaptiveBroadPhase to its decider: a daemon (over gRPC) or the embedded decider. It
// sends samples and outcomes to the decider, and switch commands to the frame path.
//
// A Session owns one sender thread. The frame thread only pushes into a bounded lock-free queue and
// reads commands from the mailbox. If the queue is full, the oldest sample is dropped and counted.
// The frame thread never waits for the sender, even if the daemon is absent, slow, killed or
// restarted. A lost connection is opened again with exponential back-off and jitter. Messages that
// were not acknowledged are sent again under the same numbers, so nothing is counted twice.
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

// A file written by the flight recorder.
struct FlightRecording {
  std::string path;  // UTF-8
  int64_t recorded_unix_ms = 0;
  uint64_t bytes = 0;
  uint64_t worst_frame_ns = 0;  // the longest frame in it
};

// The statistics of a session since it began. All fields are from the same moment.
struct SessionStats {
  ConnectionState state = ConnectionState::kOffline;
  std::string last_error;  // the latest error and its remedy; empty: none
  // The daemon's reason for refusing the latest attempt, for example an unknown policy or a revoked
  // token. Trying again does not help, but is done at long intervals. Empty: the daemon did not
  // refuse.
  std::string refusal;
  std::string session_id;  // empty before the first welcome
  uint64_t sent_frame_count = 0;
  uint64_t dropped_frame_count = 0;  // frames lost by a full queue or refused by the daemon
  uint64_t acknowledged_sequence = 0;
  uint64_t sent_sequence = 0;
  // Sending is paused until the daemon acknowledges, because
  // SessionOptions::unacknowledged_messages messages are unacknowledged. After Stop: whether it was
  // paused at the end.
  bool awaits_acknowledgement = false;
  uint64_t connection_count = 0;  // welcomes received
  uint64_t resumed_count = 0;     // welcomes that resumed the session
  uint64_t resent_message_count = 0;
  uint64_t command_count = 0;          // switch commands received
  uint64_t unknown_message_count = 0;  // messages of a newer protocol, ignored
  uint64_t prior_source_count = 0;     // sources in the priors the session started from
  bool priors_unavailable = false;     // the daemon could not read all of its priors
  // The daemon's version, policy and seed. They are empty and 0 before the first welcome, and
  // without a daemon. The same seed gives the same exploration and draws, which only `paper` makes.
  std::string daemon_version;
  std::string policy;
  uint64_t seed = 0;
  DecisionRules rules;  // the daemon's rules for this session, from its welcome in whole ms
  // Times of the sender thread with an embedded decider; 0 with a daemon, which decides elsewhere.
  uint64_t intake_time_ns = 0;    // time to pass the queue's samples to the decider
  uint64_t decision_time_ns = 0;  // total time of all decisions
  uint64_t longest_decision_ns = 0;
  std::vector<ArmBelief> beliefs;  // the latest posterior snapshot; empty: none yet
  // Existing files of the flight recorder, the oldest first; at most 8.
  std::vector<FlightRecording> recordings;
  std::string recording_error;  // why the latest file was not written, and the remedy; empty: none
  // The detection time that choosing saved per measured frame, in µs, estimated against always
  // running the arm with which the game began. A loss is negative. Absent: not known.
  std::optional<double> saved_us = {};
  // The verdict with `beliefs`. The frame thread uses AdaptiveBroadPhase::verdict() instead.
  SceneVerdict verdict;
};

// TLS 1.2 or newer for a connection to a daemon. The files are PEM, of at most 1 MiB; their paths
// have at most 4096 bytes. They are read for every connection, so they may be replaced while the
// game runs.
struct TlsOptions {
  std::string ca_file;      // authorities of the daemon's certificate; empty: the system's
  std::string cert_file;    // the client's certificate, if the daemon requires one
  std::string key_file;     // its private key, without a passphrase; with cert_file only
  std::string server_name;  // the host in the daemon's certificate; empty: the host of the address
};

// The token that a daemon may require. It is sent only with TLS, or to a daemon on this machine,
// and never displayed. At most one of both is set. The file is read for every connection.
struct ClientToken {
  std::string file;  // path, at most 4096 bytes, of a file with only the token
  std::string text;  // the token itself, instead of a file
};

// Keeps the latest five seconds in memory and writes them to a file after a frame that took too
// long: the boxes, the measurements of all frames, and the decisions. `sweepstake-lab replay
// --recording` replays the file on any machine. Writes at most one file in 30 s of frame time, none
// in the first second, and keeps a session's newest 8 files. Cost: README.md, Flight recorder.
struct FlightRecorderOptions {
  // MiB of memory for boxes (24 bytes each), at most 1024; 0: off. If five seconds of boxes need
  // more, the boxes of fewer frames are kept, at equal intervals.
  uint32_t memory_mb = 0;
  // A longer frame triggers a recording, unless the game was paused, loading or suspended. > 0, <=
  // 60,000.
  double frame_budget_ms = 50;
  // An existing folder; its path is UTF-8. A file has at most memory_mb × 4/3 MiB.
  std::string directory = {};
};

struct SessionOptions {
  std::string project = "default";
  std::string scene = "default";
  std::string build = {};          // empty: unknown
  std::string machine_class = {};  // class of comparable machines; empty: MachineClass()
  std::string policy = {};         // empty: the decider's default
  // Rules for this session; absent: those of the daemon's configuration. A daemon refuses an
  // interval between decisions below 250 ms. Unused with an embedded decider.
  DecisionRules rules = {};
  double time_scale = 1;  // 1–1000: divides intervals; above 1 only if the daemon allows it
  bool ignore_priors = false;
  uint64_t seed = 0;  // 0: the decider chooses
  // Lets operators of the daemon choose the mode and the arm. Unused with an embedded decider.
  // Leave it off in a game that is shipped to players.
  bool allow_operator_orders = false;
  // Lets operators of the daemon see the boxes of the game's objects: a few thousand of them, at
  // most four times a second, and only while an operator looks. Unused with an embedded decider.
  // Leave it off in a game that is shipped to players.
  bool allow_box_view = false;
  FlightRecorderOptions flight_recorder = {};

  uint32_t queue_frames = 4096;  // power of two, 2 to 1,048,576; 80 bytes each
  // A batch is sent when the first of these three limits is reached. The daemon's welcome replaces
  // the interval and may lower the other two limits.
  uint32_t batch_interval_ms = 250;  // 1–10,000
  uint32_t batch_frames = 240;       // 1–240
  uint32_t batch_bytes = 16 * 1024;  // 512–262,144
  // 1–4096. With as many, sending pauses, and the queue drops its oldest samples. A daemon
  // acknowledges every two seconds, so 1024 full batches of about 1.5 kB allow 15,000 frames/s.
  uint32_t unacknowledged_messages = 1024;
  uint32_t backoff_min_ms = 100;  // doubles with each attempt up to the maximum, with full jitter
  uint32_t backoff_max_ms = 10'000;

  std::optional<TlsOptions> tls = {};  // absent: plain text; unused with an embedded decider
  ClientToken token = {};              // empty: none; unused with an embedded decider
};

class Session {
 public:
  // Returns the sink to pass to AdaptiveBroadPhase::Create. The session is therefore created first
  // and gets the arms in Start.
  virtual FrameSink& sink() = 0;
  // Starts the sender thread; call it once. The session and `adaptive` may be destroyed in any
  // order: the destructor of each stops the thread, as by Stop(0). kFailedPrecondition: the session
  // was started before, or another session uses `adaptive`.
  virtual Status Start(AdaptiveBroadPhase& adaptive) = 0;
  // Sends the content of the queue and a goodbye within `deadline_ms`, then ends the thread.
  // stats().last_error is set if the daemon did not confirm in time that the last evidence is on
  // disk. May be called more than once.
  virtual void Stop(uint32_t deadline_ms = 500) = 0;
  virtual SessionStats stats() const = 0;
  // Returns EmbeddedDecider::ExportPriors(), from Start on and after Stop. Any thread except the
  // frame thread: it waits for a decision in progress. The frame thread never waits for it.
  // kFailedPrecondition before Start, and with a daemon, which stores the evidence itself.
  virtual Result<std::string> ExportPriors() const = 0;
  virtual ~Session() = default;
};

// Makes a session with the daemon at `address` (HOST:PORT). Start connects to it in the background.
// kInvalidArgument: the address, an option, or a file of `tls` cannot be used.
Result<std::unique_ptr<Session>> MakeDaemonSession(std::string address,
                                                   const SessionOptions& options = {});
// Makes a session without a daemon: the embedded decider runs on the sender thread. Of `options`
// it uses the queue and the flight recorder; scene, policy and so on come from `embedded`.
Result<std::unique_ptr<Session>> MakeEmbeddedSession(const EmbeddedOptions& embedded = {},
                                                     const SessionOptions& options = {});

}  // namespace sweepstake

#include "sweepstake/names/end.h"
