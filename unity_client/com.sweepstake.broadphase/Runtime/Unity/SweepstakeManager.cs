#nullable enable
using System;
using System.Collections.Generic;
using Unity.Profiling;
using UnityEngine;
using UnityEngine.SceneManagement;

namespace Sweepstake.Unity
{
    /// <summary>
    /// The one component that a game needs: it owns a session, searches once a frame in what its <see cref="Source"/> has, and lets the game
    /// itself (the default), a daemon or nobody decide which backend does it. It works after the LateUpdate of the game's scripts. All members
    /// are for the main thread, and all events are raised on it. A frame never waits, and allocates nothing.
    /// </summary>
    [AddComponentMenu("Sweepstake/Sweepstake Manager")]
    [DisallowMultipleComponent]
    [DefaultExecutionOrder(10_000)]
    [DocumentationPage("components.md")]
    public sealed class SweepstakeManager : MonoBehaviour
    {
        [SerializeField]
        [Tooltip("How to search, to decide and, if at all, to speak to a daemon. None: the defaults, in the game itself.")]
        private SweepstakeConfig? config;
        [SerializeField]
        [Tooltip("Ai: the decider chooses the backend. Manual: you do, and nothing overrules you.")]
        private SessionMode mode = SessionMode.Ai;
        [SerializeField]
        [BackendName]
        [Tooltip("The backend to begin with, and the one of Manual. Empty: KDTree, or the first of the config's.")]
        private string backend = "";

        private readonly FrameFlagger flagger = new FrameFlagger();
        private readonly ChangeWatcher changes = new ChangeWatcher();
        private readonly Listeners<SweepstakeState> stateChanged = new Listeners<SweepstakeState>();
        private readonly Listeners<string> backendChanged = new Listeners<string>();
        private readonly Listeners<Verdict> verdictChanged = new Listeners<Verdict>();
        private readonly Listeners<Decision> decided = new Listeners<Decision>();
        private SessionHost? host;
        private IBroadPhaseSource? source;
        private SweepstakeConfig? defaults;
        private string trouble = "";
        private ulong endedNs;
        private bool isFailing;
        private bool mustBegin;

        /// <summary>The state is another one.</summary>
        public event Action<SweepstakeState>? StateChanged { add => stateChanged.Add(value); remove => stateChanged.Remove(value); }
        /// <summary>Another backend is active; by name.</summary>
        public event Action<string>? BackendChanged { add => backendChanged.Add(value); remove => backendChanged.Remove(value); }
        /// <summary>The verdict is of another kind; <see cref="Advice.Of(VerdictKind)"/> says what to do about it.</summary>
        public event Action<Verdict>? VerdictChanged { add => verdictChanged.Add(value); remove => verdictChanged.Remove(value); }
        /// <summary>There is a new decision.</summary>
        public event Action<Decision>? Decided { add => decided.Add(value); remove => decided.Remove(value); }

        /// <summary>The managers that are enabled, in the order of their enabling.</summary>
        public static IReadOnlyList<SweepstakeManager> Enabled => EnabledManagers;

        private static readonly List<SweepstakeManager> EnabledManagers = new List<SweepstakeManager>();

        /// <summary>Changes hold from the next enabling on. Null: the defaults.</summary>
        public SweepstakeConfig? Config { get => config; set => config = value; }

        /// <summary>The boxes to search in; null: there is nothing to search, and no frame is played.</summary>
        public IBroadPhaseSource? Source
        {
            get => source;
            set
            {
                source = value;
                flagger.Skip();
            }
        }

        /// <summary>Null while it is not running.</summary>
        public BroadPhaseSession? Session => host?.Session;
        public EmbeddedDecider? Decider => host?.Decider;
        public DaemonConnection? Connection => host?.Connection;
        /// <summary>In the session that runs: only then may its source still have pairs.</summary>
        internal bool HasSearched => host != null && endedNs != 0;

        public SweepstakeState State { get; private set; }
        /// <summary>What is wrong and what to do; "": nothing.</summary>
        public string Problem { get; private set; } = "";

        /// <summary>The names of the backends that may be chosen; empty while it is not running.</summary>
        public IReadOnlyList<string> Backends => host == null ? Array.Empty<string>() : host.Session.Arms;

        /// <summary>"" while it is not running.</summary>
        public string ActiveBackend => host == null ? "" : host.Session.Arms[host.Session.ActiveArm];

        /// <summary>Who chooses: Manual is never overruled.</summary>
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

        /// <summary>Chooses a backend by hand, from the next frame on; the mode stays, so that the decider may change it again.</summary>
        /// <exception cref="SweepstakeException">There is no such backend; the message lists them.</exception>
        public void SelectBackend(string name)
        {
            host?.Session.SelectArm(name);
            backend = name;
        }

        /// <summary>The game is loading: nothing is learnt from its frames.</summary>
        public bool IsLoading { get => flagger.IsLoading; set => flagger.IsLoading = value; }

        /// <summary>What was measured in the latest frame; zeros before the first.</summary>
        public FrameSample LastSample => host == null ? default : host.Session.LastSample;

        public Verdict Verdict => host == null ? default : host.Session.Verdict;

        /// <summary>The latest decision with its reasons.</summary>
        public Decision LastDecision => host == null ? default : host.Session.LastDecision;

        /// <summary>Lets the daemon of the config decide from the next frame on. From then on the game sends what privacy.md lists.</summary>
        public void Connect()
        {
            SweepstakeConfig settings = ConfigOrDefault();
            Guarded(() => Connect(DaemonTransport.Make(settings.daemon), settings.ToLinkOptions(gameObject.scene.name, Application.version)));
        }

        /// <summary>As <see cref="Connect()"/>, with a transport of the game's own.</summary>
        public void Connect(ITelemetryTransport transport, LinkOptions options)
        {
            if (host == null)
                throw new InvalidOperationException("Enable the manager first; its Problem says why it may not be.");
            host.DecideThere(transport, options);
        }

        /// <summary>Ends a connection, which sends what is left and takes half a second at most; the game decides itself again.</summary>
        public void Disconnect()
        {
            if (host != null)
                Guarded(host.DecideHere);
        }

        /// <summary>Writes a row for each frame from now on, on a thread of its own.</summary>
        /// <param name="path">A file there is replaced.</param>
        /// <exception cref="System.IO.IOException">The file cannot be written.</exception>
        public void StartCsv(string path, string scene = "", ulong seed = 0)
        {
            if (host == null)
                throw new InvalidOperationException("Enable the manager first; its Problem says why it may not be.");
            host.StartCsv(path, scene, seed);
        }

        /// <summary>Writes the rest of the rows, for which it waits two seconds at most.</summary>
        public void StopCsv() => host?.StopCsv();

        /// <summary>
        /// Ends the native side of every manager, and of whatever else the process has of it, in about half a second at most. May be called
        /// at any time between frames.
        /// </summary>
        public static void Shutdown()
        {
            // All at once, so that it is bounded whatever their number; what each has left then ends at once.
            ulong endNs = SessionHost.DeadlineNs();
            foreach (SweepstakeManager manager in EnabledManagers)
                manager.host?.BeginEnd();
            SweepstakeLibrary.Shutdown();
            // A listener may disable any of them meanwhile.
            for (int index = EnabledManagers.Count - 1; index >= 0; --index)
            {
                if (index < EnabledManagers.Count)
                    EnabledManagers[index].End(endNs);
            }
        }

        private void OnEnable()
        {
            EnabledManagers.Add(this);
            SceneManager.sceneLoaded += OnSceneLoaded;
            // Who begins anew whenever this fails may do so once a frame.
            mustBegin = isFailing;
            if (!isFailing)
                Guarded(Begin);
        }

        private void OnDisable()
        {
            SceneManager.sceneLoaded -= OnSceneLoaded;
            EnabledManagers.Remove(this);
            mustBegin = false;
            End();
        }

        private void OnDestroy()
        {
            if (defaults != null)
                Destroy(defaults);
        }

        /// <summary>What is set in the inspector while the game plays holds from the next frame on.</summary>
        private void OnValidate()
        {
            if (host == null)
                return;
            host.Session.Mode = mode;
            if (mode == SessionMode.Manual && backend.Length > 0)
                Guarded(() => host!.Session.SelectArm(backend));
        }

        private void OnApplicationPause(bool isPaused) => flagger.IsPaused = isPaused;

        private void OnApplicationFocus(bool hasFocus) => flagger.IsInBackground = !hasFocus && !Application.isEditor;

        private void LateUpdate()
        {
            if (mustBegin)
            {
                mustBegin = false;
                Guarded(Begin);
            }
            if (host == null)
                return;
            UpdateState();
            // A listener may have disabled this.
            if (host == null || source == null)
                return;
            try
            {
                PlayFrame(host, source);
            }
            catch (SweepstakeException problem)
            {
                Fail(problem);
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
                running.EndFrame(endedNs == 0 ? 1 : nowNs - endedNs, flagger.Take(Time.timeScale == 0));
                endedNs = nowNs;
            }
            SweepstakeProfiling.Show(session.LastSample);
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

        /// <summary>Until a listener ends the session.</summary>
        private void RaiseChanges(BroadPhaseSession session)
        {
            if (changes.HasOtherBackend(session))
                backendChanged.Tell(session.Arms[session.ActiveArm], this);
            if (Session == session && changes.HasNewDecision(session, out Decision decision))
                decided.Tell(decision, this);
            if (Session == session && changes.HasOtherVerdict(session, out Verdict verdict))
                verdictChanged.Tell(verdict, this);
        }

        private void Begin()
        {
            SweepstakeConfig settings = ConfigOrDefault();
            SweepstakeLibrary.EnsureLoaded();
            host = new SessionHost(settings, mode, backend, gameObject.scene.name, Tell);
            changes.Reset(host.Session);
            flagger.Skip();
            endedNs = 0;
            host.DecideHere();
            if (settings.daemon.isUsed)
                Connect();
            UpdateState();
        }

        private void End() => End(SessionHost.DeadlineNs());

        private void End(ulong endNs)
        {
            EndHost(endNs);
            SetState(SweepstakeState.Stopped, "");
        }

        private void EndHost(ulong endNs)
        {
            host?.End(endNs);
            host = null;
        }

        private void Fail(SweepstakeException problem)
        {
            EndHost(SessionHost.DeadlineNs());
            isFailing = true;
            SetState(SweepstakeState.Failed, problem.Message);
            isFailing = false;
        }

        /// <summary>What cannot be done is told, once; what worked before goes on.</summary>
        private void Guarded(Action action)
        {
            trouble = "";
            try
            {
                action();
            }
            catch (SweepstakeException problem)
            {
                if (host == null)
                {
                    Fail(problem);
                    return;
                }
                trouble = problem.Message;
                Tell(trouble);
            }
        }

        /// <summary>What is wrong although the frames go on.</summary>
        private void Tell(string problem) => Debug.LogError("Sweepstake: " + problem, this);

        private void UpdateState()
        {
            host!.TellFailures();
            ConnectionStatus? status = host.Connection?.Status;
            SetState(status == null ? SweepstakeState.Embedded : StateOf(status), ProblemOf(host, status));
        }

        /// <summary>The worst of what is wrong, as long as it is.</summary>
        private string ProblemOf(SessionHost running, ConnectionStatus? status)
        {
            if (running.WorkProblem.Length > 0)
                return running.WorkProblem;
            string away = status == null ? "" : status.Refusal.Length > 0 ? status.Refusal : status.LastError;
            if (away.Length > 0)
                return away;
            return trouble.Length > 0 ? trouble : running.CsvProblem;
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
            Log(state, problem);
            stateChanged.Tell(state, this);
        }

        /// <summary>One line for each change that somebody has to know of.</summary>
        private void Log(SweepstakeState state, string problem)
        {
            if (state == SweepstakeState.Failed)
                Debug.LogError("Sweepstake: " + problem, this);
            else if (state == SweepstakeState.Offline || state == SweepstakeState.Refused)
                Debug.LogWarning($"Sweepstake: the daemon is away ({state}). {problem}", this);
            else if (state == SweepstakeState.Online)
                Debug.Log("Sweepstake: the daemon decides.", this);
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

        private void OnSceneLoaded(Scene scene, LoadSceneMode how) => flagger.Skip();

        /// <summary>With domain reload switched off, statics outlive play mode.</summary>
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
