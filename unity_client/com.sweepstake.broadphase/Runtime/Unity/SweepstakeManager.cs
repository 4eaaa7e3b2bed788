#nullable enable
using System;
using System.Collections.Generic;
using System.Linq;
using Unity.Profiling;
using UnityEngine;
using UnityEngine.SceneManagement;

namespace Sweepstake.Unity
{
    /// <summary>The state of a <see cref="SweepstakeManager"/>.</summary>
    public enum SweepstakeState
    {
        /// <summary>The manager is not enabled.</summary>
        Stopped,
        /// <summary>The manager could not start or had to end; <see cref="SweepstakeManager.Problem"/> says why and what to do.</summary>
        Failed,
        /// <summary>The manager works without a daemon: decisions are made in the game's process, and nothing leaves the machine.</summary>
        Embedded,
        /// <summary>A daemon is configured and has not answered yet.</summary>
        Connecting,
        Online,
        /// <summary>The daemon is not available. The game continues with its current backend and reconnects automatically.</summary>
        Offline,
        /// <summary>The daemon refuses this game and will do so again; <see cref="SweepstakeManager.Problem"/> says what to do.</summary>
        Refused,
    }

    /// <summary>
    /// The only component that a game needs. It owns a session and searches the boxes of its <see cref="Source"/> once a frame. The
    /// embedded decider (the default), a daemon or only the game selects the backend. It runs after the LateUpdate of the game's scripts.
    /// Use all members on the main thread; all events are raised on it. A frame never waits and allocates nothing.
    /// </summary>
    [AddComponentMenu("Sweepstake/Sweepstake Manager")]
    [DisallowMultipleComponent]
    [DefaultExecutionOrder(10_000)]
    [DocumentationPage("components.md")]
    public sealed class SweepstakeManager : MonoBehaviour
    {
        [Tooltip("How the manager searches, decides and connects to a daemon. None: the defaults, with decisions in the game itself.")]
        [SerializeField] private SweepstakeConfig? config;
        [Tooltip("Ai: the decider selects the backend. Manual: only you select it.")]
        [SerializeField] private SessionMode mode = SessionMode.Ai;
        [Tooltip("The first backend, and the backend in Manual. Empty: KDTree, or the first of the config's.")]
        [SerializeField, BackendName] private string backend = "";

        private readonly Listeners<SweepstakeState> stateChanged = new Listeners<SweepstakeState>();
        private readonly Listeners<string> backendChanged = new Listeners<string>();
        private readonly Listeners<Verdict> verdictChanged = new Listeners<Verdict>();
        private readonly Listeners<Decision> decided = new Listeners<Decision>();
        private SessionHost? host;
        // The session of a manager that is disabled; it continues when the manager is enabled again.
        private SessionHost? resting;
        private (int Arm, Decision Decision, Verdict Verdict) seen;
        private IBroadPhaseSource? source;
        private SweepstakeConfig? defaults;
        private string trouble = "";
        private ulong endedNs;
        private bool isFailing;
        private bool mustBegin;
        private bool isPaused;
        private bool isInBackground;
        private bool wasAway;
        // The next frame is flagged as loading.
        private bool isSkipping = true;

        /// <summary>Raised when the state has changed.</summary>
        public event Action<SweepstakeState>? StateChanged { add => stateChanged.Add(value); remove => stateChanged.Remove(value); }
        /// <summary>Raised when another backend becomes active; the argument is its name.</summary>
        public event Action<string>? BackendChanged { add => backendChanged.Add(value); remove => backendChanged.Remove(value); }
        /// <summary>Raised when the kind of the verdict has changed. <see cref="Advice.Of(VerdictKind)"/> says what to do about it.</summary>
        public event Action<Verdict>? VerdictChanged { add => verdictChanged.Add(value); remove => verdictChanged.Remove(value); }
        /// <summary>Raised when a decision was made.</summary>
        public event Action<Decision>? Decided { add => decided.Add(value); remove => decided.Remove(value); }

        /// <summary>The enabled managers in the order in which they were enabled.</summary>
        public static IReadOnlyList<SweepstakeManager> Enabled => EnabledManagers;

        private static readonly List<SweepstakeManager> EnabledManagers = new List<SweepstakeManager>();

        /// <summary>The settings; null for the defaults. A change takes effect when the manager is enabled the next time.</summary>
        public SweepstakeConfig? Config { get => config; set => config = value; }

        /// <summary>Provides the boxes to search; null: there is nothing to search, and no frame is run.</summary>
        public IBroadPhaseSource? Source
        {
            get => source;
            set
            {
                source = value;
                isSkipping = true;
            }
        }

        /// <summary>The running session; null while the manager is not running.</summary>
        public BroadPhaseSession? Session => host?.Session;
        public EmbeddedDecider? Decider => host?.Decider;
        public DaemonConnection? Connection => host?.Connection;
        /// <summary>Whether the running session has searched. Before its first search, the source may have pairs of an earlier session.</summary>
        internal bool HasSearched => host != null && endedNs != 0;
        public SweepstakeState State { get; private set; }
        /// <summary>What is wrong and what to do; "" if nothing is wrong.</summary>
        public string Problem { get; private set; } = "";
        /// <summary>The names of the backends that may be selected; empty while the manager is not running.</summary>
        public IReadOnlyList<string> Backends => host == null ? Array.Empty<string>() : host.Session.Arms;
        /// <summary>Name of the active backend; "" while the manager is not running.</summary>
        public string ActiveBackend => host == null ? "" : host.Session.Arms[host.Session.ActiveArm];

        /// <summary>Whether the decider or the game selects backends. The decider never changes the backend in Manual.</summary>
        public SessionMode Mode
        {
            get => host == null ? mode : host.Session.Mode;
            set
            {
                mode = value;
                if (host != null)
                    host.Session.Mode = value;
            }
        }

        /// <summary>Selects a backend from the next frame on. The mode does not change, so the decider may switch again.</summary>
        /// <exception cref="SweepstakeException">The backend is unknown; the message lists the names.</exception>
        public void SelectBackend(string name)
        {
            host?.Session.SelectArm(name);
            backend = name;
        }

        /// <summary>Whether the game is loading. Frames during which it is set are excluded from learning.</summary>
        public bool IsLoading { get; set; }
        /// <summary>The measurements of the latest frame; zeros before the first.</summary>
        public FrameSample LastSample => host == null ? default : host.Session.LastSample;
        public Verdict Verdict => host == null ? default : host.Session.Verdict;
        /// <summary>The latest decision with its reasons.</summary>
        public Decision LastDecision => host == null ? default : host.Session.LastDecision;

        /// <summary>
        /// Connects to the config's daemon, which decides from the next frame on. From then on the game sends the data that privacy.md lists.
        /// </summary>
        public void Connect()
        {
            SweepstakeConfig settings = ConfigOrDefault();
            Guarded(() => Connect(DaemonTransport.Make(settings.daemon), settings.ToLinkOptions(gameObject.scene.name, Application.version)));
        }

        /// <summary>Like <see cref="Connect()"/>, with a custom transport.</summary>
        public void Connect(ITelemetryTransport transport, LinkOptions options) => RunningHost.DecideThere(transport, options);

        /// <summary>
        /// Ends the connection, which first sends the remaining messages for at most half a second. Then the embedded decider decides again.
        /// </summary>
        public void Disconnect()
        {
            if (host != null)
                Guarded(host.DecideHere);
        }

        /// <summary>Writes a row for each frame from now on, on a separate thread.</summary>
        /// <param name="path">An existing file is replaced.</param>
        /// <exception cref="System.IO.IOException">The file cannot be written.</exception>
        public void StartCsv(string path, string scene = "", ulong seed = 0) => RunningHost.StartCsv(path, scene, seed);

        /// <summary>Writes the remaining rows and waits for at most two seconds.</summary>
        public void StopCsv() => host?.StopCsv();

        private SessionHost RunningHost =>
            host ?? throw new InvalidOperationException("Enable the manager first. If it is enabled, its Problem says why it does not run.");

        /// <summary>Ends all native objects of the process within about half a second. May be called at any time between frames.</summary>
        public static void Shutdown()
        {
            // This ends the native objects of all managers at the same time, so the wait does not depend on their number. Each host below then
            // ends without a wait.
            ulong endNs = DeadlineNs;
            foreach (SweepstakeManager manager in EnabledManagers)
                manager.host?.BeginEnd();
            SweepstakeLibrary.Shutdown();
            // A listener may disable managers during the loop.
            for (int index = EnabledManagers.Count - 1; index >= 0; --index)
            {
                if (index < EnabledManagers.Count)
                    EnabledManagers[index].End(SweepstakeState.Stopped, "", endNs);
            }
        }

        private void OnEnable()
        {
            EnabledManagers.Add(this);
            SceneManager.sceneLoaded += OnSceneLoaded;
            // If a listener of a failure enables the manager again, it begins in the next frame, to avoid an endless recursion.
            mustBegin = isFailing;
            if (!isFailing)
                TryBegin();
        }

        private void OnDisable()
        {
            SceneManager.sceneLoaded -= OnSceneLoaded;
            EnabledManagers.Remove(this);
            mustBegin = false;
            if (host != null && host.Rest(DeadlineNs))
                (resting, host) = (host, null);
            End(SweepstakeState.Stopped, "", DeadlineNs);
        }

        private void OnDestroy()
        {
            EndResting();
            if (defaults != null)
                Destroy(defaults);
        }

        /// <summary>Applies changes that were made in the inspector during play, in the next frame.</summary>
        private void OnValidate()
        {
            if (host == null)
                return;
            host.Session.Mode = mode;
            Guarded(SelectEdited);
        }

        private void SelectEdited()
        {
            BroadPhaseSession session = host!.Session;
            // In AI Decides the decider selects the backend. SelectArm is called for an unknown name too, because it refuses it with a reason.
            if (backend.Length > 0 && (mode == SessionMode.Manual || !session.Arms.Contains(backend)))
                session.SelectArm(backend);
        }

        private void OnApplicationPause(bool isPaused)
        {
            this.isPaused = isPaused;
            // A mobile system may end a paused game without a further call.
            if (isPaused)
                host?.Decider?.BeginSave();
        }

        private void OnApplicationFocus(bool hasFocus) => isInBackground = !hasFocus && !Application.isEditor;

        private void LateUpdate()
        {
            if (mustBegin)
            {
                mustBegin = false;
                TryBegin();
            }
            if (host == null)
                return;
            UpdateState();
            // A listener may have disabled this manager.
            if (host == null || source == null)
                return;
            try
            {
                PlayFrame(host, source);
            }
            catch (SweepstakeException problem)
            {
                Fail(problem.Message);
                return;
            }
            Report(source);
        }

        private void PlayFrame(SessionHost running, IBroadPhaseSource searched)
        {
            using ProfilerMarker.AutoScope scope = SweepstakeProfiling.Search.Auto();
            BroadPhaseSession session = running.Session;
            session.BeginFrame();
            try
            {
                searched.Search(session);
            }
            finally
            {
                ulong nowNs = SteadyClock.NowNs;
                running.EndFrame(endedNs == 0 ? 1 : nowNs - endedNs, TakeFlags());
                endedNs = nowNs;
            }
            SweepstakeProfiling.Show(session.LastSample);
        }

        /// <summary>The flags of this frame. The first frame after a pause or load is flagged too, because its time includes the pause.</summary>
        private FrameFlags TakeFlags()
        {
            bool isAway = isPaused || isInBackground || Time.timeScale == 0;
            FrameFlags flags = isAway || wasAway ? FrameFlags.Paused : FrameFlags.None;
            if (IsLoading || isSkipping)
                flags |= FrameFlags.Loading;
            wasAway = isAway;
            isSkipping = IsLoading;
            return flags;
        }

        private void Report(IBroadPhaseSource searched)
        {
            using ProfilerMarker.AutoScope scope = SweepstakeProfiling.Events.Auto();
            try
            {
                searched.Report();
                if (host != null)
                    RaiseChanges(host.Session);
            }
            catch (Exception problem)
            {
                Debug.LogException(problem, this);
            }
        }

        /// <summary>Raises an event for each change of state, backend, verdict or decision. Returns early if a listener ends the session.</summary>
        private void RaiseChanges(BroadPhaseSession session)
        {
            var last = seen;
            var now = seen = StateOf(session);
            // Decisions of a daemon have a command id but no decision id.
            bool isNew = now.Decision.DecisionId != last.Decision.DecisionId || now.Decision.CommandId != last.Decision.CommandId;
            if (now.Arm != last.Arm)
                backendChanged.Raise(session.Arms[now.Arm], this);
            if (Session == session && isNew && now.Decision.Outcome != DecisionOutcome.None)
                decided.Raise(now.Decision, this);
            if (Session == session && now.Verdict.Kind != last.Verdict.Kind)
                verdictChanged.Raise(now.Verdict, this);
        }

        private static (int Arm, Decision Decision, Verdict Verdict) StateOf(BroadPhaseSession session) =>
            (session.ActiveArm, session.LastDecision, session.Verdict);

        /// <summary>Begins. If only the decider has a problem, the frames run without it, and the problem is shown at once.</summary>
        private void TryBegin()
        {
            Guarded(Begin);
            if (host != null)
                UpdateState();
        }

        private void Begin()
        {
            SweepstakeConfig settings = ConfigOrDefault();
            SweepstakeLibrary.EnsureLoaded();
            isSkipping = true;
            endedNs = 0;
            if (resting != null && resting.Continue(settings, mode, backend, gameObject.scene.name))
            {
                (host, resting) = (resting, null);
                seen = StateOf(host.Session);
                return;
            }
            EndResting();
            host = new SessionHost(settings, mode, backend, gameObject.scene.name, LogError);
            seen = StateOf(host.Session);
            host.DecideHere();
            if (settings.daemon.isUsed)
                Connect();
        }

        private static ulong DeadlineNs => SteadyClock.After(SessionWork.DisposeTimeoutMs);

        private void End(SweepstakeState state, string problem, ulong endNs)
        {
            host?.End(endNs);
            host = null;
            SetState(state, problem);
        }

        private void Fail(string problem)
        {
            isFailing = true;
            End(SweepstakeState.Failed, problem, DeadlineNs);
            isFailing = false;
        }

        private void EndResting()
        {
            resting?.End(DeadlineNs);
            resting = null;
        }

        /// <summary>Runs an action. Logs its error once; the session then continues as before the action.</summary>
        private void Guarded(Action action)
        {
            trouble = "";
            try
            {
                action();
            }
            catch (SweepstakeException problem)
            {
                trouble = problem.Message;
                if (host == null)
                    Fail(trouble);
                else
                    LogError(trouble);
            }
        }

        private void LogError(string problem) => Debug.LogError("Sweepstake: " + problem, this);

        private void UpdateState()
        {
            ConnectionStatus? status = host!.Connection?.Status;
            SetState(status == null ? SweepstakeState.Embedded : StateOf(status), host.FindProblem(status, trouble));
        }

        private static SweepstakeState StateOf(ConnectionStatus status)
        {
            if (status.State == LinkState.Online)
                return SweepstakeState.Online;
            if (status.Refusal.Length > 0)
                return SweepstakeState.Refused;
            bool isNew = status.State == LinkState.Connecting || status.State == LinkState.Offline;
            return isNew && status.LastError.Length == 0 && status.Stats.ConnectionCount == 0 ? SweepstakeState.Connecting : SweepstakeState.Offline;
        }

        private void SetState(SweepstakeState state, string problem)
        {
            Problem = problem;
            if (state == State)
                return;
            State = state;
            if (state == SweepstakeState.Failed)
                LogError(problem);
            else if (state == SweepstakeState.Offline || state == SweepstakeState.Refused)
                Debug.LogWarning($"Sweepstake: the daemon is not available ({state}). {problem}", this);
            else if (state == SweepstakeState.Online)
                Debug.Log("Sweepstake: the daemon decides.", this);
            stateChanged.Raise(state, this);
        }

        private SweepstakeConfig ConfigOrDefault()
        {
            if (config != null)
                return config;
            if (defaults == null)
            {
                defaults = ScriptableObject.CreateInstance<SweepstakeConfig>();
                defaults.hideFlags = HideFlags.HideAndDontSave;
            }
            return defaults;
        }

        private void OnSceneLoaded(Scene scene, LoadSceneMode how) => isSkipping = true;

        /// <summary>Resets the statics, which outlive play mode if domain reload is switched off.</summary>
        [RuntimeInitializeOnLoadMethod(RuntimeInitializeLoadType.SubsystemRegistration)]
        private static void BeginPlay()
        {
            EnabledManagers.Clear();
            Application.quitting -= Shutdown;
            Application.quitting += Shutdown;
            SweepstakeLibrary.Shutdown();
        }
    }
}
